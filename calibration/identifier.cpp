#include "calibration/identifier.h"

#include <Eigen/Eigenvalues>
#include <array>
#include <cmath>
#include <limits>
#include <numbers>

#include "calibration/random.h"

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

constexpr std::uint32_t kNoiseStream = 3;
constexpr std::uint32_t kParameterStream = 4;
constexpr std::uint32_t kStartStream = 16;
constexpr double kNoiseSpread_decades = 2.0;
constexpr double kLowerLog10 = -12.0;
constexpr double kUpperLog10 = 2.0;
constexpr double kWhitenedSpread = 3.0;
constexpr int kToMinimum = 100;     // iterations
constexpr double kRawSpread = 0.3;  // in units of scale

FixedParameters fixed_ten(const IdentifySettings& settings) {
  FixedParameters fixed{};
  for (int i = 0; i < geometry::kParameterCount; ++i) {
    fixed[static_cast<std::size_t>(i)] = is_fixed(settings, i);
  }
  return fixed;
}

VectorXd p0_of(const ObservationSpace& space, const IdentifySettings& settings) {
  VectorXd p0 = VectorXd::Constant(space.parameters(), settings.p0);
  for (int i = 0; i < space.parameters(); ++i) {
    if (is_fixed(settings, i)) p0[i] = 0.0;
  }
  return p0;
}

}  // namespace

std::span<const Identifier* const> all_identifiers() { return kTable; }

const Identifier* find_identifier(std::string_view name) {
  for (const Identifier* each : kTable) {
    if (each->name == name) return each;
  }
  return nullptr;
}

bool is_fixed(const IdentifySettings& settings, int parameter) {
  const auto i = static_cast<std::size_t>(parameter);
  return i < settings.fixed.size() && settings.fixed[i] != 0;
}

bool is_weighted(const ObservationSpace& space, const IdentifySettings& settings) {
  return settings.weighted || !space.positions;
}

LeastSquaresSettings core_settings(
    const ObservationSpace& space, const IdentifySettings& settings) {
  LeastSquaresSettings core;
  core.first_damping = 1e-7;  // nominal is near
  core.scale = space.scale;
  core.anchor = space.nominal;
  core.fixed = settings.fixed;
  core.hold_below = settings.noise_mm / settings.hold_uncertainty_mm;
  return core;
}

