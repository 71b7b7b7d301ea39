// The rivals' network ([23], [26]), 2-40-2 for the five-bar: tan-sigmoid hidden, linear out,
// plain batch gradient descent to 40000 epochs or MSE 1e-5. Inputs and outputs are scaled to
// -1..1 as MATLAB's toolbox does; the weights of the least hold-out error seen are kept.
#include <fmt/format.h>

#include <cmath>
#include <limits>
#include <stdexcept>
#include <utility>

#include "calibration/anfis_kernels.h"
#include "calibration/bpnn_kernel.h"
#include "calibration/random.h"
#include "calibration/residual_model.h"

namespace sixdial::calibration {
namespace {

using Eigen::MatrixXd;
using Eigen::VectorXd;

constexpr std::uint32_t kStream = 48;
constexpr double kRate = 0.01;  // MATLAB's traingd
constexpr int kCheckEvery = 20;

/// Scales columns to -1..1 and back.
struct Range {
  Eigen::RowVectorXd low, half;
  Range(const SavedResidual& saved, const char* low_name, const char* half_name)
      : low(saved_matrix(saved, low_name, 1, -1)),
        half(saved_matrix(saved, half_name, 1, low.size())) {}
  explicit Range(const MatrixXd& columns) {
    low = columns.colwise().minCoeff();
    half = (columns.colwise().maxCoeff() - low) / 2;
    for (double& each : half) {
      if (!(each > 0.0)) each = 1.0;
    }
  }
  [[nodiscard]] MatrixXd scaled(const MatrixXd& columns) const {
    return ((columns.rowwise() - low).array().rowwise() / half.array() - 1.0).matrix();
  }
};

struct Samples {
  int count, padded;
  MatrixXd x, y;  // padded x inputs, padded x outputs
  VectorXd use;
  Samples(const MatrixXd& inputs, const MatrixXd& outputs)
      : count(static_cast<int>(inputs.rows())), padded(padded_size(count)) {
    const auto pad = [&](const MatrixXd& columns) {
      MatrixXd result = MatrixXd::Zero(padded, columns.cols());
      result.topRows(count) = columns;
      return result;
    };
    x = pad(inputs);
    y = pad(outputs);
    use = pad(MatrixXd::Ones(count, 1));
  }
  double error(
      const BpnnShape& shape, const VectorXd& weights, double* gradient,
      VectorXd& scratch) const {
    return bpnn_error(
        shape, padded, x.data(), y.data(), use.data(), weights.data(), gradient,
        scratch.data());
  }
};

VectorXd first_weights(const BpnnShape& shape, std::uint64_t seed) {
  // Nguyen-Widrow: slopes and offsets that cover -1..1 evenly.
  RandomSequence random(seed, kStream);
  VectorXd weights(shape.weights());
  const double beta = 0.7 * std::pow(static_cast<double>(shape.hidden), 1.0 / shape.inputs);
  for (int h = 0; h < shape.hidden; ++h) {
    VectorXd w(shape.inputs);
    for (double& each : w) each = random.uniform(-1, 1);
    const double place = shape.hidden > 1 ? 2.0 * h / (shape.hidden - 1) - 1.0 : 0.0;
    auto unit = weights.segment(
        static_cast<Eigen::Index>(shape.unit_weights()) * h, shape.unit_weights());
    unit.head(shape.inputs) = beta * w / w.norm();
    unit[shape.inputs] = beta * place * (w[0] >= 0 ? 1 : -1);
    for (double& each : unit.tail(shape.outputs)) each = random.uniform(-0.5, 0.5);
  }
  weights.tail(shape.outputs).setZero();
  return weights;
}

/// The network's outputs at scaled inputs.
VectorXd answer(const BpnnShape& shape, const VectorXd& weights, const VectorXd& at) {
  VectorXd sum = weights.tail(shape.outputs);
  for (int h = 0; h < shape.hidden; ++h) {
    const auto unit = weights.segment(
        static_cast<Eigen::Index>(shape.unit_weights()) * h, shape.unit_weights());
    const double z = unit.head(shape.inputs).dot(at) + unit[shape.inputs];
    sum += std::tanh(z) * unit.tail(shape.outputs);
  }
  return sum;
}

struct Descent {
  VectorXd best;  // weights of the least hold-out error seen
  int epochs = 0;
  double mse = 0.0;  // of the last epoch, scaled
};

/// Batch gradient descent. `mm2`: of a scaled squared error, on average.
Descent descend(
    const BpnnShape& shape, const Samples& training, const Samples& checking, double mm2,
    const ResidualSettings& settings, const std::stop_token& stop) {
  VectorXd weights = first_weights(shape, settings.seed);
  VectorXd gradient(weights.size());
  VectorXd scratch((shape.outputs + shape.hidden) * std::max(training.padded, checking.padded));
  // The mean over samples and outputs, as the toolbox's mse.
  const double per_value = 1.0 / (static_cast<double>(shape.outputs) * training.count);
  Descent result{weights, 0, 0.0};
  double best_check = std::numeric_limits<double>::infinity();
  for (; result.epochs < settings.bpnn_epochs && !stop.stop_requested(); ++result.epochs) {
    result.mse = per_value * training.error(shape, weights, gradient.data(), scratch);
    if (result.epochs % kCheckEvery == 0 && checking.count > 0) {
      const double check = checking.error(shape, weights, nullptr, scratch);
      if (check < best_check) {
        best_check = check;
        result.best = weights;
      }
    }
    if (result.mse * mm2 <= settings.bpnn_target_mse) break;
    weights -= kRate * per_value * gradient;
  }
  if (checking.count == 0) result.best = weights;
  return result;
}

TrainedResidual load(const SavedResidual& saved) {
  const Range in(saved, "input_low", "input_half_range");
  const Range out(saved, "output_scale_low", "output_half_range");
  const VectorXd weights = saved_matrix(saved, "weights", -1, 1);
  BpnnShape shape{static_cast<int>(in.low.size()), 0, static_cast<int>(out.low.size())};
  shape.hidden = static_cast<int>((weights.size() - shape.outputs) / shape.unit_weights());
  if (shape.hidden < 1 || weights.size() != shape.weights()) {
    throw std::invalid_argument("\"weights\" makes no network");
  }
  TrainedResidual result;
  result.effective_parameters =
      VectorXd::Constant(shape.outputs, static_cast<double>(shape.weights()) / shape.outputs);
  result.correction = [in, out, shape, weights](const VectorXd& q) {
    const VectorXd sum = answer(shape, weights, in.scaled(q.transpose()).transpose());
    return VectorXd(
        (sum.array() + 1.0) * out.half.transpose().array() + out.low.transpose().array());
  };
  return result;
}

TrainedResidual train(
    const MatrixXd& joints, const MatrixXd& residual_mm, const ResidualSettings& settings,
    const std::stop_token& stop) {
  const BpnnShape shape{
      static_cast<int>(joints.cols()), settings.bpnn_hidden,
      static_cast<int>(residual_mm.cols())};
  if (std::max(shape.inputs, shape.outputs) > kMostBpnnColumns) {
    throw std::invalid_argument(fmt::format(
        "bpnn: {} inputs and {} outputs; it takes {} at most", shape.inputs, shape.outputs,
        kMostBpnnColumns));
  }
  const Range in(joints);
  const Range out(residual_mm);
  const MatrixXd x = in.scaled(joints);
  const MatrixXd y = out.scaled(residual_mm);
  const HoldoutSplit split = holdout_split(joints, settings.holdout_fraction, settings.seed);
  const Samples training(x(split.train, Eigen::all), y(split.train, Eigen::all));
  const Samples checking(x(split.check, Eigen::all), y(split.check, Eigen::all));
  const double mm2 = out.half.squaredNorm() / static_cast<double>(shape.outputs);
  const Descent found = descend(shape, training, checking, mm2, settings, stop);
  SavedResidual saved{
      {"input_low", in.low},
      {"input_half_range", in.half},
      {"output_scale_low", out.low},
      {"output_half_range", out.half},
      {"weights", found.best}};
  TrainedResidual result = load(saved);
  result.saved = std::move(saved);
  result.note = fmt::format(
      "{}-{}-{}, {} epochs, training MSE {:.3g} mm^2", shape.inputs, shape.hidden,
      shape.outputs, found.epochs, found.mse * mm2);
  return result;
}

}  // namespace

extern constinit const ResidualModel bpnn{
    .name = "bpnn",
    .title = "BPNN",
    .description = "back-propagation network 2-40-2, batch gradient descent",
    .train = train,
    .load = load};

}  // namespace sixdial::calibration
