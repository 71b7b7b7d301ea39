#include "calibration/identifier.h"

#include <array>
#include <cmath>
#include <utility>

#include "calibration/registry.h"

namespace sixdial::calibration {

extern const Identifier lse;
extern const Identifier lse_iterated;
extern const Identifier lm;
extern const Identifier tikhonov;
extern const Identifier ekf;
extern const Identifier ekf_qpso1;
extern const Identifier ekf_dqpso;

namespace {

using Eigen::MatrixXd;
using Eigen::VectorXd;

constexpr std::array kTable{&lse, &lse_iterated, &lm, &tikhonov, &ekf, &ekf_qpso1, &ekf_dqpso};

constexpr int kToMinimum = 100;  // iterations

using Identifiers = Registry<Identifier, IdentifyFunction>;
Identifiers& identifiers() {
  static Identifiers registry(kTable);
  return registry;
}

Identified called(
    const Identifier& identifier, const ObservationSpace& space,
    const IdentifySettings& settings, const SearchProgress& progress,
    const std::stop_token& stop) {
  return identifier.made != nullptr ? (*identifier.made)(space, settings, progress, stop)
                                    : identifier.identify(space, settings, progress, stop);
}

}  // namespace

std::vector<const Identifier*> all_identifiers() { return identifiers().all(); }

const Identifier* find_identifier(std::string_view name) { return identifiers().find(name); }

const Identifier& add_identifier(
    std::string name, std::string description, IdentifyFunction identify) {
  return identifiers().add(std::move(name), std::move(description), std::move(identify));
}

bool is_fixed(const IdentifySettings& settings, int parameter) {
  return is_fixed(settings.fixed, parameter);
}

Weighting weighting_of(const ObservationSpace& space, const IdentifySettings& settings) {
  return settings.weighted || !space.rows_belong_together ? Weighting::kBySigma
                                                          : Weighting::kAlike;
}

LeastSquaresSettings core_settings(
    const ObservationSpace& space, const IdentifySettings& settings) {
  LeastSquaresSettings core;
  core.first_damping = 1e-7;  // nominal is near
  core.scale = space.scale();
  core.anchor = space.nominal;
  core.fixed = settings.fixed;
  core.hold_below = settings.noise_mm / settings.hold_uncertainty_mm;
  return core;
}

Identified identify(
    const Identifier& identifier, const ObservationSpace& space,
    const IdentifySettings& settings, const SearchProgress& progress,
    const std::stop_token& stop) {
  Identified result = called(identifier, space, settings, progress, stop);
  result.rmse = space.rmse(result.x);
  LeastSquaresSettings core = core_settings(space, settings);
  core.max_iterations = 0;
  result.fit =
      solve_least_squares(space.problem(weighting_of(space, settings)), result.x, core);
  if (result.fit.status == FitStatus::kBadStart) {
    result.status = FitStatus::kBadStart;
    result.covariance = MatrixXd::Zero(space.parameters(), space.parameters());
    return result;
  }
  double residual_variance = result.fit.variance();
  if (result.unit_covariance.size() > 0) {
    // One pass leaves more than noise: what noise is shows at the minimum.
    core.max_iterations = kToMinimum;
    const LeastSquaresProblem problem = space.problem(weighting_of(space, settings));
    residual_variance = solve_least_squares(problem, result.x, core).variance();
  }
  result.sigma_mm = std::sqrt(residual_variance);
  const double variance =
      result.sigma_mm > 0.0 ? residual_variance : settings.noise_mm * settings.noise_mm;
  result.covariance =
      variance * (result.unit_covariance.size() > 0 ? result.unit_covariance
                                                    : result.fit.unit_covariance());
  return result;
}

Identified qpso1_in(
    const ObservationSpace& space, const IdentifySettings& settings,
    const SearchProgress& progress, const std::stop_token& stop) {
  NoiseSearchSettings search;
  search.swarm = settings.qpso1;
  search.linearisation = settings.linearisation;
  search.p0 = VectorXd::Constant(space.parameters(), settings.p0);
  search.first_log10 = std::log10(settings.first_variance);
  search.fixed = settings.fixed;
  search.seed = settings.seed;
  search.threads = settings.threads;
  const NoiseSearch found = search_noise(space, search, progress, stop);
  Identified result;
  result.x = found.run.v;
  result.history = found.search.history;
  result.iterations = static_cast<int>(found.search.history.size()) - 1;
  result.cancelled = found.search.cancelled;
  const VectorXd p0 = diagonal_of(search.p0, space.parameters(), 1.0, settings.fixed);
  static_cast<void>(
      filter_errors(space, {settings.linearisation, p0, found.noise}, &result.unit_covariance));
  return result;
}

Identified qpso2_in(
    const ObservationSpace& space, const VectorXd& estimate, const IdentifySettings& settings,
    const SearchProgress& progress, const std::stop_token& stop) {
  ParameterSearchSettings search;
  search.swarm = settings.qpso2;
  search.coordinates = settings.coordinates;
  search.noise_mm = settings.noise_mm;
  search.hold_uncertainty_mm = settings.hold_uncertainty_mm;
  search.weighting = weighting_of(space, settings);
  search.fixed = settings.fixed;
  search.seed = settings.seed;
  search.threads = settings.threads;
  const ParameterSearch found = search_parameters(space, estimate, search, progress, stop);
  Identified result;
  result.x = found.v;
  result.history = found.search.history;
  result.iterations = static_cast<int>(found.search.history.size()) - 1;
  result.cancelled = found.search.cancelled;
  return result;
}

}  // namespace sixdial::calibration
