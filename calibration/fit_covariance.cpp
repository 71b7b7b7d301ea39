#include "calibration/fit_covariance.h"

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <Eigen/QR>
#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <optional>
#include <utility>
#include <vector>

#include "calibration/rig_errors.h"
#include "calibration/sandwich.h"

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
    std::pair{SmoothOver::kJoints, 1.6}, std::pair{SmoothOver::kJoints, 3.2},
    std::pair{SmoothOver::kOrder, 0.1},  std::pair{SmoothOver::kOrder, 0.3}};
/// Less of all that the residuals leave possible changes no interval.
constexpr double kLeastWeight = 1e-3;

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

/// Log of the restricted likelihood for gamma = tau^2 / sigma^2, sigma profiled out. With
/// structure Phi the residuals' covariance is sigma^2 (I + gamma Phi Phi'). Tridiagonal in the
/// right coordinates, so that each gamma costs next to nothing.
class Likelihood {
 public:
  Likelihood(const MatrixXd& Phi, const VectorXd& r, double freedom)
      : wide_(Phi.cols() > Phi.rows()), rr_(r.squaredNorm()), freedom_(freedom) {
    const MatrixXd A =
        wide_ ? MatrixXd(Phi * Phi.transpose()) : MatrixXd(Phi.transpose() * Phi);
    const VectorXd b = wide_ ? r : VectorXd(Phi.transpose() * r);
    if (A.rows() < 2 || !(A.trace() > 0.0)) return;
    const Eigen::Tridiagonalization<MatrixXd> T(A);
    diagonal_ = T.diagonal();
    beside_ = T.subDiagonal();
    b_ = T.matrixQ().adjoint() * b;
  }
  [[nodiscard]] bool empty() const { return diagonal_.size() == 0; }

  [[nodiscard]] double variance(double gamma) const { return at(gamma).variance; }
  [[nodiscard]] double log(double gamma) const { return at(gamma).log; }

  struct At {
    double variance, log;
  };
  [[nodiscard]] At at(double gamma) const {
    // L D L' of I + gamma T, and b' (I + gamma T)^-1 b.
    double log_det = 0.0, quadratic = 0.0, pivot = 1.0, y = 0.0;
    for (Index i = 0; i < diagonal_.size(); ++i) {
      const double beside = i > 0 ? gamma * beside_[i - 1] : 0.0;
      const double factor = i > 0 ? beside / pivot : 0.0;
      pivot = std::max(1.0 + gamma * diagonal_[i] - factor * beside, 1e-12);
      y = b_[i] - factor * y;
      log_det += std::log(pivot);
      quadratic += y * y / pivot;
    }
    const double left = wide_ ? quadratic : rr_ - gamma * quadratic;
    const double variance = std::max(left, 1e-12 * rr_) / freedom_;
    return {variance, -0.5 * (freedom_ * std::log(variance) + log_det)};
  }

  /// gamma in which the structure that is seen is as large as the noise.
  [[nodiscard]] double unit() const {
    return static_cast<double>(diagonal_.size()) / diagonal_.sum();
  }
  /// gamma of the largest likelihood.
  [[nodiscard]] double best() const {
    double best_log10 = -4.0;
    const auto value = [&](double log10) { return log(unit() * std::pow(10.0, log10)); };
    double top = value(best_log10);
    const auto look = [&](double log10) {
      const double here = value(log10);
      if (here <= top) return;
      top = here;
      best_log10 = log10;
    };
    for (double log10 = -4.0; log10 <= 4.0; log10 += 0.25) look(log10);
    for (double step = 0.125; step > 0.01; step *= 0.5) {
      const double middle = best_log10;
      look(middle - step);
      look(middle + step);
    }
    return unit() * std::pow(10.0, best_log10);
  }

 private:
  bool wide_;
  double rr_, freedom_;
  VectorXd diagonal_, beside_, b_;
};

