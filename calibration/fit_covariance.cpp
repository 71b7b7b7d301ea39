#include "calibration/fit_covariance.h"

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <Eigen/QR>
#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <utility>
#include <vector>

namespace sixdial::calibration {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

constexpr int kMostSamples = 400;  // that are looked at: enough to see what is smooth
constexpr int kLeastFreedom = 5;   // fewer residuals than this tell no structure
/// Twice the gain is compared with chi-square of one degree of freedom, which is halved as tau
/// cannot be negative: 1.35 comes by chance once in twenty.
constexpr double kLeastLogGain = 1.35;
constexpr std::array kLengths{
    std::pair{SmoothOver::kJoints, 0.1}, std::pair{SmoothOver::kJoints, 0.2},
    std::pair{SmoothOver::kJoints, 0.4}, std::pair{SmoothOver::kJoints, 0.8},
    std::pair{SmoothOver::kOrder, 0.1},  std::pair{SmoothOver::kOrder, 0.3}};

/// Rows of samples at the same pose, channel by channel, as one row that counts as often.
struct Averaged {
  VectorXd residual;
  MatrixXd J;
  std::vector<int> channel;
  std::vector<int> sample;  // one of them
  VectorXd count;           // square root of how many
};

Averaged averaged(const ObservationSpace& space, const LeastSquaresFit& fit) {
  std::map<std::pair<int, int>, std::vector<int>> rows_of;  // by point and channel
  const int step = std::max(1, (space.samples() + kMostSamples - 1) / kMostSamples);
  std::vector<int> sample_of(static_cast<std::size_t>(space.rows()), 0);
  for (int i = 0; i < space.samples(); i += step) {
    const auto k = static_cast<std::size_t>(i);
    for (int row = space.first_row[k]; row < space.first_row[k + 1]; ++row) {
      sample_of[static_cast<std::size_t>(row)] = i;
      rows_of[{space.point[k], space.channel[static_cast<std::size_t>(row)]}].push_back(row);
    }
  }
  Averaged result;
  const auto n = static_cast<Index>(rows_of.size());
  result.residual.resize(n);
  result.J.resize(n, fit.J.cols());
  result.count.resize(n);
  Index at = 0;
  for (const auto& [key, rows] : rows_of) {
    const double root = std::sqrt(static_cast<double>(rows.size()));
    result.residual[at] = fit.residual(rows).sum() / root;
    result.J.row(at) = fit.J(rows, Eigen::all).colwise().sum() / root;
    result.count[at] = root;
    result.channel.push_back(key.second);
    result.sample.push_back(sample_of[static_cast<std::size_t>(rows.front())]);
    ++at;
  }
  return result;
}

/// -2 log of the restricted likelihood for gamma = tau^2 / sigma^2, sigma profiled out.
struct Likelihood {
  VectorXd size;     // of the modes of structure
  VectorXd squared;  // residual along each, squared
  double rest = 0.0;
  double freedom = 0.0;
  [[nodiscard]] double variance(double gamma) const {
    return (rest + (squared.array() / (1.0 + gamma * size.array())).sum()) / freedom;
  }
  [[nodiscard]] double log(double gamma) const {
    return -0.5 *
           (freedom * std::log(variance(gamma)) + (1.0 + gamma * size.array()).log().sum());
  }
  /// gamma of the largest likelihood; 0: structure explains nothing.
  [[nodiscard]] double best() const {
    const double unit = 1.0 / size.mean();
    double best_log10 = -4.0;
    for (double at = -4.0; at <= 4.0; at += 0.25) {
      if (log(unit * std::pow(10.0, at)) > log(unit * std::pow(10.0, best_log10))) {
        best_log10 = at;
      }
    }
    for (double step = 0.125; step > 0.01; step *= 0.5) {
      for (const double at : {best_log10 - step, best_log10 + step}) {
        if (log(unit * std::pow(10.0, at)) > log(unit * std::pow(10.0, best_log10))) {
          best_log10 = at;
        }
      }
    }
    return unit * std::pow(10.0, best_log10);
  }
};

Likelihood likelihood(const MatrixXd& Phi, const VectorXd& r, double freedom) {
  const Eigen::SelfAdjointEigenSolver<MatrixXd> modes(Phi.transpose() * Phi);
  const VectorXd along = modes.eigenvectors().transpose() * (Phi.transpose() * r);
  const double least = 1e-9 * modes.eigenvalues().maxCoeff();
  const auto count = (modes.eigenvalues().array() > least).count();
  Likelihood result;
  result.size = modes.eigenvalues().tail(count);
  result.squared = along.tail(count).cwiseAbs2().cwiseQuotient(result.size);
  result.rest = std::max(r.squaredNorm() - result.squared.sum(), 0.0);
  result.freedom = freedom;
  return result;
}

/// Weight of each row by the fit's loss.
VectorXd loss_weights(const LeastSquaresFit& fit) {
  const Index rows = fit.residual.size();
  const auto blocks = static_cast<Index>(fit.block_weight.size());
  VectorXd result = VectorXd::Ones(rows);
  if (blocks == 0) return result;
  const Index block = rows / blocks;
  for (Index i = 0; i < rows; ++i) {
    result[i] = fit.block_weight[static_cast<std::size_t>(i / block)];
  }
  return result;
}

/// W of one sample.
MatrixXd weight_of(const std::vector<MatrixXd>& weights, int sample, Index rows) {
  return weights.empty() ? MatrixXd::Identity(rows, rows)
                         : weights[static_cast<std::size_t>(sample)];
}

/// Covariance of a sample's rows, in any unit.
MatrixXd known_covariance(const ObservationSpace& space, int sample) {
  const auto k = static_cast<std::size_t>(sample);
  const Index rows = space.rows(sample);
  if (k < space.covariance_mm2.size() && space.covariance_mm2[k].rows() == rows) {
    return space.covariance_mm2[k];
  }
  const VectorXd sigma = space.sigma_mm.segment(space.first_row[k], rows);
  return sigma.cwiseAbs2().asDiagonal();
}

}  // namespace

