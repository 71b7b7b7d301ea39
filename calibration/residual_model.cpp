#include "calibration/residual_model.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numeric>
#include <stdexcept>
#include <string>
#include <utility>

#include "calibration/random.h"
#include "calibration/registry.h"

namespace sixdial::calibration {

extern const ResidualModel no_residual_model;
extern const ResidualModel bpnn;
extern const ResidualModel anfis_chosen;
extern const ResidualModel anfis_paper;
extern const ResidualModel gaussian_process;
extern const ResidualModel rbf;

namespace {

using Eigen::MatrixXd;
using Eigen::VectorXd;

constexpr std::array kTable{&no_residual_model, &bpnn, &anfis_chosen, &anfis_paper,
                            &gaussian_process,  &rbf};
constexpr std::uint32_t kHoldoutStream = 32;
constexpr double kMargin = 0.1;  // of the residuals' range, allowed beyond it
constexpr Eigen::Index kLeastSamples = 5;

using Models = Registry<ResidualModel, TrainFunction>;
Models& models() {
  static Models registry(kTable);
  return registry;
}

void check(
    const MatrixXd& joints, const MatrixXd& residual_mm, const ResidualSettings& settings) {
  if (joints.rows() != residual_mm.rows() || joints.rows() < kLeastSamples ||
      !joints.allFinite() || !residual_mm.allFinite()) {
    throw std::invalid_argument(
        "train_residual: at least five samples with finite joint values and residuals are "
        "needed");
  }
  if (joints.cols() == 0 || residual_mm.cols() == 0) {
    throw std::invalid_argument("train_residual: a joint and a channel at least are needed");
  }
  for (const int input : settings.inputs) {
    if (input < 0 || input >= joints.cols()) {
      throw std::invalid_argument(
          "train_residual: there is no joint " + std::to_string(input + 1) + " of " +
          std::to_string(joints.cols()));
    }
  }
}

}  // namespace

std::vector<const ResidualModel*> all_residual_models() { return models().all(); }

const ResidualModel* find_residual_model(std::string_view name) { return models().find(name); }

const ResidualModel& add_residual_model(
    std::string name, std::string description, TrainFunction train) {
  return models().add(std::move(name), std::move(description), std::move(train));
}

TrainedResidual train_residual(
    const ResidualModel& model, const MatrixXd& joints, const MatrixXd& residual_mm,
    const ResidualSettings& settings, const std::stop_token& stop) {
  check(joints, residual_mm, settings);
  std::vector<int> inputs = settings.inputs;
  if (inputs.empty()) {
    inputs.resize(static_cast<std::size_t>(joints.cols()));
    std::iota(inputs.begin(), inputs.end(), 0);
  }
  const MatrixXd seen = joints(Eigen::all, inputs);
  TrainedResidual result = model.made != nullptr
                               ? (*model.made)(seen, residual_mm, settings, stop)
                               : model.train(seen, residual_mm, settings, stop);
  const VectorXd low = residual_mm.colwise().minCoeff();
  const VectorXd high = residual_mm.colwise().maxCoeff();
  const VectorXd margin = kMargin * (high - low);
  // Zero stays allowed: "no correction" is never out of bounds.
  const VectorXd least = (low - margin).cwiseMin(0.0);
  const VectorXd most = (high + margin).cwiseMax(0.0);
  const auto inside = [inputs, box_low = VectorXd(seen.colwise().minCoeff()),
                       box_high = VectorXd(seen.colwise().maxCoeff())](const VectorXd& q) {
    return VectorXd(VectorXd(q(inputs)).cwiseMax(box_low).cwiseMin(box_high));
  };
  result.correction = [inner = std::move(result.correction), inside, least,
                       most](const VectorXd& q) {
    return VectorXd(inner(inside(q)).cwiseMax(least).cwiseMin(most));
  };
  if (result.sd) {
    result.sd = [inner = std::move(result.sd), inside](const VectorXd& q) {
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

Standardiser::Standardiser(const MatrixXd& columns) {
  mean = columns.colwise().mean();
  const auto n = static_cast<double>(columns.rows());
  scale = ((columns.rowwise() - mean).colwise().squaredNorm() / n).cwiseSqrt();
  for (double& each : scale) {
    if (!(each > 0.0)) each = 1.0;
  }
}

std::string by_output(
    const ResidualSettings& settings, Eigen::Index outputs,
    const std::function<std::string(Eigen::Index output)>& words) {
  std::string text;
  for (Eigen::Index k = 0; k < outputs; ++k) {
    const auto i = static_cast<std::size_t>(k);
    if (k > 0) text += "; ";
    text += i < settings.output_names.size() ? settings.output_names[i] : std::to_string(k + 1);
    text += ": " + words(k);
  }
  return text;
}

}  // namespace sixdial::calibration
