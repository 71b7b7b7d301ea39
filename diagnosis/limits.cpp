#include "diagnosis/limits.h"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <limits>
#include <span>

#include "diagnosis/evidence.h"
#include "diagnosis/thresholds.h"

namespace sixdial::diagnosis {
namespace {

// 80 % power: so many standard deviations on the safe side.
constexpr double kPower = 0.84;
constexpr double kInfinite = std::numeric_limits<double>::infinity();

/// A hypothesis' weighted columns off everything fitted, at a few searched values.
struct Seen {
  Hypothesis hypothesis;
  std::vector<Eigen::MatrixXd> columns;
  double surviving = 1.0;
  double search_cost = 0.0;
  Eigen::VectorXd raw;  // first parameter's column, weighted, not projected
};

std::vector<double> few_of(std::vector<double> values) {
  constexpr std::size_t kFew = 6;
  if (values.size() <= kFew) return values;
  std::vector<double> result;
  for (std::size_t i = 0; i < kFew; ++i) {
    result.push_back(values[(2 * i + 1) * values.size() / (2 * kFew)]);
  }
  return result;
}

double evidence_of(
    const Eigen::MatrixXd& columns, const Eigen::VectorXd& signal, double noise_squares,
    double freedom) {
  const MarginalLikelihood found = marginal_likelihood(
      columns.transpose() * columns, columns.transpose() * signal,
      noise_squares + signal.squaredNorm(), freedom);
  return found.by_scale.empty() ? 0.0 : log_mean_exp(found.by_scale);
}

/// Smallest size in [low, high] at which `enough` holds, by bisection of its logarithm.
template <typename Test>
double least_size(double low, double high, Test&& enough) {
  if (!enough(high)) return kInfinite;
  constexpr int kHalvings = 24;
  for (int i = 0; i < kHalvings; ++i) {
    const double middle = std::sqrt(low * high);
    (enough(middle) ? high : low) = middle;
  }
  return high;
}

std::vector<std::string> absorbers(
    std::span<const geometry::ParameterInfo> parameters, const Eigen::VectorXd& raw,
    const Eigen::MatrixXd& J, const Eigen::VectorXd& root) {
  const Eigen::MatrixXd A =
      root.asDiagonal() *
      J.leftCols(std::min(J.cols(), static_cast<Eigen::Index>(parameters.size())));
  Eigen::VectorXd norm = A.colwise().norm();
  norm = norm.cwiseMax(1e-300);
  const Eigen::MatrixXd scaled = A * norm.cwiseInverse().asDiagonal();
  Eigen::CompleteOrthogonalDecomposition<Eigen::MatrixXd> cod;
  cod.setThreshold(1e-9);
  cod.compute(scaled);
  const Eigen::VectorXd share = cod.solve(raw).cwiseAbs();
  std::vector<Eigen::Index> order(static_cast<std::size_t>(share.size()));
  for (std::size_t i = 0; i < order.size(); ++i) order[i] = static_cast<Eigen::Index>(i);
  std::sort(order.begin(), order.end(), [&](Eigen::Index a, Eigen::Index b) {
    return share[a] != share[b] ? share[a] > share[b] : a < b;
  });
  constexpr double kWorthNaming = 0.25;  // of the largest
  constexpr std::size_t kMost = 4;
  std::vector<std::string> result;
  for (const Eigen::Index i : order) {
    if (result.size() == kMost || !(share[i] > kWorthNaming * share[order[0]])) break;
    const std::string& name = parameters[static_cast<std::size_t>(i)].name;
    result.push_back(name == "clamp" ? "clamp angle" : name);
  }
  return result;
}

/// What one session can show: each hypothesis against its rivals.
class LimitStudy {
 public:
  LimitStudy(
      const Readings& readings, const JointFit& fit, const std::vector<Hypothesis>& hypotheses,
      const NamingSettings& settings)
      : readings_(readings), fit_(fit), projector_(fit) {
    const simulation::ExtendedModel extended(readings.model(), fit.effects);
    const Eigen::VectorXd simulated = readings.simulate(fit.model, extended);
    for (const Hypothesis& each : hypotheses) {
      if (each.effect->exchanges_dials) continue;  // no size to be told
      Seen seen = seen_of(each, extended, simulated);
      if (!seen.columns.empty()) all_.push_back(std::move(seen));
    }
    // Log evidence that detects: the prior of one among so many, and what a name must show.
    const double tests = static_cast<double>(std::max<std::size_t>(2, all_.size()));
    seen_at_ = with_power(std::log(tests) + settings.least_log_odds);
    apart_ = with_power(settings.tie_log_odds);
  }

  [[nodiscard]] std::vector<Limit> limits() const {
    std::vector<Limit> result;
    for (const Seen& own : all_) result.push_back(limit_of(own));
    return result;
  }

 private:
  /// Mean log odds at which they exceed `log_odds` with the power asked for: two explanations
  /// whose log odds are d differ by a signal of sqrt(2 d) standard deviations.
  [[nodiscard]] static double with_power(double log_odds) {
    return std::pow(kPower + std::sqrt(kPower * kPower + 2 * log_odds), 2) / 2;
  }

