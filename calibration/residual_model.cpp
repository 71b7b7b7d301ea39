#include "calibration/residual_model.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numeric>
#include <stdexcept>
#include <string>
#include <utility>

#include "calibration/pose_groups.h"
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

constexpr std::array kModelTable{&no_residual_model, &bpnn, &anfis_chosen, &anfis_paper,
                                 &gaussian_process,  &rbf};
constexpr std::uint32_t kHoldoutStream = 32;
constexpr double kMargin = 0.1;  // of the residuals' range, allowed beyond it
constexpr Eigen::Index kLeastForAModel = 5;
constexpr double kMostOutputs = 1000;  // of a stored model
constexpr double kMostInput = 1e6;     // index of a joint in a stored model

using Models = Registry<ResidualModel, MadeResidualModel>;
Models& models() {
  static Models registry(kModelTable);
  return registry;
}

void check(
    const MatrixXd& joints, const MatrixXd& residual_mm, const ResidualSettings& settings) {
  if (joints.rows() != residual_mm.rows() || joints.rows() < kLeastForAModel ||
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

/// Which of a space's joints a stored model sees.
std::vector<int> saved_inputs(const SavedResidual& saved) {
  std::vector<int> inputs;
  for (const double each : saved_matrix(saved, "inputs", 1, -1).reshaped()) {
    if (!(each >= 0.0) || each > kMostInput) {
      throw std::invalid_argument("\"inputs\" names no joint");
    }
    inputs.push_back(static_cast<int>(each));
  }
  return inputs;
}

/// The model with its inputs picked out and clamped to the trained box, and the output clamped
/// to the learned range.
TrainedResidual bounded(TrainedResidual result, const SavedResidual& saved) {
  const std::vector<int> inputs = saved_inputs(saved);
  const auto column = [&](const char* name, Eigen::Index size) {
    return VectorXd(saved_matrix(saved, name, 1, size).transpose());
  };
  const Eigen::Index outputs = result.effective_parameters.size();
  const auto inside = [inputs, low = column("box_low", std::ssize(inputs)),
                       high = column("box_high", std::ssize(inputs))](const VectorXd& q) {
    return VectorXd(VectorXd(q(inputs)).cwiseMax(low).cwiseMin(high));
  };
  result.correction = [inner = std::move(result.correction), inside,
                       low = column("output_low", outputs),
                       high = column("output_high", outputs)](const VectorXd& q) {
    return VectorXd(inner(inside(q)).cwiseMax(low).cwiseMin(high));
  };
  if (result.sd) {
    result.sd = [inner = std::move(result.sd), inside](const VectorXd& q) {
      return inner(inside(q));
    };
  }
  return result;
}

}  // namespace

std::vector<const ResidualModel*> all_residual_models() { return models().all(); }

const ResidualModel* find_residual_model(std::string_view name) { return models().find(name); }

const ResidualModel& add_residual_model(
    std::string name, std::string description, TrainFunction train, LoadFunction load) {
  return models().add(
      std::move(name), std::move(description), {std::move(train), std::move(load)});
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
                               ? model.made->train(seen, residual_mm, settings, stop)
                               : model.train(seen, residual_mm, settings, stop);
  const Eigen::RowVectorXd low = residual_mm.colwise().minCoeff();
  const Eigen::RowVectorXd high = residual_mm.colwise().maxCoeff();
  const Eigen::RowVectorXd margin = kMargin * (high - low);
  result.saved["inputs"] =
      Eigen::Map<const Eigen::RowVectorXi>(inputs.data(), std::ssize(inputs)).cast<double>();
  result.saved["box_low"] = seen.colwise().minCoeff();
  result.saved["box_high"] = seen.colwise().maxCoeff();
  // Zero stays allowed: "no correction" is never out of bounds.
  result.saved["output_low"] = (low - margin).cwiseMin(0.0);
  result.saved["output_high"] = (high + margin).cwiseMax(0.0);
  const SavedResidual saved = result.saved;
  return bounded(std::move(result), saved);
}

TrainedResidual load_residual(const ResidualModel& model, const SavedResidual& saved) {
  if (model.made != nullptr && !model.made->load) {
    throw std::invalid_argument(
        "what \"" + std::string(model.name) + "\" learned cannot be stored");
  }
  TrainedResidual result = model.made != nullptr ? model.made->load(saved) : model.load(saved);
  result.saved = saved;
  return bounded(std::move(result), saved);
}

const MatrixXd& saved_matrix(
    const SavedResidual& saved, const std::string& name, Eigen::Index rows,
    Eigen::Index columns) {
  const auto found = saved.find(name);
  if (found == saved.end()) throw std::invalid_argument("there is no \"" + name + "\"");
  const MatrixXd& matrix = found->second;
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

MatrixXd number_to_save(double value) { return MatrixXd::Constant(1, 1, value); }

void save_outputs(Eigen::Index outputs, SavedResidual& saved) {
  saved["outputs"] = number_to_save(static_cast<double>(outputs));
}

Eigen::Index saved_outputs(const SavedResidual& saved) {
  const double outputs = saved_number(saved, "outputs");
  if (!(outputs >= 1.0) || outputs > kMostOutputs || outputs != std::floor(outputs)) {
    throw std::invalid_argument("\"outputs\" is no number of outputs");
  }
  return static_cast<Eigen::Index>(outputs);
}

std::string output_prefix(Eigen::Index output) {
  return "output" + std::to_string(output + 1) + ".";
}

HoldoutSplit holdout_split(const MatrixXd& joints, double fraction, std::uint64_t seed) {
  const std::vector<std::vector<int>> poses = rows_by_group(pose_groups(joints));
  const auto n = static_cast<int>(poses.size());
  std::vector<int> order(static_cast<std::size_t>(n));
  std::iota(order.begin(), order.end(), 0);
  RandomSequence random(seed, kHoldoutStream);
  for (int i = n - 1; i > 0; --i) {
    std::swap(
        order[static_cast<std::size_t>(i)],
        order[static_cast<std::size_t>(random.below(i + 1))]);
  }
  const auto held = static_cast<std::ptrdiff_t>(std::lround(fraction * n));
  HoldoutSplit split;
  for (std::size_t k = 0; k < order.size(); ++k) {
    const auto& rows = poses[static_cast<std::size_t>(order[k])];
    auto& side = static_cast<std::ptrdiff_t>(k) < held ? split.check : split.train;
    side.insert(side.end(), rows.begin(), rows.end());
  }
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

Standardiser::Standardiser(const SavedResidual& saved)
    : mean(saved_matrix(saved, "input_mean", 1, -1)),
      scale(saved_matrix(saved, "input_scale", 1, mean.size())) {}

void Standardiser::save(SavedResidual& saved) const {
  saved["input_mean"] = mean;
  saved["input_scale"] = scale;
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