/// The averaged residuals without what a change of the parameters explains.
struct Remainder {
  const ObservationSpace& space;
  const LeastSquaresFit& fit;
  Averaged rows;
  VectorXd weight;         // of each averaged row
  std::vector<Index> row;  // of its sample
  MatrixXd Q;
  VectorXd r;
  double freedom = 0.0;
};

/// Only the row's own weight: correlated rows differ in that by little.
void set_weights(Remainder& of, Weighting weighting) {
  const std::vector<MatrixXd> weights = of.space.weights(weighting);
  of.weight.resize(of.rows.residual.size());
  of.row.resize(static_cast<std::size_t>(of.weight.size()), 0);
  for (Index i = 0; i < of.weight.size(); ++i) {
    const auto at = static_cast<std::size_t>(i);
    const int sample = of.rows.sample[at];
    const auto k = static_cast<std::size_t>(sample);
    const MatrixXd W = weight_of(weights, sample, of.space.rows(sample));
    for (int row = 0; row < of.space.rows(sample); ++row) {
      if (of.space.channel[static_cast<std::size_t>(of.space.first_row[k] + row)] !=
          of.rows.channel[at]) {
        continue;
      }
      of.weight[i] = of.rows.count[i] * W(row, row);
      of.row[at] = row;
    }
  }
}

/// Empty with too few rows to tell anything.
std::optional<Remainder> remainder_of(
    const ObservationSpace& space, const LeastSquaresFit& fit, Weighting weighting) {
  Remainder result{space, fit, averaged(space, fit), {}, {}, {}, {}};
  const Index determined = fit.singular_values.size() - fit.held;
  const Index freedom = result.rows.residual.size() - determined -
                        static_cast<Index>(space.unknowns_per_sample) * space.samples();
  if (freedom < kLeastFreedom || !(fit.rss > 0.0)) return std::nullopt;
  set_weights(result, weighting);
  const MatrixXd seen =
      result.rows.J * fit.scale.asDiagonal() * fit.directions.leftCols(determined);
  const Eigen::HouseholderQR<MatrixXd> qr(seen);
  result.Q = qr.householderQ() * MatrixXd::Identity(seen.rows(), seen.cols());
  result.r = result.rows.residual - result.Q * (result.Q.transpose() * result.rows.residual);
  result.freedom = static_cast<double>(freedom);
  return result;
}

/// Of structure with the shapes `phi` (samples x shapes) in what is left.
Likelihood likelihood_of(const Remainder& of, const MatrixXd& phi, const Moves& moves) {
  MatrixXd Phi(of.r.size(), phi.cols() * moves.functions());
  for (Index i = 0; i < Phi.rows(); ++i) {
    const auto k = static_cast<std::size_t>(i);
    const int sample = of.rows.sample[k];
    for (Index f = 0; f < moves.functions(); ++f) {
      Phi.block(i, f * phi.cols(), 1, phi.cols()) =
          of.weight[i] * moves.by(sample, of.row[k], f) * phi.row(sample);
    }
  }
  Phi -= of.Q * (of.Q.transpose() * Phi);
  return {Phi, of.r, of.freedom};
}

/// All sizes of a kind that the residuals leave possible: its weight so far is the logarithm of
/// the mean likelihood, tau and sigma are root mean squares.
StructurePart over_all_sizes(StructurePart kind, const Likelihood& of) {
  std::vector<double> logs, gammas;
  for (double at = -3.0; at <= 4.0; at += 0.25) {
    gammas.push_back(of.unit() * std::pow(10.0, at));
    logs.push_back(of.log(gammas.back()));
  }
  const double top = *std::ranges::max_element(logs);
  double sum = 0.0, tau2 = 0.0, sigma2 = 0.0;
  for (std::size_t i = 0; i < logs.size(); ++i) {
    const double share = std::exp(logs[i] - top);
    const double variance = of.variance(gammas[i]);
    sum += share;
    tau2 += share * gammas[i] * variance;
    sigma2 += share * variance;
  }
  kind.sd_mm = std::sqrt(tau2 / sum);
  kind.noise_mm = std::sqrt(sigma2 / sum);
  kind.weight = top + std::log(sum / static_cast<double>(logs.size()));
  return kind;
}

