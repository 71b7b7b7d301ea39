#include "diagnosis/limits.h"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <limits>
#include <span>

#include "diagnosis/evidence.h"
#include "geometry/robots/five_bar.h"

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

}  // namespace

std::vector<Limit> limits_of(
    const Readings& readings, const JointFit& fit, const std::vector<Hypothesis>& hypotheses,
    const Settings& settings) {
  const Projector projector(fit);
  const Eigen::MatrixXd& Q = projector.Q();
  const Eigen::VectorXd& root = projector.root_weight();
  const simulation::ExtendedModel extended(readings.model(), fit.effects);
  const Eigen::VectorXd simulated = readings.simulate(fit.model, extended);

  std::vector<Seen> all;
  for (const Hypothesis& each : hypotheses) {
    if (each.effect->exchanges_dials) continue;  // no size to be told
    Seen seen{each, {}, 1.0, 0.0, {}};
    std::vector<double> values{0.0};
    if (each.effect->searched) {
      values =
          each.effect->searched(readings.model().rig(), readings.circumstances(), each.place);
      seen.search_cost = std::log(static_cast<double>(std::max<std::size_t>(1, values.size())));
      values = few_of(std::move(values));
    }
    for (const double value : values) {
      const Eigen::MatrixXd raw =
          root.asDiagonal() *
          effect_columns(readings, fit.model, extended, at_rest(each, value), simulated);
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
    if (!seen.columns.empty()) all.push_back(std::move(seen));
  }

  const double freedom = projector.freedom();
  const double noise_squares = projector.squares();
  const double s = std::sqrt(noise_squares / freedom);
  const double tests = static_cast<double>(std::max<std::size_t>(2, all.size()));
  // Log evidence that detects: the prior of one among so many, and what a name must show.
  const double needed = std::log(tests) + settings.least_log_odds;
  // Two explanations whose log odds are d differ by a signal of sqrt(2 d) standard deviations.
  const double apart =
      std::pow(kPower + std::sqrt(kPower * kPower + 2 * settings.tie_log_odds), 2) / 2;
  const double seen_at = std::pow(kPower + std::sqrt(kPower * kPower + 2 * needed), 2) / 2;

  std::vector<Limit> result;
  for (const Seen& own : all) {
    Limit limit;
    limit.hypothesis = own.hypothesis;
    const auto parameter =
        simulation::parameter_at(*own.hypothesis.effect, own.hypothesis.place, 0);
    limit.unit = std::string(parameter->unit);
    limit.plausible = parameter->sigma;
    limit.surviving = own.surviving;
    // The typical searched value; a step in the middle, a period in the middle.
    const Eigen::MatrixXd& columns = own.columns[own.columns.size() / 2];
    // Of several parameters the direction that shows least.
    const Eigen::JacobiSVD<Eigen::MatrixXd> svd(
        columns.transpose() * columns, Eigen::ComputeFullV);
    const Eigen::VectorXd direction = svd.matrixV().rightCols(1);
    const Eigen::VectorXd unit_signal = columns * direction;
    const double low = 1e-4 * s / std::max(1e-300, unit_signal.norm());
    const double high = 1e8 * low;
    constexpr double kLeastSurviving = 1e-5;
    if (own.surviving < kLeastSurviving) {
      limit.detect = limit.name = kInfinite;
    } else {
      limit.detect = least_size(low, high, [&](double size) {
        return evidence_of(columns, size * unit_signal, noise_squares, freedom) -
                   own.search_cost >=
               seen_at;
      });
      // The rivals that look most like it.
      std::vector<std::pair<double, const Seen*>> rivals;
      for (const Seen& other : all) {
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
      if (rivals.size() > kHardest) rivals.resize(kHardest);
      limit.name = limit.detect;
      for (const auto& [alike, other] : rivals) {
        const double size = least_size(low, high, [&](double amount) {
          const Eigen::VectorXd signal = amount * unit_signal;
          double best = -1e300;
          for (const Eigen::MatrixXd& columns_b : other->columns) {
            best = std::max(best, evidence_of(columns_b, signal, noise_squares, freedom));
          }
          return evidence_of(columns, signal, noise_squares, freedom) - own.search_cost -
                     (best - other->search_cost) >=
                 apart;
        });
        if (size > limit.name || (!limit.rival && size >= limit.name)) {
          limit.name = size;
          limit.rival = other->hypothesis;
        }
      }
    }
    limit.absorbed_by = absorbers(readings.model().parameters(), own.raw, fit.J, root);
    result.push_back(std::move(limit));
  }
  return result;
}

}  // namespace sixdial::diagnosis