Structure smooth_structure(
    const ObservationSpace& space, const LeastSquaresFit& fit, Weighting weighting) {
  Structure found;
  if (fit.residual.size() != space.rows() || space.samples() < 2) return found;
  const Averaged rows = averaged(space, fit);
  const Index determined = fit.singular_values.size() - fit.held;
  const Index freedom = rows.residual.size() - determined -
                        static_cast<Index>(space.unknowns_per_sample) * space.samples();
  if (freedom < kLeastFreedom || !(fit.rss > 0.0)) return found;
  const std::vector<MatrixXd> weights = space.weights(weighting);
  // Only the row's own weight: correlated rows differ in that by little.
  VectorXd weight(rows.residual.size());
  for (Index i = 0; i < weight.size(); ++i) {
    const int sample = rows.sample[static_cast<std::size_t>(i)];
    const auto k = static_cast<std::size_t>(sample);
    const MatrixXd W = weight_of(weights, sample, space.rows(sample));
    for (int row = 0; row < space.rows(sample); ++row) {
      const auto at = static_cast<std::size_t>(space.first_row[k] + row);
      if (space.channel[at] == rows.channel[static_cast<std::size_t>(i)]) {
        weight[i] = rows.count[i] * W(row, row);
      }
    }
  }
  const MatrixXd seen = rows.J * fit.scale.asDiagonal() * fit.directions.leftCols(determined);
  const Eigen::HouseholderQR<MatrixXd> qr(seen);
  const MatrixXd Q = qr.householderQ() * MatrixXd::Identity(seen.rows(), seen.cols());
  const VectorXd r = rows.residual - Q * (Q.transpose() * rows.residual);
  for (const auto& [over, length] : kLengths) {
    const MatrixXd phi = SmoothBasis(space, over, length)(space);
    MatrixXd Phi = MatrixXd::Zero(rows.residual.size(), phi.cols() * space.channels());
    for (Index i = 0; i < Phi.rows(); ++i) {
      const auto k = static_cast<std::size_t>(i);
      Phi.block(i, rows.channel[k] * phi.cols(), 1, phi.cols()) =
          weight[i] * phi.row(rows.sample[k]);
    }
    Phi -= Q * (Q.transpose() * Phi);
    const Likelihood of = likelihood(Phi, r, static_cast<double>(freedom));
    if (of.size.size() == 0) continue;
    const double gamma = of.best();
    const double gain = of.log(gamma) - of.log(0.0);
    if (!(gain > std::max(kLeastLogGain, found.log_gain))) continue;
    const double sigma2 = of.variance(gamma);
    found = {over, std::sqrt(gamma * sigma2), length, std::sqrt(sigma2), gain};
  }
  return found;
}

MatrixXd fit_covariance(
    const ObservationSpace& space, const LeastSquaresFit& fit, Weighting weighting,
    double sigma_mm, const Structure& structure) {
  const MatrixXd unit = fit.unit_covariance();
  const std::vector<MatrixXd> weights = space.weights(weighting);
  const VectorXd loss = loss_weights(fit);
  const bool structured = structure.sd_mm > 0.0;
  MatrixXd phi;
  if (structured) phi = SmoothBasis(space, structure.over, structure.length)(space);
  MatrixXd noise = MatrixXd::Zero(unit.rows(), unit.cols());
  MatrixXd moved = MatrixXd::Zero(unit.rows(), phi.cols() * space.channels());
  double trace = 0.0;
  for (int i = 0; i < space.samples(); ++i) {
    const auto k = static_cast<std::size_t>(i);
    const int first = space.first_row[k];
    const Index count = space.rows(i);
    const MatrixXd W = weight_of(weights, i, count);
    const MatrixXd A = unit * fit.J.middleRows(first, count).transpose() *
                       loss.segment(first, count).asDiagonal();
    const MatrixXd S = W * known_covariance(space, i) * W.transpose();
    noise += A * S * A.transpose();
    trace += S.trace();
    if (!structured) continue;
    const MatrixXd AW = A * W;
    for (Index row = 0; row < count; ++row) {
      const int channel = space.channel[static_cast<std::size_t>(first + row)];
      moved.middleCols(channel * phi.cols(), phi.cols()) += AW.col(row) * phi.row(i);
    }
  }
  const double sigma = structured ? structure.noise_mm : sigma_mm;
  MatrixXd result = MatrixXd::Zero(unit.rows(), unit.cols());
  if (trace > 0.0) result = sigma * sigma * space.rows() / trace * noise;
  if (structured) {
    result += structure.sd_mm * structure.sd_mm * (moved * moved.transpose());
  }
  return result;
}

}  // namespace sixdial::calibration