Identified identify(
    const Identifier& identifier, const ObservationSpace& space,
    const IdentifySettings& settings, const SearchProgress& progress,
    const std::stop_token& stop) {
  Identified result = identifier.identify(space, settings, progress, stop);
  result.rmse = space.rmse(result.x);
  LeastSquaresSettings core = core_settings(space, settings);
  core.max_iterations = 0;
  result.fit = solve_least_squares(space.problem(is_weighted(space, settings)), result.x, core);
  if (result.fit.status == FitStatus::kBadStart) {
    result.status = FitStatus::kBadStart;
    result.covariance = MatrixXd::Zero(space.parameters(), space.parameters());
    return result;
  }
  double residual_variance = result.fit.variance();
  if (result.unit_covariance.size() > 0) {
    // One pass leaves more than noise: what noise is shows at the minimum.
    core.max_iterations = kToMinimum;
    const LeastSquaresProblem problem = space.problem(is_weighted(space, settings));
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

VectorXd filter_space(
    const ObservationSpace& space, const VectorXd& q, const VectorXd& r, const VectorXd& p0,
    Linearisation linearisation, MatrixXd* unit_covariance) {
  const int n = space.parameters();
  const double mean_sigma = space.mean_sigma();
  if (unit_covariance != nullptr) unit_covariance->setZero(n, n);
  VectorXd x = VectorXd::Zero(n);
  MatrixXd P = p0.asDiagonal();
  VectorXd e;
  MatrixXd J;
  for (int i = 0; i < space.samples(); ++i) {
    P.diagonal() += q;
    const int rows = space.rows(i);
    e.resize(rows);
    J.resize(rows, n);
    const bool linear = linearisation == Linearisation::kNominal;
    const VectorXd at = linear ? space.nominal : VectorXd(space.nominal + x);
    if (!space.evaluate(i, at, e, &J)) {
      return VectorXd::Constant(n, std::numeric_limits<double>::quiet_NaN());
    }
    const VectorXd origin = linear ? VectorXd::Zero(n) : x;
    for (int row = 0; row < rows; ++row) {
      // Independent rows one at a time: equal to (20)-(22), without an inverse.
      const auto channel =
          static_cast<std::size_t>(space.first_row[static_cast<std::size_t>(i)] + row);
      const VectorXd h = J.row(row);
      const VectorXd Ph = P * h;
      const VectorXd K = Ph / (h.dot(Ph) + r[space.channel[channel]]);
      x += K * (e[row] - h.dot(x - origin));
      P -= K * Ph.transpose();
      if (unit_covariance != nullptr) {
        // Whatever P says: x passes on its own errors less what the gain takes, and adds the
        // reading's.
        MatrixXd& C = *unit_covariance;
        const double sigma =
            space.sigma_mm[space.first_row[static_cast<std::size_t>(i)] + row] / mean_sigma;
        C -= K * (h.transpose() * C);
        C -= (C * h) * K.transpose();
        C += (sigma * sigma) * K * K.transpose();
      }
    }
    P = (0.5 * (P + P.transpose())).eval();
  }
  return x;
}

Identified qpso1_in(
    const ObservationSpace& space, const IdentifySettings& settings,
    const SearchProgress& progress, const std::stop_token& stop) {
  Identified result;
  if (space.positions) {
    NoiseSearchSettings fast;
    fast.swarm = settings.qpso1;
    fast.linearisation = settings.linearisation;
    fast.p0.setConstant(settings.p0);
    fast.first_log10 = std::log10(settings.first_variance);
    fast.fixed = fixed_ten(settings);
    fast.seed = settings.seed;
    fast.threads = settings.threads;
    const NoiseSearch found =
        search_noise(*space.positions, space.nominal, fast, progress, stop);
    result.x = found.run.v;
    result.history = found.search.history;
    result.iterations = static_cast<int>(found.search.history.size()) - 1;
    result.cancelled = found.search.cancelled;
    VectorXd q = found.noise.q;
    for (int i = 0; i < space.parameters(); ++i) {
      if (is_fixed(settings, i)) q[i] = 0.0;
    }
    static_cast<void>(filter_space(
        space, q, found.noise.r, p0_of(space, settings), settings.linearisation,
        &result.unit_covariance));
    return result;
  }
  const int n = space.parameters();
  const int dimensions = n + space.channels;
  const VectorXd p0 = p0_of(space, settings);
  const auto estimate = [&](const VectorXd& log10_noise, MatrixXd* covariance = nullptr) {
    VectorXd q = (log10_noise.head(n) * std::numbers::ln10).array().exp();
    for (int i = 0; i < n; ++i) {
      if (is_fixed(settings, i)) q[i] = 0.0;
    }
    const VectorXd r = (log10_noise.tail(space.channels) * std::numbers::ln10).array().exp();
    return VectorXd(
        space.nominal + filter_space(space, q, r, p0, settings.linearisation, covariance));
  };
  const auto objective = [&](const SwarmRows& particles, Eigen::Ref<Eigen::ArrayXd> values) {
    for (Eigen::Index i = 0; i < particles.rows(); ++i) {
      const VectorXd x = estimate(particles.row(i).transpose());
      values[i] = x.allFinite() ? space.rmse(x) : HUGE_VAL;
    }
  };
  Eigen::ArrayXXd start(settings.qpso1.particles, dimensions);
  for (int i = 0; i < settings.qpso1.particles; ++i) {
    for (int k = 0; k < dimensions; ++k) {
      start(i, k) = std::log10(settings.first_variance);
      if (i == 0) continue;
      start(i, k) += kNoiseSpread_decades * random_normal(
                                                settings.seed, static_cast<std::uint32_t>(i), 0,
                                                static_cast<std::uint32_t>(k),
                                                kNoiseStream + kStartStream);
    }
  }
  QpsoSettings search;
  search.iterations = settings.qpso1.iterations;
  search.seed = settings.seed;
  search.stream = kNoiseStream;
  search.threads = settings.threads;
  search.lower = VectorXd::Constant(dimensions, kLowerLog10);
  search.upper = VectorXd::Constant(dimensions, kUpperLog10);
  const QpsoResult found = minimise_qpso(objective, start, search, progress, stop);
  result.x = estimate(found.best, &result.unit_covariance);
  result.history = found.history;
  result.iterations = static_cast<int>(found.history.size()) - 1;
  result.cancelled = found.cancelled;
  return result;
}

Identified qpso2_in(
    const ObservationSpace& space, const VectorXd& estimate, const IdentifySettings& settings,
    const SearchProgress& progress, const std::stop_token& stop) {
  Identified result;
  if (space.positions) {
    ParameterSearchSettings fast;
    fast.swarm = settings.qpso2;
    fast.coordinates = settings.coordinates;
    fast.noise_mm = settings.noise_mm;
    fast.hold_uncertainty_mm = settings.hold_uncertainty_mm;
    fast.fixed = fixed_ten(settings);
    fast.seed = settings.seed;
    fast.threads = settings.threads;
    const ParameterSearch found =
        search_parameters(*space.positions, space.nominal, estimate, fast, progress, stop);
    result.x = found.v;
    result.history = found.search.history;
    result.iterations = static_cast<int>(found.search.history.size()) - 1;
    result.cancelled = found.search.cancelled;
    return result;
  }
  // Whitened by the data's own covariance at the estimate; held directions stay at nominal.
  LeastSquaresSettings core = core_settings(space, settings);
  core.max_iterations = 0;
  const LeastSquaresFit fit = solve_least_squares(space.problem(true), estimate, core);
  const int n = space.parameters();
  VectorXd origin = estimate;
  MatrixXd L = MatrixXd::Zero(n, n);
  if (settings.coordinates == SearchCoordinates::kRaw || fit.status == FitStatus::kBadStart) {
    for (int i = 0; i < n; ++i) {
      if (!is_fixed(settings, i)) L(i, i) = kRawSpread * space.scale[i];
    }
  } else {
    const double spread =
        std::max(std::sqrt(fit.variance()), settings.noise_mm) * kWhitenedSpread;
    for (Eigen::Index k = 0; k < fit.singular_values.size(); ++k) {
      const VectorXd direction = fit.directions.col(k);
      if (k < fit.singular_values.size() - fit.held) {
        L.col(k) = space.scale.cwiseProduct(direction) *
                   std::min(spread / fit.singular_values[k], settings.hold_uncertainty_mm);
      } else {
        const double along =
            direction.dot((space.nominal - estimate).cwiseQuotient(space.scale));
        origin += space.scale.cwiseProduct(direction) * along;
      }
    }
  }
  const LeastSquaresProblem problem = space.problem(true);
  const auto objective = [&](const SwarmRows& particles, Eigen::Ref<Eigen::ArrayXd> values) {
    VectorXd r(space.rows());
    for (Eigen::Index i = 0; i < particles.rows(); ++i) {
      const VectorXd x = origin + L * particles.row(i).transpose().matrix();
      values[i] = problem.evaluate(x, r, nullptr) ? std::sqrt(r.squaredNorm() / space.samples())
                                                  : HUGE_VAL;
    }
  };
  Eigen::ArrayXXd start = Eigen::ArrayXXd::Zero(settings.qpso2.particles, n);
  for (int i = 1; i < settings.qpso2.particles; ++i) {
    for (int k = 0; k < n; ++k) {
      start(i, k) = random_normal(
          settings.seed, static_cast<std::uint32_t>(i), 0, static_cast<std::uint32_t>(k),
          kParameterStream + kStartStream);
    }
  }
  QpsoSettings search;
  search.iterations = settings.qpso2.iterations;
  search.seed = settings.seed;
  search.stream = kParameterStream;
  search.threads = settings.threads;
  const QpsoResult found = minimise_qpso(objective, start, search, progress, stop);
  result.x = origin + L * found.best;
  result.history = found.history;
  result.iterations = static_cast<int>(found.history.size()) - 1;
  result.cancelled = found.cancelled;
  return result;
}

}  // namespace sixdial::calibration
