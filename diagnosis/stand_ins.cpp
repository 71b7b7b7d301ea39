#include "diagnosis/stand_ins.h"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <optional>
#include <utility>

#include "diagnosis/evidence.h"
#include "diagnosis/thresholds.h"

namespace sixdial::diagnosis {
namespace {

using simulation::ActiveEffect;

/// Columns freed of what the fitted parameters can imitate, against what is left over.
struct Seen {
  Eigen::MatrixXd normal;
  Eigen::VectorXd right;
  double squares, freedom;

  /// Of some of the columns.
  [[nodiscard]] Seen of(const std::vector<Eigen::Index>& columns) const {
    return {normal(columns, columns), right(columns), squares, freedom};
  }
  [[nodiscard]] Eigen::VectorXd sizes() const {
    return normal.completeOrthogonalDecomposition().solve(right);
  }
  [[nodiscard]] double gain() const {
    const double share = std::clamp(right.dot(sizes()) / squares, 0.0, 1 - 1e-12);
    return -0.5 * freedom * std::log1p(-share);
  }
  [[nodiscard]] double evidence() const {
    const MarginalLikelihood found = marginal_likelihood(normal, right, squares, freedom);
    return found.by_scale.empty() ? 0.0 : log_mean_exp(found.by_scale);
  }
};

}  // namespace

JointFit without_effects(const JointFit& fit, const std::vector<std::size_t>& which) {
  JointFit result = fit;
  result.effects.clear();
  Eigen::Index from = fit.model.size();
  Eigen::Index kept = from;
  for (std::size_t k = 0; k < fit.effects.size(); ++k) {
    const ActiveEffect& active = fit.effects[k];
    const Eigen::Index own = fitted_count(*active.effect);
    if (std::ranges::find(which, k) == which.end()) {
      result.J.middleCols(kept, own) = fit.J.middleCols(from, own);
      result.effects.push_back(active);
      kept += own;
    } else {
      for (int i = 0; i < linear_count(*active.effect); ++i) {
        result.residual_mm += active.x[static_cast<std::size_t>(i)] * fit.J.col(from + i);
      }
    }
    from += own;
  }
  result.J.conservativeResize(Eigen::NoChange, kept);
  return result;
}

std::vector<Hypothesis> StandIn::names() const {
  std::vector<Hypothesis> result;
  for (const ActiveEffect& each : effects) result.push_back({each.effect, each.place});
  return result;
}

StandIns::StandIns(
    const Readings& readings, const JointFit& fit, const std::vector<Hypothesis>& hypotheses)
    : fit_(fit) {
  const simulation::ExtendedModel extended(readings.model(), fit.effects);
  const Eigen::VectorXd simulated = readings.simulate(fit.model, extended);
  Eigen::Index count = 0;
  for (const Hypothesis& each : hypotheses) {
    const bool in_fit = std::ranges::any_of(fit.effects, [&](const ActiveEffect& active) {
      return each == Hypothesis{active.effect, active.place};
    });
    if (in_fit || each.effect->searched || each.effect->exchanges_dials) continue;
    names_.push_back(each);
    first_.push_back(count);
    count += linear_count(*each.effect);
  }
  first_.push_back(count);
  columns_.resize(readings.count(), count);
  for (std::size_t i = 0; i < names_.size(); ++i) {
    columns_.middleCols(first_[i], first_[i + 1] - first_[i]) =
        effect_columns(readings, fit.model, extended, at_rest(names_[i]), simulated);
  }
  columns_ = fit.whitening()(columns_);
  normal_ = columns_.transpose() * columns_;
}

std::vector<StandIn> StandIns::of(const TwoEffects& two) const {
  const Projector others(without_effects(fit_, {two[0], two[1]}));
  const Eigen::MatrixXd imitated = others.Q().transpose() * columns_;
  const Seen all{
      normal_ - imitated.transpose() * imitated, columns_.transpose() * others.residual(),
      others.squares(), others.freedom()};
  const double now = 0.5 * all.freedom * std::log(all.squares / Projector(fit_).squares());
  // Linear gains are further off for large effects.
  constexpr double kShare = 0.1;
  const double least = now - std::max(kStandIns.within, kShare * now);
  std::vector<std::size_t> testable;
  for (std::size_t i = 0; i < names_.size(); ++i) {
    const auto own = Eigen::seq(first_[i], first_[i + 1] - 1);
    const double left = all.normal(own, own).trace();
    if (left > kLeastSurviving * kLeastSurviving * normal_(own, own).trace()) {
      testable.push_back(i);
    }
  }
  std::vector<StandIn> result;
  const auto look_at = [&](const std::vector<std::size_t>& set) {
    std::vector<Eigen::Index> columns;
    for (const std::size_t i : set) {
      for (Eigen::Index k = first_[i]; k < first_[i + 1]; ++k) columns.push_back(k);
    }
    const Seen seen = all.of(columns);
    if (seen.gain() < least) return;
    StandIn found{{}, seen.evidence()};
    const Eigen::VectorXd sizes = seen.sizes();
    Eigen::Index at = 0;
    for (const std::size_t i : set) {
      ActiveEffect active = at_rest(names_[i]);
      for (double& x : active.x) x = sizes[at++];
      found.effects.push_back(std::move(active));
    }
    result.push_back(std::move(found));
  };
  for (std::size_t a = 0; a < testable.size(); ++a) {
    look_at({testable[a]});
    for (std::size_t b = a + 1; b < testable.size(); ++b) look_at({testable[a], testable[b]});
  }
  std::stable_sort(result.begin(), result.end(), [](const StandIn& a, const StandIn& b) {
    return a.evidence > b.evidence;
  });
  if (result.size() > kStandIns.most) result.resize(kStandIns.most);
  return result;
}

double cost_in(const JointFit& fit, std::size_t i) {
  const Projector others(without_effects(fit, {i}));
  Eigen::Index first = fit.model.size();
  for (std::size_t k = 0; k < i; ++k) first += fitted_count(*fit.effects[k].effect);
  const Eigen::MatrixXd columns =
      others.whitening()(fit.J.middleCols(first, linear_count(*fit.effects[i].effect)));
  const Eigen::MatrixXd imitated = others.Q().transpose() * columns;
  const Seen seen{
      columns.transpose() * columns - imitated.transpose() * imitated,
      columns.transpose() * others.residual(), others.squares(), others.freedom()};
  return seen.gain() - seen.evidence();
}

}  // namespace sixdial::diagnosis
