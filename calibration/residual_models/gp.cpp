// Gaussian process on the residual of each axis: squared exponential with a length for each
// angle and noise, hyperparameters at the maximum of the marginal likelihood. Gives a standard
// deviation. Cost grows with the cube of the samples, so a spread-out choice of at most 400 is
// used.
#include <fmt/format.h>

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <limits>
#include <memory>
#include <string>
#include <vector>

#include "calibration/residual_model.h"

namespace sixdial::calibration {
namespace {

using Eigen::MatrixX2d;
using Eigen::MatrixXd;
using Eigen::Vector4d;
using Eigen::VectorXd;

constexpr Eigen::Index kMostSamples = 400;
constexpr int kMostSteps = 60;
constexpr double kSettled = 1e-5;   // gradient of the log likelihood
constexpr double kLeastLog = -7.0;  // of every hyperparameter, standardised
constexpr double kMostLog = 4.0;
constexpr double kJitter = 1e-10;

/// Logs of: signal sd, length 1, length 2, noise sd; all standardised.
using Hyper = Vector4d;

struct Process {
  MatrixX2d x;
  VectorXd y;

  [[nodiscard]] MatrixXd kernel(const MatrixX2d& a, const Hyper& h) const {
    const Eigen::RowVector2d inverse(std::exp(-h[1]), std::exp(-h[2]));
    const MatrixX2d u = (a.array().rowwise() * inverse.array()).matrix();
    const MatrixX2d w = (x.array().rowwise() * inverse.array()).matrix();
    MatrixXd K = -u * w.transpose();
    K.colwise() += 0.5 * u.rowwise().squaredNorm();
    K.rowwise() += 0.5 * w.rowwise().squaredNorm().transpose();
    return (std::exp(2 * h[0]) * (-K.array().max(0.0)).exp()).matrix();
  }

