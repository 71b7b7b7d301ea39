#include "calibration/dqpso.h"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>

#include "calibration/random.h"
#include "calibration/swarm_kernels.h"

namespace sixdial::calibration {
namespace {

using geometry::kParameterCount;
using geometry::ParameterMatrix;
using geometry::ParameterVector;

constexpr std::uint32_t kNoiseStream = 1;
constexpr std::uint32_t kParameterStream = 2;
constexpr std::uint32_t kStartStream = 16;  // added for the first positions
// Whitening assumes at least this much noise, so that exact data do not give an empty spread.
constexpr double kLeastNoise_mm = 1e-6;
// Rounding leaves this much of a variance that is zero.
constexpr double kFixedVariance = 1e-20;

/// Calls compute(block of eight columns) for every eight particles; `columns` values each.
template <int Rows, class Fill, class Compute>
void by_lanes(Eigen::Index count, const Fill& fill, const Compute& compute) {
  Lanes<Rows> lanes;
  for (Eigen::Index first = 0; first < count; first += kLanes) {
    const Eigen::Index used = std::min<Eigen::Index>(kLanes, count - first);
    for (Eigen::Index lane = 0; lane < kLanes; ++lane) {
      fill(first + std::min(lane, used - 1), lane, lanes);  // idle lanes repeat the last one
    }
    compute(first, used, lanes);
  }
}

FilterNoise noise_from(const Eigen::VectorXd& log10_noise, const FixedParameters& fixed) {
  FilterNoise noise;
  for (int i = 0; i < kParameterCount; ++i) {
    noise.q[i] = fixed[static_cast<std::size_t>(i)] ? 0.0 : std::pow(10.0, log10_noise[i]);
  }
  noise.r = {std::pow(10.0, log10_noise[10]), std::pow(10.0, log10_noise[11])};
  return noise;
}

struct Whitening {
  ParameterVector origin;  // the estimate, with what cannot be determined put back to nominal
  ParameterMatrix L;       // v = origin + L z
  int held = 0;
};

Whitening whitening_at(
    const PositionObservations& observations, const ParameterVector& nominal,
    const ParameterVector& estimate, const ParameterSearchSettings& settings) {
  // A filter without process noise at the estimate says what the data determine ...
  const ParameterVector scale = parameter_scale();
  FilterSettings filter;
  filter.linearisation = Linearisation::kNominal;
  filter.p0 = (settings.hold_uncertainty_mm * scale).cwiseAbs2();
  for (int i = 0; i < kParameterCount; ++i) {
    if (settings.fixed[static_cast<std::size_t>(i)]) filter.p0[i] = 0.0;
  }
  filter.noise.q.setZero();
  filter.noise.r.setConstant(settings.noise_mm * settings.noise_mm);
  const ParameterMatrix P = filter_positions(observations, estimate, filter).P;
  // ... and the residuals there, how far away the minimum may be.
  const double rmse_mm = position_rmse(observations, estimate);
  const double widen =
      std::isfinite(rmse_mm)
          ? std::max(rmse_mm / std::sqrt(2.0), kLeastNoise_mm) / settings.noise_mm
          : HUGE_VAL;

  const ParameterMatrix scaled =
      scale.cwiseInverse().asDiagonal() * P * scale.cwiseInverse().asDiagonal();
  const Eigen::SelfAdjointEigenSolver<ParameterMatrix> eigen(scaled);
  Whitening result;
  result.origin = estimate;
  result.L.setZero();
  const double most = settings.hold_uncertainty_mm;
  for (int k = 0; k < kParameterCount; ++k) {
    const ParameterVector direction = eigen.eigenvectors().col(k);
    const double variance = eigen.eigenvalues()[k];
    if (variance <= kFixedVariance * most * most) continue;  // a fixed parameter
    if (variance < most * most / 2) {
      const double spread = std::min(std::sqrt(variance) * widen, most);
      result.L.col(k) = scale.cwiseProduct(direction) * spread;
    } else {
      // The data say little beyond what was assumed: hold it.
      ++result.held;
      const double along = direction.dot((nominal - estimate).cwiseQuotient(scale));
      result.origin += scale.cwiseProduct(direction) * along;
    }
  }
  for (int i = 0; i < kParameterCount; ++i) {
    if (!settings.fixed[static_cast<std::size_t>(i)]) continue;
    result.L.row(i).setZero();
    result.origin[i] = estimate[i];
  }
  return result;
}

}  // namespace

NoiseSearch search_noise(
    const PositionObservations& observations, const ParameterVector& nominal,
    const NoiseSearchSettings& settings, const SearchProgress& progress, std::stop_token stop) {
  const SwarmTable table(observations, nominal);
  const bool linear = settings.linearisation == Linearisation::kNominal;
  ParameterVector p0 = settings.p0;
  for (int i = 0; i < kParameterCount; ++i) {
    if (settings.fixed[static_cast<std::size_t>(i)]) p0[i] = 0.0;
  }

  const auto objective = [&](const SwarmRows& particles, Eigen::Ref<Eigen::ArrayXd> values) {
    by_lanes<12>(
        particles.rows(),
        [&](Eigen::Index i, Eigen::Index lane, NoiseLanes& noise) {
          for (int k = 0; k < 12; ++k) {
            const bool fixed =
                k < kParameterCount && settings.fixed[static_cast<std::size_t>(k)];
            noise(k, lane) = fixed ? 0.0 : std::pow(10.0, particles(i, k));
          }
        },
        [&](Eigen::Index first, Eigen::Index used, const NoiseLanes& noise) {
          ParameterLanes state;
          if (linear) {
            swarm_filter_nominal(table, p0, noise, state);
          } else {
            swarm_filter_estimate(table, p0, noise, state);
          }
          state.colwise() += nominal;
          Lanes<1> rmse_mm;
          swarm_rmse(table, state, rmse_mm);  // (29)
          values.segment(first, used) = rmse_mm.head(used).transpose().array();
        });
  };

  Eigen::ArrayXXd start(settings.swarm.particles, 12);
  for (int i = 0; i < settings.swarm.particles; ++i) {
    for (int k = 0; k < 12; ++k) {
      start(i, k) = settings.first_log10;
      if (i == 0) continue;
      start(i, k) += settings.spread_decades * random_normal(
                                                   settings.seed, static_cast<std::uint32_t>(i),
                                                   0, static_cast<std::uint32_t>(k),
                                                   kNoiseStream + kStartStream);
    }
  }
  QpsoSettings search;
  search.iterations = settings.swarm.iterations;
  search.seed = settings.seed;
  search.stream = kNoiseStream;
  search.threads = settings.threads;
  search.lower = Eigen::VectorXd::Constant(12, settings.lower_log10);
  search.upper = Eigen::VectorXd::Constant(12, settings.upper_log10);

  NoiseSearch result;
  result.search = minimise_qpso(objective, start, search, progress, stop);
  result.noise = noise_from(result.search.best, settings.fixed);
  result.run =
      filter_positions(observations, nominal, {settings.linearisation, p0, result.noise});
  result.rmse_mm = position_rmse(observations, result.run.v);
  return result;
}

ParameterSearch search_parameters(
    const PositionObservations& observations, const ParameterVector& nominal,
    const ParameterVector& estimate, const ParameterSearchSettings& settings,
    const SearchProgress& progress, std::stop_token stop) {
  const SwarmTable table(observations, nominal);
  const bool raw = settings.coordinates == SearchCoordinates::kRaw;
  ParameterVector spread = ParameterVector::Constant(settings.raw_spread_mm);
  spread.tail<3>().setConstant(settings.raw_spread_rad);

  Whitening map{estimate, ParameterMatrix::Identity(), 0};
  if (!raw) map = whitening_at(observations, nominal, estimate, settings);

  const auto objective = [&](const SwarmRows& particles, Eigen::Ref<Eigen::ArrayXd> values) {
    by_lanes<kParameterCount>(
        particles.rows(),
        [&](Eigen::Index i, Eigen::Index lane, ParameterLanes& z) {
          for (int k = 0; k < kParameterCount; ++k) z(k, lane) = particles(i, k);
        },
        [&](Eigen::Index first, Eigen::Index used, const ParameterLanes& z) {
          ParameterLanes v;
          v.noalias() = map.L * z;
          v.colwise() += map.origin;
          Lanes<1> rmse_mm;
          swarm_rmse(table, v, rmse_mm);  // (31)
          values.segment(first, used) = rmse_mm.head(used).transpose().array();
        });
  };

  Eigen::ArrayXXd start = Eigen::ArrayXXd::Zero(settings.swarm.particles, kParameterCount);
  for (int i = 1; i < settings.swarm.particles; ++i) {
    for (int k = 0; k < kParameterCount; ++k) {
      const auto a = static_cast<std::uint32_t>(i);
      const auto c = static_cast<std::uint32_t>(k);
      if (raw) {
        const auto w = random_words(settings.seed, a, 0, c, kParameterStream + kStartStream);
        start(i, k) = spread[k] * (2.0 * open_unit(w[0], w[1]) - 1.0);
      } else {
        start(i, k) = settings.whitened_spread *
                      random_normal(settings.seed, a, 0, c, kParameterStream + kStartStream);
      }
      if (settings.fixed[static_cast<std::size_t>(k)] && raw) start(i, k) = 0.0;
    }
  }
  QpsoSettings search;
  search.iterations = settings.swarm.iterations;
  search.seed = settings.seed;
  search.stream = kParameterStream;
  search.threads = settings.threads;
  search.keep_positions = true;
  if (raw) {
    const ParameterVector offset = nominal - estimate;
    search.lower = (offset - settings.raw_bound * spread).cwiseMin(0.0);
    search.upper = (offset + settings.raw_bound * spread).cwiseMax(0.0);
    for (int k = 0; k < kParameterCount; ++k) {
      if (settings.fixed[static_cast<std::size_t>(k)]) search.lower[k] = search.upper[k] = 0.0;
    }
  }

  ParameterSearch result;
  result.search = minimise_qpso(objective, start, search, progress, stop);
  const auto in_parameters = [&](const Eigen::VectorXd& z) {
    return ParameterVector(map.origin + map.L * z);
  };
  for (const Eigen::VectorXd& z : result.search.best_positions) {
    result.history.push_back(in_parameters(z));
  }
  result.search.best_positions.clear();
  result.v = in_parameters(result.search.best);
  result.rmse_mm = position_rmse(observations, result.v);
  result.held = map.held;
  return result;
}

}  // namespace sixdial::calibration
