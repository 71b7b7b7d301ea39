// Gaussian process on the residual of each channel: squared exponential with a length for each
// joint and noise, hyperparameters at the maximum of the marginal likelihood. Gives a standard
// deviation. Cost grows with the cube of the samples, so a spread-out choice of at most 400 is
// used.
#include <fmt/format.h>

#include <Eigen/Cholesky>
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "calibration/residual_model.h"

namespace sixdial::calibration {
namespace {

using Eigen::MatrixXd;
using Eigen::VectorXd;

constexpr Eigen::Index kMostSamples = 400;
constexpr int kMostSteps = 60;
constexpr double kSettled = 1e-5;   // gradient of the log likelihood
constexpr double kLeastLog = -7.0;  // of every hyperparameter, standardised
constexpr double kMostLog = 4.0;
constexpr double kJitter = 1e-10;
/// Logs of signal, every length and noise from which the likelihood is climbed.
struct Start {
  double signal, length, noise;
};
constexpr std::array kStarts{
    Start{0.0, 0.0, -1.0}, Start{0.0, -1.0, -2.0}, Start{-2.0, 1.0, 0.0}};

/// Logs of: signal sd, a length for each input, noise sd; all standardised.
using Hyper = VectorXd;

struct Process {
  MatrixXd x;
  VectorXd y;

  [[nodiscard]] MatrixXd kernel(const MatrixXd& a, const Hyper& h) const {
    const Eigen::RowVectorXd inverse =
        (-h.segment(1, x.cols()).array()).exp().matrix().transpose();
    const MatrixXd u = (a.array().rowwise() * inverse.array()).matrix();
    const MatrixXd w = (x.array().rowwise() * inverse.array()).matrix();
    MatrixXd K = -u * w.transpose();
    K.colwise() += 0.5 * u.rowwise().squaredNorm();
    K.rowwise() += 0.5 * w.rowwise().squaredNorm().transpose();
    return (std::exp(2 * h[0]) * (-K.array().max(0.0)).exp()).matrix();
  }