  /// Minus log marginal likelihood and its gradient.
  double cost(const Hyper& h, Hyper& gradient) const {
    const MatrixXd S = kernel(x, h);
    MatrixXd K = S;
    const double noise = std::exp(2 * h[3]);
    K.diagonal().array() += noise + kJitter;
    const Eigen::LLT<MatrixXd> llt(K);
    if (llt.info() != Eigen::Success) return std::numeric_limits<double>::infinity();
    const VectorXd alpha = llt.solve(y);
    const MatrixXd L = llt.matrixL();
    MatrixXd M = llt.solve(MatrixXd::Identity(K.rows(), K.cols()));
    M -= alpha * alpha.transpose();  // d cost = trace(M dK) / 2
    const MatrixXd MS = M.cwiseProduct(S);
    gradient[0] = MS.sum();
    for (int i = 0; i < 2; ++i) {
      const VectorXd xi = x.col(i) * std::exp(-h[1 + i]);
      // sum of MS_ab (xi_a - xi_b)^2 / 2
      gradient[1 + i] = MS.rowwise().sum().dot(xi.cwiseAbs2()) - xi.dot(MS * xi);
    }
    gradient[3] = noise * M.trace();
    return 0.5 * y.dot(alpha) + L.diagonal().array().log().sum();
  }
};

/// A length shorter than the distance between samples makes every one its own signal: noise
/// would be learned by heart. Half the samples have a neighbour within this distance.
double usual_distance(const MatrixX2d& x) {
  std::vector<double> nearest;
  for (Eigen::Index i = 0; i < x.rows(); ++i) {
    VectorXd distance = (x.rowwise() - x.row(i)).rowwise().norm();
    distance[i] = std::numeric_limits<double>::infinity();
    const double least = distance.minCoeff();
    if (least > 0.0) nearest.push_back(least);
  }
  if (nearest.empty()) return 0.0;
  const auto middle = nearest.begin() + std::ssize(nearest) / 2;
  std::ranges::nth_element(nearest, middle);
  return *middle;
}

/// Quasi-Newton (BFGS) descent inside the box.
Hyper best_from(const Process& process, const Hyper& least, Hyper h, double& cost) {
  h = h.cwiseMax(least);
  Hyper gradient;
  cost = process.cost(h, gradient);
  Eigen::Matrix4d H = 0.1 * Eigen::Matrix4d::Identity();
  for (int step = 0; step < kMostSteps && gradient.norm() > kSettled; ++step) {
    Hyper direction = -H * gradient;
    if (direction.dot(gradient) >= 0.0) {
      H = 0.1 * Eigen::Matrix4d::Identity();
      direction = -H * gradient;
    }
    const double length = direction.norm();
    if (length > 1.0) direction /= length;
    bool moved = false;
    for (double part = 1.0; part > 1e-6 && !moved; part /= 3) {
      const Hyper next = (h + part * direction).cwiseMax(least).cwiseMin(kMostLog);
      Hyper next_gradient;
      const double next_cost = process.cost(next, next_gradient);
      if (!(next_cost < cost)) continue;
      const Hyper s = next - h;
      const Hyper d = next_gradient - gradient;
      if (s.dot(d) > 1e-12) {
        const double rho = 1.0 / s.dot(d);
        const Eigen::Matrix4d I = Eigen::Matrix4d::Identity();
        H = (I - rho * s * d.transpose()) * H * (I - rho * d * s.transpose()) +
            rho * s * s.transpose();
      }
      h = next;
      cost = next_cost;
      gradient = next_gradient;
      moved = true;
    }
    if (!moved) break;
  }
  return h;
}

struct Fitted {
  Process process;
  Hyper h;
  double y_mean = 0.0;
  double y_scale = 1.0;
  VectorXd alpha;
  Eigen::LLT<MatrixXd> llt;
  double effective = 0.0;
};

/// From samples and hyperparameters to what answers.
void solve(Fitted& fitted) {
  MatrixXd K = fitted.process.kernel(fitted.process.x, fitted.h);
  const double noise = std::exp(2 * fitted.h[3]) + kJitter;
  K.diagonal().array() += noise;
  fitted.llt.compute(K);
  fitted.alpha = fitted.llt.solve(fitted.process.y);
  fitted.effective = static_cast<double>(K.rows()) -
                     noise * fitted.llt.solve(MatrixXd::Identity(K.rows(), K.cols())).trace();
}

Fitted fit(const MatrixX2d& x, const VectorXd& target) {
  Fitted result;
  result.y_mean = target.mean();
  result.y_scale = std::sqrt(
      (target.array() - result.y_mean).square().sum() / static_cast<double>(target.size()));
  if (!(result.y_scale > 0.0)) result.y_scale = 1.0;
  result.process = {x, (target.array() - result.y_mean) / result.y_scale};
  const double shortest = std::max(std::log(usual_distance(x)), kLeastLog);
  const Hyper least(kLeastLog, shortest, shortest, kLeastLog);
  double best = std::numeric_limits<double>::infinity();
  for (const Hyper& start :
       {Hyper(0.0, 0.0, 0.0, -1.0), Hyper(0.0, -1.0, -1.0, -2.0), Hyper(-2.0, 1.0, 1.0, 0.0)}) {
    double cost = 0.0;
    const Hyper h = best_from(result.process, least, start, cost);
    if (cost < best) {
      best = cost;
      result.h = h;
    }
  }
  return result;
}

void save(const Fitted& fitted, const std::string& axis, SavedResidual& saved) {
  saved[axis + ".targets"] = fitted.process.y;
  saved[axis + ".log_hyperparameters"] = fitted.h;
  saved[axis + ".mean"] = MatrixXd::Constant(1, 1, fitted.y_mean);
  saved[axis + ".scale"] = MatrixXd::Constant(1, 1, fitted.y_scale);
}

Fitted fitted_from(const MatrixX2d& x, const std::string& axis, const SavedResidual& saved) {
  Fitted fitted;
  fitted.process = {x, saved_matrix(saved, axis + ".targets", x.rows(), 1)};
  fitted.h = saved_matrix(saved, axis + ".log_hyperparameters", 4, 1);
  fitted.y_mean = saved_number(saved, axis + ".mean");
  fitted.y_scale = saved_number(saved, axis + ".scale");
  solve(fitted);
  return fitted;
}

TrainedResidual load(const SavedResidual& saved) {
  const Standardiser standard(saved);
  const MatrixX2d x = saved_matrix(saved, "samples", -1, 2);
  const auto px = std::make_shared<const Fitted>(fitted_from(x, "x", saved));
  const auto py = std::make_shared<const Fitted>(fitted_from(x, "y", saved));
  TrainedResidual result;
  result.effective_parameters = {px->effective, py->effective};
  result.correction = [standard, px, py](const Eigen::Vector2d& q) {
    const MatrixX2d at = standard(q.transpose());
    const auto mean = [&](const Fitted& p) {
      return p.y_mean + p.y_scale * p.process.kernel(at, p.h).row(0).dot(p.alpha);
    };
    return Eigen::Vector2d(mean(*px), mean(*py));
  };
  result.sd = [standard, px, py](const Eigen::Vector2d& q) {
    const MatrixX2d at = standard(q.transpose());
    const auto sd = [&](const Fitted& p) {
      const VectorXd k = p.process.kernel(at, p.h).row(0).transpose();
      const double variance = std::exp(2 * p.h[0]) - k.dot(p.llt.solve(k));
      return p.y_scale * std::sqrt(std::max(variance, 0.0));
    };
    return Eigen::Vector2d(sd(*px), sd(*py));
  };
  return result;
}

TrainedResidual train(
    const MatrixX2d& q_rad, const MatrixX2d& residual_mm, const ResidualSettings&,
    const std::stop_token&) {
  const Standardiser standard(q_rad);
  const Eigen::Index stride = (q_rad.rows() + kMostSamples - 1) / kMostSamples;
  const auto chosen = Eigen::seq(0, q_rad.rows() - 1, stride);
  const MatrixX2d x = standard(q_rad)(chosen, Eigen::all);
  const Fitted px = fit(x, residual_mm.col(0)(chosen));
  const Fitted py = fit(x, residual_mm.col(1)(chosen));
  const auto words = [](const Fitted& p) {
    return fmt::format(
        "lengths {:.2f} {:.2f}, signal {:.4f} mm, noise {:.4f} mm", std::exp(p.h[1]),
        std::exp(p.h[2]), p.y_scale * std::exp(p.h[0]), p.y_scale * std::exp(p.h[3]));
  };
  SavedResidual saved;
  standard.save(saved);
  saved["samples"] = x;
  save(px, "x", saved);
  save(py, "y", saved);
  TrainedResidual result = load(saved);
  result.saved = std::move(saved);
  result.note = "x: " + words(px) + "; y: " + words(py);
  return result;
}

}  // namespace

extern constinit const ResidualModel gaussian_process{
    .name = "gp",
    .title = "Gaussian process",
    .description = "Gaussian process, hyperparameters by marginal likelihood",
    .train = train,
    .load = load};

}  // namespace sixdial::calibration
