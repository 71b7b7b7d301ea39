#include "calibration/residual_model.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numeric>
#include <stdexcept>

#include "calibration/random.h"

namespace sixdial::calibration {

extern const ResidualModel no_residual_model;
extern const ResidualModel bpnn;
extern const ResidualModel anfis_chosen;
extern const ResidualModel anfis_paper;
extern const ResidualModel gaussian_process;
extern const ResidualModel rbf;

namespace {

constexpr std::array kTable{&no_residual_model, &bpnn, &anfis_chosen, &anfis_paper,
                            &gaussian_process,  &rbf};
constexpr std::uint32_t kHoldoutStream = 32;
constexpr double kMargin = 0.1;  // of the residuals' range, allowed beyond it

}  // namespace

std::span<const ResidualModel* const> all_residual_models() { return kTable; }

const ResidualModel* find_residual_model(std::string_view name) {
  for (const ResidualModel* each : kTable) {
    if (each->name == name) return each;
  }
  return nullptr;
}

TrainedResidual train_residual(
    const ResidualModel& model, const Eigen::MatrixX2d& q_rad,
    const Eigen::MatrixX2d& residual_mm, const ResidualSettings& settings,
    const std::stop_token& stop) {
  if (q_rad.rows() != residual_mm.rows() || q_rad.rows() < 5 || !q_rad.allFinite() ||
      !residual_mm.allFinite()) {
    throw std::invalid_argument(
        "train_residual: at least five samples with finite angles and residuals are needed");
  }
  TrainedResidual result = model.train(q_rad, residual_mm, settings, stop);
  const Eigen::Vector2d box_low = q_rad.colwise().minCoeff();
  const Eigen::Vector2d box_high = q_rad.colwise().maxCoeff();
  const Eigen::Vector2d low = residual_mm.colwise().minCoeff();
  const Eigen::Vector2d high = residual_mm.colwise().maxCoeff();
  const Eigen::Vector2d margin = kMargin * (high - low);
  const auto inside = [box_low, box_high](const Eigen::Vector2d& q) {
    return Eigen::Vector2d(q.cwiseMax(box_low).cwiseMin(box_high));
  };
  result.correction = [inner = std::move(result.correction), inside, low, high,
                       margin](const Eigen::Vector2d& q) {
    // Zero stays allowed: "no correction" is never out of bounds.
    return Eigen::Vector2d(inner(inside(q))
                               .cwiseMax((low - margin).cwiseMin(0.0))
                               .cwiseMin((high + margin).cwiseMax(0.0)));
  };
  if (result.sd) {
    result.sd = [inner = std::move(result.sd), inside](const Eigen::Vector2d& q) {
      return inner(inside(q));
    };
  }
  return result;
}

HoldoutSplit holdout_split(int n, double fraction, std::uint64_t seed) {
  std::vector<int> order(static_cast<std::size_t>(n));
  std::iota(order.begin(), order.end(), 0);
  RandomSequence random(seed, kHoldoutStream);
  for (int i = n - 1; i > 0; --i) {
    std::swap(
        order[static_cast<std::size_t>(i)],
        order[static_cast<std::size_t>(random.below(i + 1))]);
  }
  const auto held = static_cast<std::ptrdiff_t>(std::lround(fraction * n));
  HoldoutSplit split{
      {order.begin() + held, order.end()}, {order.begin(), order.begin() + held}};
  std::ranges::sort(split.train);
  std::ranges::sort(split.check);
  return split;
}

Standardiser::Standardiser(const Eigen::MatrixX2d& columns) {
  mean = columns.colwise().mean();
  const auto n = static_cast<double>(columns.rows());
  scale = ((columns.rowwise() - mean).colwise().squaredNorm() / n).cwiseSqrt();
  for (double& each : scale) {
    if (!(each > 0.0)) each = 1.0;
  }
}

}  // namespace sixdial::calibration
