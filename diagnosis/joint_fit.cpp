#include "diagnosis/joint_fit.h"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <numbers>
#include <utility>

namespace sixdial::diagnosis {
namespace {

using simulation::ActiveEffect;
using simulation::ExtendedModel;
using simulation::ModelVector;

constexpr double kGrossRange_mm = 1.0;
constexpr double kLeastGrossShare = 0.002;
constexpr double kMostGrossShare = 0.25;
// A pose that does not exist is as far off as can be.
constexpr double kOutOfReach_mm = 100.0;

/// Gross errors lie within a millimetre; far from a fit everything does, and they lie further.
double gross_range_mm(double s_mm) { return std::max(kGrossRange_mm, 30.0 * s_mm); }

double robust_scale(const Eigen::VectorXd& e) {
  std::vector<double> size(static_cast<std::size_t>(e.size()));
  for (Eigen::Index i = 0; i < e.size(); ++i)
    size[static_cast<std::size_t>(i)] = std::abs(e[i]);
  if (size.empty()) return 0.0;
  const auto middle = size.begin() + static_cast<std::ptrdiff_t>(size.size() / 2);
  std::nth_element(size.begin(), middle, size.end());
  return 1.4826 * *middle;
}

/// Expectation steps: weights, s, share of gross errors, likelihood.
void weigh(JointFit& fit, double smallest_s_mm) {
  const Eigen::VectorXd& e = fit.residual_mm;
  const double n = static_cast<double>(e.size());
  fit.weight.resize(e.size());
  for (int pass = 0; pass < 3; ++pass) {
    double squares = 0.0;
    double good = 0.0;
    fit.log_likelihood = 0.0;
    const double density = 1.0 / std::sqrt(2 * std::numbers::pi);
    const double as_gross = fit.gross_share / gross_range_mm(fit.s_mm);
    for (Eigen::Index i = 0; i < e.size(); ++i) {
      const double s_mm = fit.s_mm * fit.noise[i];
      const double z = e[i] / s_mm;
      const double as_good = (1 - fit.gross_share) * density / s_mm * std::exp(-0.5 * z * z);
      fit.weight[i] = as_good / (as_good + as_gross);
      fit.log_likelihood += std::log(as_good + as_gross);
      squares += fit.weight[i] * std::pow(e[i] / fit.noise[i], 2);
      good += fit.weight[i];
    }
    squares += fit.u.squaredNorm();
    fit.s_mm = std::max(smallest_s_mm, std::sqrt(squares / std::max(1.0, good)));
    fit.gross_share = std::clamp(1 - good / n, kLeastGrossShare, kMostGrossShare);
  }
}

/// Covariance, and u integrated out of the likelihood:
///   -|u|^2 / 2s^2 - ln det(I + C'P C) / 2,   P projects off the fitted columns.
void finish(JointFit& fit) {
  const Eigen::VectorXd root = fit.root();
  const Eigen::Index p = fit.J.cols();
  const Eigen::Index m = fit.random.cols();
  Eigen::MatrixXd A(fit.residual_mm.size(), p + m);
  A.leftCols(p) = root.asDiagonal() * fit.J;
  if (m > 0) A.rightCols(m) = root.asDiagonal() * fit.random;
  Eigen::MatrixXd normal = A.transpose() * A;
  normal.bottomRightCorner(m, m).diagonal().array() += 1.0;
  const double squares = root.cwiseProduct(fit.residual_mm).squaredNorm() + fit.u.squaredNorm();
  const double variance = squares / std::max(1.0, fit.weight.sum() - fit.fitted);
  // Scaled: millimetres stand beside radians.
  const Eigen::VectorXd scale =
      normal.diagonal().unaryExpr([](double d) { return d > 0 ? 1.0 / std::sqrt(d) : 0.0; });
  const Eigen::MatrixXd scaled = scale.asDiagonal() * normal * scale.asDiagonal();
  const Eigen::MatrixXd inverse = scale.asDiagonal() *
                                  scaled.completeOrthogonalDecomposition().pseudoInverse() *
                                  scale.asDiagonal();
  fit.covariance = inverse.topLeftCorner(p, p) * variance;
  if (m == 0) return;
  // det of the Schur complement: 1 / det of the inverse's corner.
  const Eigen::MatrixXd corner = inverse.bottomRightCorner(m, m);
  const Eigen::VectorXd pivots = corner.ldlt().vectorD();
  fit.log_likelihood += 0.5 * pivots.array().max(1e-300).log().sum() -
                        0.5 * fit.u.squaredNorm() / (fit.s_mm * fit.s_mm);
}

Eigen::VectorXd tamed(Eigen::VectorXd e) {
  return e.unaryExpr([](double v) { return std::isfinite(v) ? v : kOutOfReach_mm; });
}

}  // namespace

int linear_count(const simulation::Effect& effect) {
  return static_cast<int>(effect.parameters.size()) - (effect.searched ? 1 : 0);
}

int fitted_count(const simulation::Effect& effect) {
  return static_cast<int>(effect.parameters.size()) -
         (effect.searched && !effect.searched_change ? 1 : 0);
}

Eigen::MatrixXd orthonormal_basis(const Eigen::MatrixXd& columns, double relative) {
  Eigen::MatrixXd scaled = columns;
  for (Eigen::Index i = 0; i < scaled.cols(); ++i) {
    const double norm = scaled.col(i).norm();
    if (norm > 0) scaled.col(i) /= norm;
  }
  Eigen::ColPivHouseholderQR<Eigen::MatrixXd> qr(scaled);
  qr.setThreshold(relative);
  return qr.householderQ() * Eigen::MatrixXd::Identity(scaled.rows(), qr.rank());
}

Eigen::MatrixXd effect_columns(
    const Readings& readings, const ModelVector& at, const ExtendedModel& extended,
    const ActiveEffect& candidate, const Eigen::VectorXd& simulated_mm) {
  const int count = linear_count(*candidate.effect);
  Eigen::MatrixXd columns(readings.count(), count);
  for (int i = 0; i < count; ++i) {
    ActiveEffect moved = candidate;
    const auto k = static_cast<std::size_t>(i);
    const double step = 1e-3 * candidate.effect->parameters[k].sigma;
    moved.x[k] += step;
    columns.col(i) = (readings.simulate(at, extended, &moved) - simulated_mm) / step;
  }
  return columns.unaryExpr([](double v) { return std::isfinite(v) ? v : 0.0; });
}

Projector::Projector(const JointFit& fit) : root_(fit.root()) {
  const Eigen::Index n = fit.residual_mm.size();
  const Eigen::Index m = fit.random.cols();
  Eigen::MatrixXd columns = Eigen::MatrixXd::Zero(n + m, fit.J.cols() + m);
  columns.topLeftCorner(n, fit.J.cols()) = root_.asDiagonal() * fit.J;
  Eigen::VectorXd e(n + m);
  e.head(n) = root_.cwiseProduct(fit.residual_mm);
  if (m > 0) {
    columns.topRightCorner(n, m) = root_.asDiagonal() * fit.random;
    columns.bottomRightCorner(m, m).setIdentity();
    e.tail(m) = -fit.u;
  }
  const Eigen::MatrixXd Q = orthonormal_basis(columns);
  e -= Q * (Q.transpose() * e);
  Q_ = Q.topRows(n);
  e_ = e.head(n);
  squares_ = e.squaredNorm();
  freedom_ = std::max(3.0, fit.weight.sum() - fit.fitted);
}

namespace {

/// `plain_steps`: least squares with every reading counted, before the weights come in.
JointFit fit_from(
    const Readings& readings, const ModelVector& start, std::vector<ActiveEffect> effects,
    const JointFit* near, const Eigen::MatrixXd& random, int plain_steps) {
  JointFit fit;
  fit.random = random.cols() > 0 ? random : readings.nuisance();
  const Eigen::Index m = fit.random.cols();
  fit.u = Eigen::VectorXd::Zero(m);
  fit.noise = readings.relative_noise();
  fit.model = start;
  fit.effects = std::move(effects);
  fit.gross_share = near ? near->gross_share : kLeastGrossShare;
  constexpr double kFinest_mm = 1e-6;
  const double smallest_s_mm = std::max(kFinest_mm, 0.05 * readings.rig_noise_mm());
  int linear = 0;
  for (const ActiveEffect& active : fit.effects) linear += fitted_count(*active.effect);
  const Eigen::Index parameters = start.size();
  const Eigen::Index count = parameters + linear;

  const auto simulated_with = [&](const ModelVector& model,
                                  const std::vector<ActiveEffect>& with) -> Eigen::VectorXd {
    return readings.simulate(model, ExtendedModel(readings.model(), with));
  };
  const auto residual_with = [&](const ModelVector& model,
                                 const std::vector<ActiveEffect>& with,
                                 const Eigen::VectorXd& u) -> Eigen::VectorXd {
    Eigen::VectorXd e = tamed(readings.measured_mm() - simulated_with(model, with));
    if (m > 0) e -= fit.random * u;
    return e;
  };
  fit.residual_mm = residual_with(fit.model, fit.effects, fit.u);
  fit.s_mm = std::max(
      {smallest_s_mm, near ? near->s_mm : 0.0,
       robust_scale(fit.residual_mm.cwiseQuotient(fit.noise))});

  constexpr int kMostSteps = 60;
  // Of the largest eigenvalue of the scaled normal matrix: below is rounding.
  constexpr double kUnseen = 1e-13;
  constexpr double kMostDamping = 10.0;
  double damping = 0.0;
  for (int step = 0; step < kMostSteps; ++step) {
    weigh(fit, smallest_s_mm);
    if (step < plain_steps) fit.weight.setOnes();
    fit.J.resize(readings.count(), count);
    fit.J.leftCols(parameters) = readings.jacobian(fit.model);
    const Eigen::VectorXd simulated = simulated_with(fit.model, fit.effects);
    Eigen::Index column = parameters;
    for (std::size_t k = 0; k < fit.effects.size(); ++k) {
      const auto& effect = *fit.effects[k].effect;
      for (int i = 0; i < fitted_count(effect); ++i) {
        const auto index = static_cast<std::size_t>(i);
        std::vector<ActiveEffect> moved = fit.effects;
        const double size = i < linear_count(effect)
                                ? 1e-3 * effect.parameters[index].sigma
                                : effect.searched_change(moved[k].x[index]);
        moved[k].x[index] += size;
        fit.J.col(column++) = (simulated_with(fit.model, moved) - simulated) / size;
      }
    }
    fit.J = fit.J.unaryExpr([](double v) { return std::isfinite(v) ? v : 0.0; }).eval();

    const Eigen::VectorXd root = fit.root();
    const Eigen::Index n = readings.count();
    Eigen::MatrixXd A = Eigen::MatrixXd::Zero(n + m, count + m);
    A.topLeftCorner(n, count) = root.asDiagonal() * fit.J;
    Eigen::VectorXd target = Eigen::VectorXd::Zero(n + m);
    target.head(n) = root.cwiseProduct(fit.residual_mm);
    if (m > 0) {
      A.topRightCorner(n, m) = root.asDiagonal() * fit.random;
      A.bottomRightCorner(m, m).setIdentity();
      target.tail(m) = -fit.u;
    }
    Eigen::VectorXd scale(count + m);
    for (Eigen::Index i = 0; i < count + m; ++i) {
      const double norm = A.col(i).norm();
      scale[i] = norm > 0 ? 1.0 / norm : 0.0;
      A.col(i) *= scale[i];
    }
    // Damped steps: some effects bend the same way as lengths do, to a millionth.
    const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> eigen(A.transpose() * A);
    const Eigen::VectorXd along = eigen.eigenvectors().transpose() * (A.transpose() * target);
    const double largest = eigen.eigenvalues().maxCoeff();
    const Eigen::Index seen = (eigen.eigenvalues().array() > kUnseen * largest).count();
    fit.fitted = static_cast<int>(seen - m);

    const double before =
        root.cwiseProduct(fit.residual_mm).squaredNorm() + fit.u.squaredNorm();
    ModelVector model;
    std::vector<ActiveEffect> next;
    Eigen::VectorXd residual;
    Eigen::VectorXd u;
    double after = 0.0;
    bool accepted = false;
    for (damping /= 100; damping < kMostDamping; damping = std::max(10 * damping, 1e-10)) {
      if (damping < 1e-10) damping = 0.0;
      const Eigen::VectorXd change = scale.cwiseProduct(
          eigen.eigenvectors() *
          (along.array() * eigen.eigenvalues().array().unaryExpr([&](double value) {
            return value > kUnseen * largest ? 1.0 / (value + damping * largest) : 0.0;
          })).matrix());
      if (!change.allFinite()) break;
      model = fit.model + change.head(parameters);
      next = fit.effects;
      Eigen::Index at = parameters;
      for (ActiveEffect& active : next) {
        for (int i = 0; i < fitted_count(*active.effect); ++i) {
          active.x[static_cast<std::size_t>(i)] += change[at++];
        }
      }
      u = fit.u + change.tail(m);
      residual = residual_with(model, next, u);
      after = root.cwiseProduct(residual).squaredNorm() + u.squaredNorm();
      accepted = after <= before * (1 + 1e-12);
      if (accepted) break;
    }
    if (!accepted) {
      fit.converged = true;  // no direction is downhill
      break;
    }
    const double moved = root.cwiseProduct(residual - fit.residual_mm).norm();
    const double last = fit.log_likelihood;
    fit.model = model;
    fit.effects = std::move(next);
    fit.residual_mm = std::move(residual);
    fit.u = std::move(u);
    weigh(fit, smallest_s_mm);
    if (step < plain_steps) {
      fit.s_mm =
          std::max(smallest_s_mm, robust_scale(fit.residual_mm.cwiseQuotient(fit.noise)));
      fit.gross_share = kLeastGrossShare;
      constexpr double kSettled = 0.01;  // of the squares, less and the weights may come in
      if (before - after < kSettled * before) plain_steps = step;
      continue;
    }
    const bool free = damping < 1e-9 || before - after < 1e-6 * before;
    if (free && moved < 1e-3 * fit.s_mm * std::sqrt(static_cast<double>(readings.count())) &&
        std::abs(fit.log_likelihood - last) < 1e-2) {
      fit.converged = true;
      break;
    }
  }
  finish(fit);
  return fit;
}

}  // namespace

JointFit fit_jointly(
    const Readings& readings, const ModelVector& start, std::vector<ActiveEffect> effects,
    const JointFit* near, const Eigen::MatrixXd& random) {
  // From far away every reading counts until the steps are small.
  constexpr int kFromFar = 12;
  JointFit fit = fit_from(readings, start, effects, near, random, near ? 0 : kFromFar);
  // So many gross readings are more often a fit that settled on a part of the session.
  constexpr double kSuspicious = 0.08;
  if (near && (fit.gross_share > kSuspicious || !fit.converged)) {
    JointFit again = fit_from(readings, start, std::move(effects), near, random, kFromFar);
    if (again.log_likelihood > fit.log_likelihood) fit = std::move(again);
  }
  return fit;
}

}  // namespace sixdial::diagnosis