/// From logarithms to shares of 1; what hardly counts goes.
void normalise(std::vector<StructurePart>& parts) {
  const auto heaviest = std::ranges::max_element(parts, {}, &StructurePart::weight);
  if (heaviest == parts.end()) return;
  const double top = heaviest->weight;
  for (StructurePart& each : parts) each.weight = std::exp(each.weight - top);
  const auto sum = [&] {
    double total = 0.0;
    for (const StructurePart& each : parts) total += each.weight;
    return total;
  };
  const double least = kLeastWeight * sum();
  std::erase_if(parts, [&](const StructurePart& each) { return each.weight < least; });
  const double total = sum();
  for (StructurePart& each : parts) each.weight /= total;
}

std::vector<SmoothActs> acts_of(const ObservationSpace& space) {
  // Places that a tool is brought to have no error of their own from pose to pose.
  if (space.by_tool && space.position_axes > 0) return {SmoothActs::kTool};
  std::vector<SmoothActs> acts{SmoothActs::kChannels};
  if (space.by_tool) acts.push_back(SmoothActs::kTool);
  return acts;
}

}  // namespace

Structure smooth_structure(
    const ObservationSpace& space, const LeastSquaresFit& fit, Weighting weighting) {
  Structure found;
  if (fit.residual.size() != space.rows() || space.samples() < 2) return found;
  const auto left = remainder_of(space, fit, weighting);
  if (!left) return found;
  std::vector<StructurePart> parts;
  const std::vector<SmoothActs> all_acts = acts_of(space);
  std::vector<Moves> moves;
  for (const SmoothActs acts : all_acts) moves.emplace_back(space, fit.x, acts);
  for (const auto& [over, length] : kLengths) {
    const MatrixXd phi = SmoothBasis(space, over, length)(space);
    for (std::size_t k = 0; k < all_acts.size(); ++k) {
      const StructurePart kind{.over = over, .acts = all_acts[k], .length = length};
      const Likelihood of = likelihood_of(*left, phi, moves[k]);
      if (of.empty()) continue;
      parts.push_back(over_all_sizes(kind, of));
      const double gamma = of.best();
      const double gain = of.log(gamma) - of.log(0.0);
      if (!(gain > std::max(kLeastLogGain, found.log_gain))) continue;
      const double sigma2 = of.variance(gamma);
      found = {
          .over = over,
          .sd_mm = std::sqrt(gamma * sigma2),
          .length = length,
          .noise_mm = std::sqrt(sigma2),
          .log_gain = gain,
          .acts = all_acts[k]};
    }
  }
  if (!(found.sd_mm > 0.0)) return found;
  normalise(parts);
  found.parts = std::move(parts);
  return found;
}

MatrixXd fit_covariance(
    const ObservationSpace& space, const LeastSquaresFit& fit, Weighting weighting,
    double sigma_mm, const Structure& structure) {
  const Sandwich sandwich = sandwich_of(space, fit, weighting);
  const MatrixXd rig = moved_by_rig(space, sandwich);
  MatrixXd result = rig * rig.transpose();
  if (!(structure.sd_mm > 0.0)) return result + sigma_mm * sigma_mm * sandwich.noise;
  for (const StructurePart& part : parts_of(structure)) {
    const Moves moves(space, fit.x, part.acts);
    const MatrixXd moved =
        moved_by(space, sandwich, moves, SmoothBasis(space, part.over, part.length)(space));
    result += part.weight * (part.noise_mm * part.noise_mm * sandwich.noise +
                             part.sd_mm * part.sd_mm * moved * moved.transpose());
  }
  return result;
}

}  // namespace sixdial::calibration
