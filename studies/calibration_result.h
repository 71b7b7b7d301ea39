// What a calibration found, as values. Words are made from them in report/words/, the document
// "sixdial.calibration" in report/documents/calibration_json.h. Lists have as many parameters
// as the session's robot.
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "calibration/pipeline.h"
#include "diagnosis/rig_seen.h"
#include "studies/assessment.h"
#include "studies/cross_validation.h"
#include "studies/inputs.h"
#include "studies/measured_joints.h"
#include "studies/plausibility.h"
#include "studies/stored_residual.h"
#include "studies/turn_errors.h"
#include "studies/uncertainty_budget.h"

namespace sixdial::studies {

/// The paper's method, what `calibrate` does unless it is told otherwise.
inline constexpr std::string_view kPaperMethod = "ekf_dqpso+anfis";

/// Absolute position errors over a set, equation (41), with the 95 % interval of the mean (NaN
/// for one point).
struct SetErrors {
  double mean_mm = 0.0, std_mm = 0.0, max_mm = 0.0, rmse_mm = 0.0;
  double mean_low_mm = 0.0, mean_high_mm = 0.0;
  int points = 0;
  int unreachable = 0;  // poses out of the parameters' reach; not in the figures
};

/// A row of Table 6.
struct MethodRow {
  std::string id{};                     // "before", "ekf_dqpso", "lm+gp"
  std::optional<SetErrors> g1{}, g2{};  // empty: no such samples
  std::optional<double> seconds{};      // of all stages up to this one
};

struct StageRow {
  std::string name{};  // id of the method that ends with this stage
  Eigen::VectorXd parameters{};
  double rmse_g1_mm = 0.0;
  double seconds = 0.0;  // of this stage alone
};

/// A search's best objective by iteration, Fig. 8; [0] is the start.
struct Convergence {
  std::string name{};  // "QPSO-1"
  std::vector<double> best_mm{};
};

/// Parameters identified so far minus nominal, by step, Fig. 9.
struct Trace {
  std::string name{};  // "EKF", "QPSO-2"
  std::string step{};  // "point", "iteration"
  std::vector<Eigen::VectorXd> error{};
};

struct Identification {
  double sigma_mm = 0.0;  // of one measured axis
  int degrees_of_freedom = 0;
  Eigen::MatrixXd covariance{};  // of the parameters
  Eigen::VectorXd singular_values{};
  double condition = 0.0, observability = 0.0;
  std::vector<HeldRow> held{};
  std::vector<CorrelationRow> correlations{};
};

/// The two networks of the paper's method, of the residual in x and in y.
struct Networks {
  calibration::AnfisReport x{}, y{};
};

/// Measured minus modelled position of one sample by each row of `methods`; empty where the
/// pose cannot be reached.
struct PointResiduals {
  int sample = 0;  // row of the session
  std::string set{};
  int point = 0, repeat = 0;
  Eigen::VectorXd measured_mm{};  // in W
  std::vector<std::optional<Eigen::VectorXd>> residual_mm{};
};

/// Whether an error keeps a tolerance (studies/conformity.h).
enum class Decision { kAccepted, kRejected, kUndecided };

/// Every point of a set against the tolerance; the whole is accepted if each point is, and
/// rejected if one is.
struct Conformity {
  double tolerance_mm = 0.0;
  std::string set{};      // whose points were judged: G2 where there are any, else G1
  bool validated = true;  // false: G1, whose points were fitted; then nothing is accepted
  int points = 0, accepted = 0, rejected = 0;
  double largest_mm = 0.0;   // error of the point with the largest error + U
  double expanded_mm = 0.0;  // U of that point; NaN: nobody knows it
  Decision decision = Decision::kUndecided;
};

struct CalibrationResult {
  std::string created_utc{};
  Inputs inputs{};
  calibration::PipelineSettings settings{};
  std::string result_method{kPaperMethod};  // what is delivered: id of a row of `methods`
  std::vector<ParameterRow> parameters{};   // Table 2
  Identification identification{};
  std::vector<MethodRow> methods{};  // Table 6, "before" first
  bool before_uses_targets = false;  // "before" is measured minus target, else minus nominal
  double rmse_mm = 0.0;              // of the identified parameters on G1
  double least_squares_rmse_mm = 0.0, above_minimum_mm = 0.0;
  std::optional<calibration::FilterNoise> noise{};  // of QPSO-1, where it was searched for
  std::int64_t not_finite_evaluations = 0;
  double seconds = 0.0;
  std::vector<StageRow> stages{};
  std::vector<Convergence> convergence{};
  std::vector<Trace> traces{};
  std::optional<Networks> networks{};                   // of the paper's method
  std::optional<StoredResidualModel> residual_model{};  // of every other one that has one
  std::vector<PointResiduals> points{};                 // G1, then G2
  /// Against the tolerance of the request or of the rig file; empty: none was stated.
  std::optional<Conformity> conformity{};
  /// Of the tool's position; empty in results of early versions.
  std::optional<std::vector<UncertaintyBudget>> uncertainty_budgets{};
  /// The rig as the readings see it, whose positions these are; empty where the file states
  /// nothing of it, or in results of early versions.
  std::optional<std::vector<diagnosis::RigSeen>> rig{};
  /// Of a measured position, from the dials alone (studies/position_noise.h); empty as well in
  /// results of early versions.
  std::optional<double> position_noise_mm{};
  /// Of the tool's turn, where it was measured and can be fitted (only turns of G1 are); empty
  /// elsewhere, and in results of early versions.
  std::optional<std::vector<TurnErrors>> turn_errors{};
  /// Where the joints stood in G1; empty in results of early versions.
  std::optional<std::vector<MeasuredJoints>> measured_joints{};
  /// From the frame in which targets are given to that of the parameters; empty: the same.
  std::optional<geometry::Similarity> frame{};
  /// What speaks against the session; empty in results of early versions.
  std::optional<std::vector<Warning>> warnings{};
  // Empty in results of early versions.
  std::optional<Assessment> assessment{};
  std::optional<GrossErrors> gross_errors{};
  std::optional<Precision> precision{};  // empty too where there is nothing to compare
  std::optional<CrossValidation> cross_validation{};  // within G1; empty too with few samples

  /// The row of Table 6; null: there is none.
  [[nodiscard]] const MethodRow* method(std::string_view id) const;
  [[nodiscard]] Eigen::VectorXd nominal() const;
  [[nodiscard]] Eigen::VectorXd identified() const;
};

}  // namespace sixdial::studies