  [[nodiscard]] Seen seen_of(
      const Hypothesis& each, const simulation::ExtendedModel& extended,
      const Eigen::VectorXd& simulated) const {
    Seen seen{each, {}, 1.0, 0.0, {}};
    std::vector<double> values{0.0};
    if (each.effect->searched) {
      values =
          each.effect->searched(readings_.model().rig(), readings_.circumstances(), each.place);
      seen.search_cost = std::log(static_cast<double>(std::max<std::size_t>(1, values.size())));
      values = few_of(std::move(values));
    }
    const Eigen::MatrixXd& Q = projector_.Q();
    for (const double value : values) {
      const Eigen::MatrixXd raw =
          projector_.root_weight().asDiagonal() *
          effect_columns(readings_, fit_.model, extended, at_rest(each, value), simulated);
      Eigen::MatrixXd kept(raw.rows(), 0);
      for (Eigen::Index i = 0; i < raw.cols(); ++i) {
        if (raw.col(i).squaredNorm() <= 0) continue;
        kept.conservativeResize(Eigen::NoChange, kept.cols() + 1);
        kept.rightCols(1) = raw.col(i);
      }
      if (kept.cols() == 0) continue;
      if (seen.raw.size() == 0) seen.raw = kept.col(0);
      const Eigen::MatrixXd projected = kept - Q * (Q.transpose() * kept);
      seen.surviving = std::min(seen.surviving, projected.norm() / kept.norm());
      seen.columns.push_back(projected);
    }
    return seen;
  }

  [[nodiscard]] Limit limit_of(const Seen& own) const {
    Limit limit;
    limit.hypothesis = own.hypothesis;
    const auto parameter =
        simulation::parameter_at(*own.hypothesis.effect, own.hypothesis.place, 0);
    limit.unit = std::string(parameter->unit);
    limit.plausible = parameter->sigma;
    limit.surviving = own.surviving;
    limit.detect = limit.name = kInfinite;
    if (own.surviving >= kLeastSurviving) find_sizes(own, limit);
    limit.absorbed_by =
        absorbers(readings_.model().parameters(), own.raw, fit_.J, projector_.root_weight());
    return limit;
  }

  void find_sizes(const Seen& own, Limit& limit) const {
    // The typical searched value; a step in the middle, a period in the middle.
    const Eigen::MatrixXd& columns = own.columns[own.columns.size() / 2];
    // Of several parameters the direction that shows least.
    const Eigen::JacobiSVD<Eigen::MatrixXd> svd(
        columns.transpose() * columns, Eigen::ComputeFullV);
    const Eigen::VectorXd direction = svd.matrixV().rightCols(1);
    const Eigen::VectorXd unit_signal = columns * direction;
    const double s_mm = std::sqrt(projector_.squares() / projector_.freedom());
    const double low = 1e-4 * s_mm / std::max(1e-300, unit_signal.norm());
    const double high = 1e8 * low;
    limit.detect = least_size(low, high, [&](double size) {
      return evidence(columns, size * unit_signal) - own.search_cost >= seen_at_;
    });
    limit.name = limit.detect;
    for (const Seen* other : hardest_rivals(own, unit_signal)) {
      const double size = least_size(low, high, [&](double amount) {
        const Eigen::VectorXd signal = amount * unit_signal;
        double best = -1e300;
        for (const Eigen::MatrixXd& columns_b : other->columns) {
          best = std::max(best, evidence(columns_b, signal));
        }
        return evidence(columns, signal) - own.search_cost - (best - other->search_cost) >=
               apart_;
      });
      if (size > limit.name || (!limit.rival && size >= limit.name)) {
        limit.name = size;
        limit.rival = other->hypothesis;
      }
    }
  }

  /// Those whose columns take over most of the signal.
  [[nodiscard]] std::vector<const Seen*> hardest_rivals(
      const Seen& own, const Eigen::VectorXd& unit_signal) const {
    std::vector<std::pair<double, const Seen*>> rivals;
    for (const Seen& other : all_) {
      if (other.hypothesis == own.hypothesis) continue;
      double alike = 0.0;
      for (const Eigen::MatrixXd& columns_b : other.columns) {
        if (other.surviving < kLeastSurviving) continue;
        const Eigen::MatrixXd basis = orthonormal_basis(columns_b);
        alike = std::max(
            alike,
            (basis.transpose() * unit_signal).norm() / std::max(1e-300, unit_signal.norm()));
      }
      rivals.emplace_back(alike, &other);
    }
    std::sort(rivals.begin(), rivals.end(), [](const auto& a, const auto& b) {
      return a.first != b.first ? a.first > b.first
                                : a.second->hypothesis.name() < b.second->hypothesis.name();
    });
    constexpr std::size_t kHardest = 4;
    std::vector<const Seen*> result;
    for (const auto& [alike, other] : rivals) {
      if (result.size() < kHardest) result.push_back(other);
    }
    return result;
  }

  [[nodiscard]] double evidence(
      const Eigen::MatrixXd& columns, const Eigen::VectorXd& signal) const {
    return evidence_of(columns, signal, projector_.squares(), projector_.freedom());
  }

  const Readings& readings_;
  const JointFit& fit_;
  Projector projector_;
  std::vector<Seen> all_;
  double seen_at_ = 0.0;
  double apart_ = 0.0;
};

}  // namespace

std::vector<Limit> limits_of(
    const Readings& readings, const JointFit& fit, const std::vector<Hypothesis>& hypotheses,
    const NamingSettings& settings) {
  return LimitStudy(readings, fit, hypotheses, settings).limits();
}

}  // namespace sixdial::diagnosis
