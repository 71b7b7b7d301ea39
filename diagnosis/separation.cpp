#include "diagnosis/separation.h"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>

namespace sixdial::diagnosis {
namespace {

using simulation::ActiveEffect;

/// What a set of samples says about A's signal and everything that could take it over.
struct Equations {
  Eigen::MatrixXd A;       // columns of robot, clamp, other causes, rival
  Eigen::VectorXd signal;  // of the cause
};

Equations equations_of(
    const Readings& readings, const JointFit& fit, std::size_t cause,
    const std::optional<ActiveEffect>& rival) {
  const ActiveEffect& own = fit.effects[cause];
  std::vector<ActiveEffect> others = fit.effects;
  others.erase(others.begin() + static_cast<std::ptrdiff_t>(cause));
  const simulation::ExtendedModel without(readings.model(), others);
  const Eigen::VectorXd base = readings.simulate(fit.model, without);
  Equations result;
  result.signal = readings.simulate(fit.model, without, &own) - base;
  std::vector<Eigen::MatrixXd> blocks{readings.jacobian(fit.model, without, {})};
  for (const ActiveEffect& each : others) {
    blocks.push_back(effect_columns(readings, fit.model, without, each, base));
  }
  if (rival) {
    ActiveEffect at = *rival;
    for (int i = 0; i < linear_count(*at.effect); ++i) at.x[static_cast<std::size_t>(i)] = 0.0;
    blocks.push_back(effect_columns(readings, fit.model, without, at, base));
  }
  Eigen::Index columns = 0;
  for (const Eigen::MatrixXd& block : blocks) columns += block.cols();
  result.A.resize(readings.count(), columns);
  Eigen::Index at = 0;
  for (const Eigen::MatrixXd& block : blocks) {
    result.A.middleCols(at, block.cols()) = block;
    at += block.cols();
  }
  for (Eigen::Index row = 0; row < result.signal.size(); ++row) {
    const double noise = readings.relative_noise()[row];
    result.signal[row] /= noise;
    result.A.row(row) /= noise;
    if (std::isfinite(result.signal[row])) continue;
    result.signal[row] = 0.0;
    result.A.row(row).setZero();
  }
  return result;
}

struct Sums {
  Eigen::MatrixXd normal;
  Eigen::VectorXd right;
  double squares = 0.0;
  void add(const Eigen::MatrixXd& A, const Eigen::VectorXd& signal) {
    normal += A.transpose() * A;
    right += A.transpose() * signal;
    squares += signal.squaredNorm();
  }
  [[nodiscard]] double left() const {
    const Eigen::VectorXd scale =
        normal.diagonal().unaryExpr([](double d) { return d > 0 ? 1 / std::sqrt(d) : 0.0; });
    Eigen::MatrixXd scaled = scale.asDiagonal() * normal * scale.asDiagonal();
    // A trace of ridge: what is not determined takes nothing over.
    scaled.diagonal().array() += 1e-10;
    const Eigen::VectorXd b = scale.cwiseProduct(right);
    return std::max(0.0, squares - b.dot(scaled.ldlt().solve(b)));
  }
};

}  // namespace

Separation separating_poses(
    const Readings& readings, const JointFit& fit, std::size_t cause,
    const std::optional<ActiveEffect>& rival, std::span<const PosePoint> candidates,
    int count) {
  const double variance = fit.s_mm * fit.s_mm;
  const Equations session = equations_of(readings, fit, cause, rival);
  Sums sums{
      Eigen::MatrixXd::Zero(session.A.cols(), session.A.cols()),
      Eigen::VectorXd::Zero(session.A.cols()), 0.0};
  sums.add(session.A, session.signal);
  Separation result;
  result.log_odds_now = sums.left() / (2 * variance);

  // The candidates as if they were measured after the session: readings by the fitted model.
  const auto& rig = readings.model().rig();
  const simulation::ExtendedModel extended(readings.model(), fit.effects);
  std::vector<simulation::Trial> trials;
  std::vector<std::size_t> which;
  const simulation::Trial* last =
      readings.trials().empty() ? nullptr : &readings.trials().back();
  simulation::Scene scene;
  for (std::size_t i = 0; i < candidates.size(); ++i) {
    simulation::Trial trial;
    trial.q = candidates[i].q_rad;
    trial.assembly = candidates[i].assembly;
    trial.approach.assign(candidates[i].approach.begin(), candidates[i].approach.end());
    trial.target_mm = candidates[i].target_mm;
    if (last) {
      trial.time_s = last->time_s;
      trial.temperature_c = last->temperature_c;
    }
    simulation::Circumstance sample;
    sample.approach.setZero(trial.q.size());
    if (!readings.circumstances().empty()) sample = readings.circumstances().back();
    sample.previous_mm.assign(rig.dials.size(), std::nan(""));
    sample.plunger_direction.assign(rig.dials.size(), 0.0);
    if (!extended.run(fit.model, trial, sample, scene)) continue;
    trial.position_mm = scene.p_WE.head(readings.axes());
    trial.reading.resize(rig.dials.size());
    for (std::size_t d = 0; readings.has_dials() && d < rig.dials.size(); ++d) {
      const auto seen = geometry::touch(
          rig.dials[d].geometry, {scene.p_WE.head<2>(), scene.gamma_rad}, rig.cuboid.side_mm);
      if (seen) trial.reading[d] = scene.reading[d];
    }
    trials.push_back(std::move(trial));
    which.push_back(i);
  }
  if (trials.empty()) return result;
  const Readings possible(readings.model(), trials);
  if (possible.has_dials() != readings.has_dials()) return result;
  const Equations each = equations_of(possible, fit, cause, rival);
  std::vector<bool> taken(trials.size(), false);
  for (int step = 0; step < count; ++step) {
    double most = -1.0;
    std::size_t best = trials.size();
    for (std::size_t t = 0; t < trials.size(); ++t) {
      const Eigen::Index first = possible.first_row(t);
      const Eigen::Index rows = possible.first_row(t + 1) - first;
      if (taken[t] || rows == 0) continue;
      Sums with = sums;
      with.add(each.A.middleRows(first, rows), each.signal.segment(first, rows));
      const double left = with.left();
      if (left > most * (1 + 1e-12)) {
        most = left;
        best = t;
      }
    }
    if (best == trials.size()) break;
    taken[best] = true;
    const Eigen::Index first = possible.first_row(best);
    const Eigen::Index rows = possible.first_row(best + 1) - first;
    sums.add(each.A.middleRows(first, rows), each.signal.segment(first, rows));
    result.chosen.push_back(which[best]);
    result.log_odds.push_back(most / (2 * variance));
  }
  return result;
}

}  // namespace sixdial::diagnosis
