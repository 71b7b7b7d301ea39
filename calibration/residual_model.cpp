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

/// The model with angles clamped to the trained box and the output to the learned range.
TrainedResidual bounded(TrainedResidual result, const SavedResidual& saved) {
  const auto pair = [&](const char* name) {
    return Eigen::Vector2d(saved_matrix(saved, name, 1, 2).transpose());
  };
  const auto inside = [low = pair("box_low"),
                       high = pair("box_high")](const Eigen::Vector2d& q) {
    return Eigen::Vector2d(q.cwiseMax(low).cwiseMin(high));
  };
  result.correction = [inner = std::move(result.correction), inside, low = pair("output_low"),
                       high = pair("output_high")](const Eigen::Vector2d& q) {
    return Eigen::Vector2d(inner(inside(q)).cwiseMax(low).cwiseMin(high));
  };
  if (result.sd) {
    result.sd = [inner = std::move(result.sd), inside](const Eigen::Vector2d& q) {
      return inner(inside(q));
    };
  }
  return result;
}

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
  const Eigen::RowVector2d low = residual_mm.colwise().minCoeff();
  const Eigen::RowVector2d high = residual_mm.colwise().maxCoeff();
  const Eigen::RowVector2d margin = kMargin * (high - low);
  result.saved["box_low"] = q_rad.colwise().minCoeff();
  result.saved["box_high"] = q_rad.colwise().maxCoeff();
  // Zero stays allowed: "no correction" is never out of bounds.
  result.saved["output_low"] = (low - margin).cwiseMin(0.0);
  result.saved["output_high"] = (high + margin).cwiseMax(0.0);
  const SavedResidual saved = result.saved;
  return bounded(std::move(result), saved);
}

TrainedResidual load_residual(const ResidualModel& model, const SavedResidual& saved) {
  TrainedResidual result = model.load(saved);
  result.saved = saved;
  return bounded(std::move(result), saved);
}

const Eigen::MatrixXd& saved_matrix(
    const SavedResidual& saved, const std::string& name, Eigen::Index rows,
    Eigen::Index columns) {
  const auto found = saved.find(name);
  if (found == saved.end()) throw std::invalid_argument("there is no \"" + name + "\"");
  const Eigen::MatrixXd& matrix = found->second;
  if ((rows >= 0 && matrix.rows() != rows) || (columns >= 0 && matrix.cols() != columns)) {
    throw std::invalid_argument(
        "\"" + name + "\" has " + std::to_string(matrix.rows()) + " x " +
        std::to_string(matrix.cols()) + " numbers, which does not fit");
  }
  if (!matrix.allFinite()) {
    throw std::invalid_argument("\"" + name + "\" holds what is not a number");
  }
  return matrix;
}

double saved_number(const SavedResidual& saved, const std::string& name) {
  return saved_matrix(saved, name, 1, 1)(0, 0);
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

Standardiser::Standardiser(const SavedResidual& saved)
    : mean(saved_matrix(saved, "input_mean", 1, 2)),
      scale(saved_matrix(saved, "input_scale", 1, 2)) {}

void Standardiser::save(SavedResidual& saved) const {
  saved["input_mean"] = mean;
  saved["input_scale"] = scale;
}

}  // namespace sixdial::calibration
