// All methods on one session: Table 6 for G1 and G2 with times, what the data can tell, which
// readings stand out. The same code for the service's job and for `sixdial compare BUNDLE`.
//
// Example:
//   const ComparisonResult result = compare(session, {.methods = {"before", "lm", "lm+gp"}});
//   for (const ComparedRow& row : result.methods) show(row.id);
//   result.methods.size();  // -> 3U
#pragma once

#include <cstdint>
#include <optional>
#include <stop_token>
#include <string>
#include <utility>
#include <vector>

#include "calibration/comparison.h"
#include "diagnosis/rig_seen.h"
#include "session/session.h"
#include "studies/assessment.h"
#include "studies/inputs.h"
#include "studies/plausibility.h"
#include "studies/progress.h"

namespace sixdial::studies {

inline constexpr int kComparisonSchemaVersion = 1;

struct CompareRequest {
  std::vector<std::string> methods{};  // empty: calibration::kComparedMethods
  std::string space = "positions";     // or "dials"
  std::vector<std::string> fix{};      // parameters that keep their nominal value
  std::vector<std::string> free{};     // where not empty: only these are fitted
  std::string loss = "square";         // of lm: "huber", "cauchy"
  calibration::Profile profile = calibration::Profile::kDefault;
  bool keep_gross_errors = false;  // list them only
  std::uint64_t seed = 1;
  int threads = 0;  // 0: as many as the machine has; the result does not depend on it
  // Instead of 50x100, 50x400, 500 and 40000.
  std::optional<int> particles{}, qpso1_iterations{}, qpso2_iterations{}, anfis_epochs{},
      bpnn_epochs{};
};

/// What was asked for and what it came to.
struct ComparisonChoices {
  std::string space{}, loss{};  // as in the request
  calibration::Profile profile = calibration::Profile::kDefault;
  std::vector<std::string> fixed{};  // parameters that kept their nominal value
  bool gross_errors_set_aside = true;
  double noise_mm = 0.0;  // of one reading, to judge what is determined
  double hold_uncertainty_mm = 0.0;
  double first_variance = 0.0;  // Q and R of `ekf`
  calibration::SwarmSize qpso1{}, qpso2{};
  int anfis_epochs = 0, bpnn_epochs = 0;
};

struct ComparedParameter {
  double value = 0.0;  // mm or rad
  double sd = 0.0;     // includes the prior uncertainty of undetermined directions
  /// Leans on the nominal value. Empty in results of early versions, whose sd leaves that out.
  std::optional<bool> partly_held{};
};

/// What a method's identifier found.
struct ComparedRobot {
  calibration::FitStatus status = calibration::FitStatus::kConverged;
  int iterations = 0;
  double objective_rmse_mm = 0.0;
  std::vector<std::pair<std::string, ComparedParameter>> parameters{};  // by name
};

/// What a method's residual model made of what was left.
struct ComparedResidual {
  std::string note{};                      // what it chose, for people
  Eigen::VectorXd effective_parameters{};  // by output: x, y
};

/// A row of Table 6 with what is behind it.
struct ComparedRow {
  std::string id{};                                    // "ekf_dqpso+anfis"
  std::string name{};                                  // "EKF-DQPSO + ANFIS"
  std::string description{};                           // of both parts
  std::optional<std::string> identifier{};             // empty: "before"
  std::optional<std::string> residual_model{};         // empty: none
  std::optional<calibration::ErrorStats> g1{}, g2{};   // empty: no such samples
  std::vector<double> g1_errors_mm{}, g2_errors_mm{};  // NaN: a pose out of reach
  double identify_seconds = 0.0, residual_seconds = 0.0;
  std::optional<ComparedRobot> robot{};        // where there is an identifier
  std::optional<ComparedResidual> residual{};  // where there is a residual model

  [[nodiscard]] double seconds() const { return identify_seconds + residual_seconds; }
};

struct ComparisonResult {
  std::string created_utc{};
  Inputs inputs{};
  ComparisonChoices choices{};
  bool before_uses_targets = false;    // "before" is measured minus target, else minus nominal
  std::vector<ComparedRow> methods{};  // in the order asked for
  /// Id of the method with the lowest mean on G2 among those that reach all its poses; on G1
  /// where there is none such. Empty: no method reaches all poses of a set.
  std::optional<std::string> best{};
  double least_squares_rmse_mm = 0.0;
  /// The rig as the readings see it, which every method was given; empty where the file states
  /// nothing of it, or in results of early versions.
  std::optional<std::vector<diagnosis::RigSeen>> rig{};
  Assessment assessment{};
  std::optional<Precision> precision{};  // empty: one of the two spaces leaves something open
  GrossErrors gross_errors{};
  /// What speaks against the session; empty in results of early versions.
  std::optional<std::vector<Warning>> warnings{};
  double seconds = 0.0;
};

/// Throws StudyError: invalid_params (an unknown method or parameter, with the nearest),
/// bad_data, cancelled.
[[nodiscard]] ComparisonResult compare(
    const session::Session& session, const CompareRequest& request,
    const ProgressCallback& progress = {}, std::stop_token stop = {});

/// Throws StudyError invalid_params for a method or combination that does not exist.
void check_methods(const std::vector<std::string>& methods);

}  // namespace sixdial::studies
