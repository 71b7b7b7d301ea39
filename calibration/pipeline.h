// The paper's method from beginning to end: EKF, QPSO-1, QPSO-2, an ANFIS for each coordinate
// of the position, beside the least-squares minimum that the same objective has. G1 is fitted,
// G2 only judged.
//
//   const auto result = run_dqpso_anfis(position_space(g1, rig), position_space(g2, rig));
//   if (result) use(result->v, result->networks);
#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <stop_token>
#include <string>
#include <string_view>
#include <tl/expected.hpp>
#include <vector>

#include "calibration/anfis_learning.h"
#include "calibration/dqpso.h"
#include "calibration/identifiability.h"

namespace sixdial::calibration {

enum class Profile {
  kDefault,  // filter at its estimate, whitened search, network by cross-validation
  kPaper,    // as printed: filter linear at nominal, raw coordinates, six functions, ridge 1e-6
};
[[nodiscard]] std::string_view to_string(Profile profile);
[[nodiscard]] std::optional<Profile> profile_from(std::string_view text);

struct PipelineSettings {
  Profile profile = Profile::kDefault;
  std::uint64_t seed = 1;
  int threads = 1;
  Linearisation linearisation = Linearisation::kEstimate;
  SearchCoordinates coordinates = SearchCoordinates::kWhitened;
  FilterNoise first_noise;  // Q and R before QPSO-1; empty: 1e-4
  Eigen::VectorXd p0;       // diagonal of P0; empty: 1 everywhere
  SwarmSize qpso1{50, 100};
  SwarmSize qpso2{50, 400};
  AnfisSettings anfis;            // functions and ridge are replaced where cross_validate
  bool cross_validate = true;     // choose functions, ridge or no network at all
  double holdout_fraction = 0.2;  // of G1, for choosing the epoch
  std::vector<char> fixed;        // by parameter, 1: keeps its nominal value; empty: all free
  /// Standard deviation of one measured axis, to judge what can be determined, where there are
  /// no repeats to tell.
  double noise_mm = 0.003;
};
[[nodiscard]] PipelineSettings settings_for(Profile profile);

enum class PipelineStage {
  kFilter,
  kNoiseSearch,
  kParameterSearch,
  kReference,
  kResidual,
  kReport
};
[[nodiscard]] std::string_view to_string(PipelineStage stage);

struct PipelineProgress {
  PipelineStage stage = PipelineStage::kFilter;
  double fraction = 0.0;  // of the whole calibration, 0..1
  int iteration = 0;      // of a search
  int iterations = 0;
  double rmse_mm = 0.0;  // best so far, 0 before there is one
};
using PipelineProgressCallback = std::function<void(const PipelineProgress&)>;

struct ErrorStats {
  int count = 0;
  double mean_mm = 0.0;
  double std_mm = 0.0;  // n - 1
  double max_mm = 0.0;
  double rmse_mm = 0.0;
  int unreachable = 0;  // poses the parameters cannot reach; not in the figures
};
[[nodiscard]] ErrorStats error_stats(std::span<const double> errors_mm);

/// One row of Table 6: absolute position errors (41), by sample in the order given; NaN where a
/// pose cannot be reached.
struct MethodErrors {
  std::string method;  // "before", "ekf", "ekf_qpso1", "ekf_dqpso", "ekf_dqpso+anfis", "lm"
  std::vector<double> g1_mm;
  std::vector<double> g2_mm;
  ErrorStats g1;
  ErrorStats g2;
};

/// From errors coordinate by coordinate, axes x samples.
[[nodiscard]] MethodErrors method_errors(
    std::string method, const Eigen::MatrixXd& g1_mm, const Eigen::MatrixXd& g2_mm);

struct StageResult {
  std::string name;  // "ekf", "ekf_qpso1", "ekf_dqpso", "lm"
  Eigen::VectorXd v;
  double rmse_g1_mm = 0.0;
  double seconds = 0.0;  // of this stage alone
};

struct Result {
  PipelineSettings settings;  // as used: p0, first_noise and fixed have their full length
  Eigen::VectorXd nominal;
  std::vector<StageResult> stages;
  FilterNoise noise;  // of QPSO-1
  Eigen::VectorXd v;  // identified (QPSO-2)
  Eigen::MatrixXd covariance;
  double sigma_mm = 0.0;  // of one measured axis, from the residuals
  int degrees_of_freedom = 0;
  std::vector<ParameterEstimate> parameters;  // Table 2
  Identifiability identifiability;
  /// RMSE of DQPSO minus that of the least-squares minimum [mm]; about 0 when converged.
  double above_minimum_mm = 0.0;
  FitStatus lm_status = FitStatus::kConverged;
  int lm_iterations = 0;

  std::vector<double> qpso1_history_mm;  // Fig. 8; entry 0 is the start
  std::vector<double> qpso2_history_mm;
  std::vector<Eigen::VectorXd> filter_history;  // Fig. 9: errors after each sample
  std::vector<Eigen::VectorXd> qpso2_history;   // parameter errors by iteration
  std::int64_t not_finite = 0;                  // particles that counted as infinitely bad

  std::vector<AnfisReport> networks;  // by coordinate of the position
  std::vector<MethodErrors> table_6;
  std::vector<int> g1_sample;  // rows of the session, as the errors
  std::vector<int> g2_sample;
  bool before_uses_targets = false;  // else measured - f(nominal)
  double anfis_seconds = 0.0;
  double total_seconds = 0.0;

  [[nodiscard]] const StageResult& stage(std::string_view name) const;
  [[nodiscard]] const MethodErrors& errors(std::string_view method) const;
};

struct Trouble {
  enum class Kind { kTooFewSamples, kUnreachable, kNotPossible, kCancelled } kind;
  std::string message;  // what, where, what to do
};

/// Both spaces are of positions, with the same parameters.
[[nodiscard]] tl::expected<Result, Trouble> run_dqpso_anfis(
    const ObservationSpace& g1, const ObservationSpace& g2,
    const PipelineSettings& settings = {}, const PipelineProgressCallback& progress = {},
    std::stop_token stop = {});

/// Why these samples cannot be calibrated with; empty: they can.
[[nodiscard]] std::optional<Trouble> trouble_with(const ObservationSpace& g1);

/// The errors that a robot has before it is calibrated, axes x samples [mm]: measured minus
/// target where `targets`, else minus the nominal model.
[[nodiscard]] Eigen::MatrixXd errors_before(const ObservationSpace& space, bool targets);
[[nodiscard]] bool all_have_targets(const ObservationSpace& space);

}  // namespace sixdial::calibration
