// Validation, Fig. 7: targets that were never fitted are commanded on the real robot with
// nominal, identified and fully compensated angles, measured again, and the error really
// reached is told, equation (41). A session of its own holds the samples, raw as any other.
//
// Each way has a pass of its own over all targets: commanded in turn at one target, a way would
// be measured after the short move from another way's angles, and a backlash would be that of
// this move. Each joint comes to each target from a stated side, by a lead-in move: from the
// side that it came from when the target was measured before, so that all ways meet the same.
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
#include "studies/extended_command.h"

namespace sixdial::studies {

inline constexpr int kValidationSchemaVersion = 1;

struct ValidationRequest {
  std::string set = "G2";  // of the calibrated session: its targets
  std::vector<CompensateBy> by{
      CompensateBy::kBefore, CompensateBy::kKinematics, CompensateBy::kFull};
};

/// "G2.full": the set that one way's samples are stored under.
[[nodiscard]] std::string validation_set(const std::string& set, CompensateBy by);

/// The pass of one way: every target of the request, in the order of the calibrated session.
/// `diagnosis` is needed if `by` is_extended(); its causes are taken as at `moment`. Throws
/// StudyError bad_data: the set has no targets, or a target has no solution.
[[nodiscard]] session::Plan validation_pass(
    const session::Session& calibrated, const CalibrationResult& calibration,
    const ValidationRequest& request, CompensateBy by,
    const DiagnosisResult* diagnosis = nullptr, const PlanMoment& moment = {});

/// All passes of the request, one after the other.
[[nodiscard]] session::Plan validation_plan(
    const session::Session& calibrated, const CalibrationResult& calibration,
    const ValidationRequest& request, const DiagnosisResult* diagnosis = nullptr);

/// When a pass begins and how long a point takes, by the pass before it in the session that
/// holds the validation's samples so far; `now` where there is none. Times count from the first
/// sample of the calibrated session, and no further than twice its length: a drift is believed
/// for as long as it was seen.
[[nodiscard]] PlanMoment moment_of_pass(
    const session::Session& calibrated, const session::Session& validation,
    session::TimePoint now);

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
  std::optional<GainRow> predicted_gain{};  // of one that is_extended(): by the diagnosis
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
  /// "diagnosis" where positions were computed with what it says of the instrument
  /// (measured_positions.h); empty: as the rig file says.
  std::optional<std::string> positions_by{};
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

/// `diagnosis`: predicts the ways that are is_extended(); null: none of them was commanded.
/// `validation`: what was measured. Numbers of results and troubles are the caller's to add.
[[nodiscard]] ValidationResult validation_result(
    const session::Session& calibrated, const CalibrationResult& calibration,
    const session::Session& validation, const ValidationRequest& request,
    const DiagnosisResult* diagnosis = nullptr);

}  // namespace sixdial::studies
