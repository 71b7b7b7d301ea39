#include "calibration/dqpso.h"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>

#include "calibration/random.h"

namespace sixdial::calibration {
namespace {

using Eigen::MatrixXd;
using Eigen::VectorXd;

// Of a space's two streams of random numbers.
constexpr std::uint32_t kNoiseSearch = 0;
constexpr std::uint32_t kParameterSearch = 1;
constexpr std::uint32_t kStartStream = 16;  // added for the first positions
// Whitening assumes at least this much noise, so that exact data do not give an empty spread.
constexpr double kLeastNoise_mm = 1e-6;
// Rounding leaves this much of a variance that is zero.
constexpr double kFixedVariance = 1e-20;

// ---- QPSO-1

/// Q and R of a particle, one below the other.
VectorXd noise_of(
    const Eigen::Ref<const VectorXd>& log10_noise, int parameters,
    const std::vector<char>& fixed) {
  VectorXd noise(log10_noise.size());
  for (int i = 0; i < noise.size(); ++i) {
    const bool still = i < parameters && is_fixed(fixed, i);
    noise[i] = still ? 0.0 : std::pow(10.0, log10_noise[i]);
  }
  return noise;
}

/// Where the filter with this noise ends; NaN where it broke.
VectorXd filtered(
    const ObservationSpace& space, const FilterSettings& like,
    const Eigen::Ref<const VectorXd>& noise) {
  FilterSettings settings = like;
  settings.noise = {noise.head(space.parameters()), noise.tail(space.channels())};
  return space.nominal + filter_errors(space, settings);
}

/// Equation (29) of each column of `noise`.
void noise_objective(
    const ObservationSpace& space, const FilterSettings& filter, const MatrixXd& noise,
    Eigen::Ref<Eigen::ArrayXd> values) {
  if (space.kernels && space.kernels->filter && space.kernels->rmse) {
    MatrixXd x;
    space.kernels->filter(filter.linearisation, filter.p0, noise, x);
    x.colwise() += space.nominal;
    space.kernels->rmse(x, values);
    return;
  }
  for (Eigen::Index i = 0; i < noise.cols(); ++i) {
    const VectorXd x = filtered(space, filter, noise.col(i));
    values[i] = x.allFinite() ? space.rmse(x) : HUGE_VAL;
  }
}

/// First positions: all of the first particle at first_log10, the others around it.
Eigen::ArrayXXd first_noise(
    const NoiseSearchSettings& settings, int dimensions, std::uint32_t stream) {
  Eigen::ArrayXXd start(settings.swarm.particles, dimensions);
  start.setConstant(settings.first_log10);
  for (int i = 1; i < settings.swarm.particles; ++i) {
    for (int k = 0; k < dimensions; ++k) {
      start(i, k) +=
          settings.spread_decades * random_normal(
                                        settings.seed, static_cast<std::uint32_t>(i), 0,
                                        static_cast<std::uint32_t>(k), stream + kStartStream);
    }
  }
  return start;
}

// ---- QPSO-2

/// Search coordinates z, x = origin + L z.
struct Coordinates {
  VectorXd origin;  // the estimate, with what cannot be determined put back to nominal
  MatrixXd L;
  int held = 0;
  [[nodiscard]] VectorXd parameters(const VectorXd& z) const { return origin + L * z; }
};

/// What a filter without process noise says at `estimate`: covariance of the parameters in
/// units of their scale.
MatrixXd scaled_covariance(
    const ObservationSpace& space, const VectorXd& estimate,
    const ParameterSearchSettings& settings) {
  const VectorXd scale = space.scale();
  FilterSettings filter;
  filter.linearisation = Linearisation::kNominal;
  filter.p0 = diagonal_of(
      (settings.hold_uncertainty_mm * scale).cwiseAbs2(), space.parameters(), 1.0,
      settings.fixed);
  filter.noise.q = VectorXd::Zero(space.parameters());
  filter.noise.r = VectorXd::Constant(space.channels(), settings.noise_mm * settings.noise_mm);
  if (settings.weighting != Weighting::kAlike) {
    const double mean_sigma = space.mean_sigma();
    for (int row = 0; row < space.rows(); ++row) {
      const double sigma_mm = settings.noise_mm * space.sigma_mm[row] / mean_sigma;
      filter.noise.r[space.channel[static_cast<std::size_t>(row)]] = sigma_mm * sigma_mm;
    }
  }
  const MatrixXd P = run_filter_from(space, estimate, filter).P;
  return scale.cwiseInverse().asDiagonal() * P * scale.cwiseInverse().asDiagonal();
}

/// The long valley becomes a bowl: `rmse_mm`, of the objective at the estimate, says how far
/// away the minimum may be.
Coordinates whitened_at(
    const ObservationSpace& space, const VectorXd& estimate, double rmse_mm,
    const ParameterSearchSettings& settings) {
  const double rows_a_sample = static_cast<double>(space.rows()) / std::max(space.samples(), 1);
  const double widen =
      std::isfinite(rmse_mm)
          ? std::max(rmse_mm / std::sqrt(rows_a_sample), kLeastNoise_mm) / settings.noise_mm
          : HUGE_VAL;
  const VectorXd scale = space.scale();
  const Eigen::SelfAdjointEigenSolver<MatrixXd> eigen(
      scaled_covariance(space, estimate, settings));
  const int n = space.parameters();
  Coordinates result{estimate, MatrixXd::Zero(n, n), 0};
  const double most = settings.hold_uncertainty_mm;
  for (int k = 0; k < n; ++k) {
    const VectorXd direction = eigen.eigenvectors().col(k);
    const double variance = eigen.eigenvalues()[k];
    if (variance <= kFixedVariance * most * most) continue;  // a fixed parameter
    if (variance < most * most / 2) {
      const double spread = std::min(std::sqrt(variance) * widen, most);
      result.L.col(k) = scale.cwiseProduct(direction) * spread;
    } else {
      // The data say little beyond what was assumed: hold it.
      ++result.held;
      const double along = direction.dot((space.nominal - estimate).cwiseQuotient(scale));
      result.origin += scale.cwiseProduct(direction) * along;
    }
  }
  for (int i = 0; i < n; ++i) {
    if (!is_fixed(settings.fixed, i)) continue;
    result.L.row(i).setZero();
    result.origin[i] = estimate[i];
  }
  return result;
}

/// Equation (31) at x.
double one_objective(
    const ObservationSpace& space, const LeastSquaresProblem& problem, Weighting weighting,
    const VectorXd& x) {
  if (weighting == Weighting::kAlike) return space.rmse(x);
  VectorXd r(space.rows());
  return problem.evaluate(x, r, nullptr) ? std::sqrt(r.squaredNorm() / space.samples())
                                         : HUGE_VAL;
}

/// Equation (31) of each column of x.
void parameter_objective(
    const ObservationSpace& space, const LeastSquaresProblem& problem, Weighting weighting,
    const MatrixXd& x, Eigen::Ref<Eigen::ArrayXd> values) {
  if (weighting == Weighting::kAlike && space.kernels && space.kernels->rmse) {
    space.kernels->rmse(x, values);
    return;
  }
  for (Eigen::Index i = 0; i < x.cols(); ++i) {
    values[i] = one_objective(space, problem, weighting, x.col(i));
  }
}

/// First positions: the estimate itself, the others around it.
Eigen::ArrayXXd first_parameters(
    const ObservationSpace& space, const ParameterSearchSettings& settings,
    std::uint32_t stream) {
  const bool raw = settings.coordinates == SearchCoordinates::kRaw;
  const VectorXd spread = settings.raw_spread * space.scale();
  Eigen::ArrayXXd start = Eigen::ArrayXXd::Zero(settings.swarm.particles, space.parameters());
  for (int i = 1; i < settings.swarm.particles; ++i) {
    for (int k = 0; k < space.parameters(); ++k) {
      const auto a = static_cast<std::uint32_t>(i);
      const auto c = static_cast<std::uint32_t>(k);
      if (!raw) {
        start(i, k) = settings.whitened_spread *
                      random_normal(settings.seed, a, 0, c, stream + kStartStream);
      } else if (!is_fixed(settings.fixed, k)) {
        const auto w = random_words(settings.seed, a, 0, c, stream + kStartStream);
        start(i, k) = spread[k] * (2.0 * open_unit(w[0], w[1]) - 1.0);
      }
    }
  }
  return start;
}

/// A box around nominal, for raw coordinates.
void bound(
    const ObservationSpace& space, const VectorXd& estimate,
    const ParameterSearchSettings& settings, QpsoSettings& search) {
  const VectorXd reach = settings.raw_bound * settings.raw_spread * space.scale();
  const VectorXd offset = space.nominal - estimate;
  search.lower = (offset - reach).cwiseMin(0.0);
  search.upper = (offset + reach).cwiseMax(0.0);
  for (int k = 0; k < space.parameters(); ++k) {
    if (is_fixed(settings.fixed, k)) search.lower[k] = search.upper[k] = 0.0;
  }
}

}  // namespace

NoiseSearch search_noise(
    const ObservationSpace& space, const NoiseSearchSettings& settings,
    const SearchProgress& progress, std::stop_token stop) {
  const int n = space.parameters();
  const int dimensions = n + space.channels();
  FilterSettings filter;
  filter.linearisation = settings.linearisation;
  filter.p0 = diagonal_of(settings.p0, n, 1.0, settings.fixed);

  const auto objective = [&](const SwarmRows& particles, Eigen::Ref<Eigen::ArrayXd> values) {
    MatrixXd noise(dimensions, particles.rows());
    for (Eigen::Index i = 0; i < particles.rows(); ++i) {
      noise.col(i) = noise_of(particles.row(i).transpose(), n, settings.fixed);
    }
    noise_objective(space, filter, noise, values);
  };
  QpsoSettings search;
  search.iterations = settings.swarm.iterations;
  search.seed = settings.seed;
  search.stream = space.random_stream + kNoiseSearch;
  search.threads = settings.threads;
  search.lower = VectorXd::Constant(dimensions, settings.lower_log10);
  search.upper = VectorXd::Constant(dimensions, settings.upper_log10);

  NoiseSearch result;
  result.search = minimise_qpso(
      objective, first_noise(settings, dimensions, search.stream), search, progress, stop);
  const VectorXd best = noise_of(result.search.best, n, settings.fixed);
  filter.noise = result.noise = {best.head(n), best.tail(space.channels())};
  result.run = run_filter(space, filter);
  result.rmse_mm = space.rmse(result.run.v);
  return result;
}

ParameterSearch search_parameters(
    const ObservationSpace& space, const VectorXd& estimate,
    const ParameterSearchSettings& settings, const SearchProgress& progress,
    std::stop_token stop) {
  const int n = space.parameters();
  const bool raw = settings.coordinates == SearchCoordinates::kRaw;
  const LeastSquaresProblem problem = space.problem(settings.weighting);
  Coordinates map{estimate, MatrixXd::Identity(n, n), 0};
  if (!raw) {
    map = whitened_at(
        space, estimate, one_objective(space, problem, settings.weighting, estimate), settings);
  }
  const auto objective = [&](const SwarmRows& particles, Eigen::Ref<Eigen::ArrayXd> values) {
    MatrixXd x(n, particles.rows());
    x.noalias() = map.L.lazyProduct(particles.matrix().transpose());
    x.colwise() += map.origin;
    parameter_objective(space, problem, settings.weighting, x, values);
  };
  QpsoSettings search;
  search.iterations = settings.swarm.iterations;
  search.seed = settings.seed;
  search.stream = space.random_stream + kParameterSearch;
  search.threads = settings.threads;
  search.keep_positions = true;
  if (raw) bound(space, estimate, settings, search);

  ParameterSearch result;
  result.search = minimise_qpso(
      objective, first_parameters(space, settings, search.stream), search, progress, stop);
  for (const VectorXd& z : result.search.best_positions) {
    result.history.push_back(map.parameters(z));
  }
  result.search.best_positions.clear();
  result.v = map.parameters(result.search.best);
  result.rmse_mm = space.rmse(result.v);
  result.held = map.held;
  return result;
}

}  // namespace sixdial::calibration
