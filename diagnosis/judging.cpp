#include "diagnosis/judging.h"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <limits>

#include "diagnosis/curves_in_model.h"
#include "diagnosis/thresholds.h"

namespace sixdial::diagnosis {
namespace {

/// Effects that these readings cannot tell: even at a plausible size, nothing of it is left
/// above the noise once everything else that was fitted has taken over what it can (a step that
/// comes after the last fitted point).
std::vector<bool> not_determined(const Readings& readings, const JointFit& fit) {
  const Eigen::MatrixXd J = fit.whitening()(fit.J);
  std::vector<bool> result;
  Eigen::Index at = readings.model().parameter_count();
  for (const simulation::ActiveEffect& each : fit.effects) {
    const Eigen::Index own = fitted_count(*each.effect);
    Eigen::MatrixXd others(J.rows(), J.cols() - own);
    others << J.leftCols(at), J.rightCols(J.cols() - at - own);
    const Eigen::MatrixXd Q = orthonormal_basis(others);
    double most = 0.0;
    for (Eigen::Index k = 0; k < linear_count(*each.effect); ++k) {
      const Eigen::VectorXd column = J.col(at + k);
      const double left = (column - Q * (Q.transpose() * column)).norm();
      most = std::max(
          most, left * each.effect->parameters[static_cast<std::size_t>(k)].sigma / fit.s_mm);
    }
    result.push_back(most < 1.0);
    at += own;
  }
  return result;
}

}  // namespace

JointFit applied(const Readings& readings, const JointFit& fitted) {
  JointFit result = fitted;
  const simulation::ExtendedModel extended(readings.model(), fitted.effects);
  result.residual_mm = readings.measured_mm() - readings.simulate(fitted.model, extended);
  result.noise = readings.relative_noise().cwiseAbs2();
  result.noise += (readings.doubt_mm(fitted.model, extended) / fitted.s_mm).cwiseAbs2();
  result.noise = result.noise.cwiseSqrt();
  // The rig's own geometry is that of G1; what is smooth was fitted at G1's readings only.
  result.random =
      readings.nuisance().leftCols(std::min(fitted.known, readings.nuisance().cols()));
  result.known = result.random.cols();
  result.u = fitted.u.head(result.known);
  result.residual_mm -= result.random * result.u;
  result.shared = readings.shareable_like(fitted.shared.get());
  result.shift_mm = Eigen::VectorXd::Zero(readings.count());
  return result;
}

namespace {

JointFit named_effects_on(const Readings& fitted, const JointFit& extended) {
  JointFit fit = fit_jointly(fitted, extended.model, extended.effects);
  const std::vector<bool> unknown = not_determined(fitted, fit);
  if (std::ranges::find(unknown, true) == unknown.end()) return fit;
  std::vector<simulation::ActiveEffect> effects = fit.effects;
  for (std::size_t i = 0; i < effects.size(); ++i) {
    if (!unknown[i]) continue;
    const auto linear = static_cast<std::ptrdiff_t>(linear_count(*effects[i].effect));
    std::fill(effects[i].x.begin(), effects[i].x.begin() + linear, 0.0);
  }
  // A fit leaves what it cannot determine at the start, up to rounding.
  JointFit without = fit_jointly(fitted, fit.model, effects);
  for (std::size_t i = 0; i < effects.size(); ++i) {
    if (unknown[i]) without.effects[i].x = effects[i].x;
  }
  return without;
}

}  // namespace

JointFit extended_on(
    const Readings& fitted, const JointFit& extended, const std::vector<OwnCurve>& curves,
    const JointFit& plain) {
  return with_curves(
      fitted, extended.effects.empty() ? plain : named_effects_on(fitted, extended), curves);
}

Eigen::VectorXd weights_to_judge(
    const Readings& all, const JointFit& extended, const Readings& judged, double s_mm) {
  Eigen::VectorXd weight = Eigen::VectorXd::Ones(judged.count());
  Eigen::Index at = 0;
  for (Eigen::Index row = 0; row < all.count() && at < judged.count(); ++row) {
    const Row& each = all.rows()[static_cast<std::size_t>(row)];
    const Row& here = judged.rows()[static_cast<std::size_t>(at)];
    if (each.trial != here.trial || each.dial != here.dial) continue;
    const double own_mm = extended.residual_mm[row] - extended.shift_mm[row];
    const double size_mm = std::abs(own_mm) / extended.noise[row];
    if (extended.weight[row] < kGoodWeight && size_mm > kGrossSigma * s_mm) weight[at] = 0.0;
    ++at;
  }
  return weight;
}

std::vector<std::size_t> poses_to_judge(
    const Readings& judged, const Eigen::VectorXd& weight, int& excluded) {
  std::vector<std::size_t> poses;
  for (std::size_t t = 0; t < judged.trials().size(); ++t) {
    const Eigen::Index first = judged.first_row(t);
    const Eigen::Index rows = judged.first_row(t + 1) - first;
    if (rows == 0) continue;
    if (weight.segment(first, rows).minCoeff() > 0) {
      poses.push_back(t);
    } else {
      ++excluded;
    }
  }
  return poses;
}

std::optional<calibration::TrainedResidual> trained_on(
    const Readings& readings, const JointFit& fit, std::uint64_t seed,
    const std::stop_token& stop) {
  const Eigen::MatrixXd shift = tool_shift(readings, fit, fit.residual_mm, fit.weight);
  std::vector<std::size_t> usable;
  for (std::size_t t = 0; t < readings.trials().size(); ++t) {
    const Eigen::Index rows = readings.first_row(t + 1) - readings.first_row(t);
    if (rows == 0 || !shift.col(static_cast<Eigen::Index>(t)).allFinite()) continue;
    if (fit.weight.segment(readings.first_row(t), rows).minCoeff() > kGoodWeight) {
      usable.push_back(t);
    }
  }
  constexpr std::size_t kFewest = 12;
  if (usable.size() < kFewest) return std::nullopt;
  Eigen::MatrixXd q(
      static_cast<Eigen::Index>(usable.size()), readings.trials()[usable[0]].q.size());
  Eigen::MatrixXd target(q.rows(), readings.axes());
  for (std::size_t i = 0; i < usable.size(); ++i) {
    q.row(static_cast<Eigen::Index>(i)) = readings.trials()[usable[i]].q.transpose();
    target.row(static_cast<Eigen::Index>(i)) =
        shift.col(static_cast<Eigen::Index>(usable[i])).transpose();
  }
  calibration::ResidualSettings how;
  how.seed = seed;
  return calibration::train_residual(
      *calibration::find_residual_model(kModelOnTop), q, target, how, stop);
}

Judged judged_on(
    const Side& side, const std::vector<std::size_t>& poses, const JointFit& fit,
    const calibration::TrainedResidual* network) {
  const Readings& test = side.readings.judged;
  const JointFit here = applied(test, fit);
  const Eigen::MatrixXd shift = tool_shift(test, here, here.residual_mm, side.weight);
  Judged result{
      GainModel::kNominal,
      network != nullptr,
      std::nullopt,
      &test,
      Eigen::VectorXd(static_cast<Eigen::Index>(poses.size())),
      here.residual_mm};
  const ToolColumns columns = tool_columns(test, here);
  for (std::size_t i = 0; i < poses.size(); ++i) {
    const std::size_t t = poses[i];
    const Eigen::Index first = test.first_row(t);
    const Eigen::Index rows = test.first_row(t + 1) - first;
    Eigen::VectorXd error = shift.col(static_cast<Eigen::Index>(t));
    // Fewer channels than axes: the error is what they show of it.
    if (rows < test.axes()) error = here.residual_mm.segment(first, rows);
    if (network) {
      const Eigen::VectorXd said = network->correction(test.trials()[t].q);
      error -= said;
      result.residual_mm.segment(first, rows) -= columns.shift.middleRows(first, rows) * said;
    }
    result.error_mm[static_cast<Eigen::Index>(i)] = error.norm();
  }
  return result;
}

}  // namespace sixdial::diagnosis