  /// Minus log marginal likelihood and its gradient.
  double cost(const Hyper& h, Hyper& gradient) const {
    const MatrixXd S = kernel(x, h);
    MatrixXd K = S;
    const double noise = std::exp(2 * h[h.size() - 1]);
    K.diagonal().array() += noise + kJitter;
    const Eigen::LLT<MatrixXd> llt(K);
    if (llt.info() != Eigen::Success) return std::numeric_limits<double>::infinity();
    const VectorXd alpha = llt.solve(y);
    const MatrixXd L = llt.matrixL();
    MatrixXd M = llt.solve(MatrixXd::Identity(K.rows(), K.cols()));
    M -= alpha * alpha.transpose();  // d cost = trace(M dK) / 2
    const MatrixXd MS = M.cwiseProduct(S);
    gradient[0] = MS.sum();
    for (Eigen::Index i = 0; i < x.cols(); ++i) {
      const VectorXd xi = x.col(i) * std::exp(-h[1 + i]);
      // sum of MS_ab (xi_a - xi_b)^2 / 2
      gradient[1 + i] = MS.rowwise().sum().dot(xi.cwiseAbs2()) - xi.dot(MS * xi);
    }
    gradient[h.size() - 1] = noise * M.trace();
    return 0.5 * y.dot(alpha) + L.diagonal().array().log().sum();
  }
};

/// A length shorter than the distance between samples makes every one its own signal: noise
/// would be learned by heart. Half the samples have a neighbour within this distance.
double usual_distance(const MatrixXd& x) {
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
  Hyper gradient(h.size());
  cost = process.cost(h, gradient);
  const MatrixXd I = MatrixXd::Identity(h.size(), h.size());
  MatrixXd H = 0.1 * I;
  for (int step = 0; step < kMostSteps && gradient.norm() > kSettled; ++step) {
    Hyper direction = -H * gradient;
    if (direction.dot(gradient) >= 0.0) {
      H = 0.1 * I;
      direction = -H * gradient;
    }
    const double length = direction.norm();
    if (length > 1.0) direction /= length;
    bool moved = false;
    for (double part = 1.0; part > 1e-6 && !moved; part /= 3) {
      const Hyper next = (h + part * direction).cwiseMax(least).cwiseMin(kMostLog);
      Hyper next_gradient(h.size());
      const double next_cost = process.cost(next, next_gradient);
      if (!(next_cost < cost)) continue;
      const Hyper s = next - h;
      const Hyper d = next_gradient - gradient;
      if (s.dot(d) > 1e-12) {
        const double rho = 1.0 / s.dot(d);
        H = ((I - rho * s * d.transpose()) * H * (I - rho * d * s.transpose()) +
             rho * s * s.transpose())
                .eval();
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
  const double noise = std::exp(2 * fitted.h[fitted.h.size() - 1]) + kJitter;
  K.diagonal().array() += noise;
  fitted.llt.compute(K);
  fitted.alpha = fitted.llt.solve(fitted.process.y);
  fitted.effective = static_cast<double>(K.rows()) -
                     noise * fitted.llt.solve(MatrixXd::Identity(K.rows(), K.cols())).trace();
}

Fitted fit(const MatrixXd& x, const VectorXd& target) {
  Fitted result;
  result.y_mean = target.mean();
  result.y_scale = std::sqrt(
      (target.array() - result.y_mean).square().sum() / static_cast<double>(target.size()));
  if (!(result.y_scale > 0.0)) result.y_scale = 1.0;
  result.process = {x, (target.array() - result.y_mean) / result.y_scale};
  const double shortest = std::max(std::log(usual_distance(x)), kLeastLog);
  Hyper least = Hyper::Constant(x.cols() + 2, shortest);
  least[0] = least[x.cols() + 1] = kLeastLog;
  double best = std::numeric_limits<double>::infinity();
  for (const auto& [signal, length, noise] : kStarts) {
    Hyper start = Hyper::Constant(x.cols() + 2, length);
    start[0] = signal;
    start[x.cols() + 1] = noise;
    double cost = 0.0;
    const Hyper h = best_from(result.process, least, start, cost);
    if (cost < best) {
      best = cost;
      result.h = h;
    }
  }
  return result;
}

/// What people read of one output's process.
std::string words(const Fitted& p) {
  const Eigen::Index lengths = p.h.size() - 2;
  std::string text = "lengths";
  for (Eigen::Index i = 0; i < lengths; ++i)
    text += fmt::format(" {:.2f}", std::exp(p.h[1 + i]));
  return text + fmt::format(
                    ", signal {:.4f} mm, noise {:.4f} mm", p.y_scale * std::exp(p.h[0]),
                    p.y_scale * std::exp(p.h[lengths + 1]));
}

double mean_at(const Fitted& p, const MatrixXd& at) {
  return p.y_mean + p.y_scale * p.process.kernel(at, p.h).row(0).dot(p.alpha);
}

double sd_at(const Fitted& p, const MatrixXd& at) {
  const VectorXd k = p.process.kernel(at, p.h).row(0).transpose();
  const double variance = std::exp(2 * p.h[0]) - k.dot(p.llt.solve(k));
  return p.y_scale * std::sqrt(std::max(variance, 0.0));
}

void save(const Fitted& fitted, const std::string& prefix, SavedResidual& saved) {
  saved[prefix + "targets"] = fitted.process.y;
  saved[prefix + "log_hyperparameters"] = fitted.h;
  saved[prefix + "mean"] = number_to_save(fitted.y_mean);
  saved[prefix + "scale"] = number_to_save(fitted.y_scale);
}

Fitted fitted_from(const MatrixXd& x, const std::string& prefix, const SavedResidual& saved) {
  Fitted fitted;
  fitted.process = {x, saved_matrix(saved, prefix + "targets", x.rows(), 1)};
  fitted.h = saved_matrix(saved, prefix + "log_hyperparameters", x.cols() + 2, 1);
  fitted.y_mean = saved_number(saved, prefix + "mean");
  fitted.y_scale = saved_number(saved, prefix + "scale");
  solve(fitted);
  return fitted;
}

TrainedResidual load(const SavedResidual& saved) {
  const Standardiser standard(saved);
  const MatrixXd x = saved_matrix(saved, "samples", -1, standard.mean.size());
  const Eigen::Index outputs = saved_outputs(saved);
  const auto processes = std::make_shared<std::vector<Fitted>>();
  TrainedResidual result;
  result.effective_parameters.resize(outputs);
  for (Eigen::Index k = 0; k < outputs; ++k) {
    processes->push_back(fitted_from(x, output_prefix(k), saved));
    result.effective_parameters[k] = processes->back().effective;
  }
  const auto of_each = [standard, processes](double (*value)(const Fitted&, const MatrixXd&)) {
    return [standard, processes, value](const VectorXd& q) {
      const MatrixXd at = standard(q.transpose());
      VectorXd answer(std::ssize(*processes));
      for (std::size_t k = 0; k < processes->size(); ++k) {
        answer[static_cast<Eigen::Index>(k)] = value((*processes)[k], at);
      }
      return answer;
    };
  };
  result.correction = of_each(mean_at);
  result.sd = of_each(sd_at);
  return result;
}

TrainedResidual train(
    const MatrixXd& joints, const MatrixXd& residual_mm, const ResidualSettings& settings,
    const std::stop_token&) {
  const Standardiser standard(joints);
  const Eigen::Index stride = (joints.rows() + kMostSamples - 1) / kMostSamples;
  const auto chosen = Eigen::seq(0, joints.rows() - 1, stride);
  const MatrixXd x = standard(joints)(chosen, Eigen::all);
  std::vector<Fitted> processes;
  SavedResidual saved;
  standard.save(saved);
  saved["samples"] = x;
  save_outputs(residual_mm.cols(), saved);
  for (Eigen::Index k = 0; k < residual_mm.cols(); ++k) {
    processes.push_back(fit(x, residual_mm.col(k)(chosen)));
    save(processes.back(), output_prefix(k), saved);
  }
  TrainedResidual result = load(saved);
  result.saved = std::move(saved);
  result.note = by_output(settings, residual_mm.cols(), [&](Eigen::Index k) {
    return words(processes[static_cast<std::size_t>(k)]);
  });
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
