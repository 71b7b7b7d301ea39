// Validation, Fig. 7: targets that were never fitted are commanded on the real robot with
// nominal, identified and fully compensated angles, measured again, and the error really
// reached is told, equation (41). A session of its own holds the samples, raw as any other.
//
// Example:
//   const CalibrationResult result = calibrate(session, {.method = "lm"});
//   const session::Plan plan = validation_plan(session, result, {});
//   const session::Session again = measured(plan);  // by the rig, a session of its own
//   const ValidationResult validated = validation_result(session, result, again, {});
//   validated.methods.size();  // -> 3U
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "session/session.h"
#include "studies/compensate.h"
#include "studies/diagnosis_result.h"

namespace sixdial::studies {

inline constexpr int kValidationSchemaVersion = 1;

struct ValidationRequest {
  std::string set = "G2";  // of the calibrated session: its targets
  std::vector<CompensateBy> by{
      CompensateBy::kBefore, CompensateBy::kKinematics, CompensateBy::kFull};
};

/// "G2.full": the set that one way's samples are stored under.
[[nodiscard]] std::string validation_set(const std::string& set, CompensateBy by);

/// Each target is commanded in every way of the request before the next one, so that drift does
/// not favour a way. `diagnosis` is needed if the request has kExtended. Throws StudyError
/// bad_data: the set has no targets, or a target has no solution.
[[nodiscard]] session::Plan validation_plan(
    const session::Session& calibrated, const CalibrationResult& calibration,
    const ValidationRequest& request, const DiagnosisResult* diagnosis = nullptr);

struct ReachedErrors {
  double mean_mm = 0.0, std_mm = 0.0, max_mm = 0.0, rmse_mm = 0.0;
  int points = 0;
};

/// One way of commanding, and what came of it.
struct ValidatedWay {
  CompensateBy by = CompensateBy::kBefore;
  std::string set{};                        // that holds its samples
  std::optional<ReachedErrors> errors{};    // empty: nothing was measured
  std::optional<SetErrors> predicted{};     // by the calibration, on its G2
  std::optional<GainRow> predicted_gain{};  // of kExtended: by the diagnosis
  int without_position = 0;                 // samples whose dials give none

  [[nodiscard]] std::optional<double> predicted_mean_mm() const;
};

struct ValidatedPoint {
  CompensateBy by = CompensateBy::kBefore;
  int point = 0;
  Eigen::VectorXd target_mm{};
  std::vector<double> theta_rad{};  // commanded, joint by joint
  Eigen::VectorXd error_mm{};       // measured minus target, equation (41)
};

/// A point of the plan without a sample.
struct NotMeasured {
  std::string set{};
  int point = 0;
  int repeat = 0;
  std::string why{};
};

struct ValidationInputs {
  std::string session{};  // that was calibrated
  std::string set{};      // whose targets were commanded again
  std::string calibration_data_hash{};
  std::optional<std::string> calibration_method{};   // empty: the paper's
  std::optional<std::int64_t> calibration_result{};  // numbers in the database
  std::optional<std::int64_t> diagnosis_result{};
  std::string validation_session{};  // that holds what was measured
  std::string rig_hash{}, data_hash{};
  std::string version{};
};

struct ValidationResult {
  std::string created_utc{};
  ValidationInputs inputs{};
  std::vector<ValidatedWay> methods{};
  std::vector<ValidatedPoint> points{};
  std::vector<NotMeasured> troubles{};
};

/// `diagnosed_gain`: what a diagnosis predicts of the extended model.
/// `validation`: what was measured. Numbers of results and troubles are the caller's to add.
[[nodiscard]] ValidationResult validation_result(
    const session::Session& calibrated, const CalibrationResult& calibration,
    const session::Session& validation, const ValidationRequest& request,
    const std::optional<GainRow>& diagnosed_gain = std::nullopt);

}  // namespace sixdial::studies
