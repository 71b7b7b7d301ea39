// The rivals' network ([23], [26]): 2-40-2, tan-sigmoid hidden, linear out, plain batch
// gradient descent to 40000 epochs or MSE 1e-5. Inputs and outputs are scaled to -1..1 as
// MATLAB's toolbox does; the weights of the least hold-out error seen are kept.
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

using Eigen::MatrixX2d;
using Eigen::VectorXd;

constexpr std::uint32_t kStream = 48;
constexpr double kRate = 0.01;  // MATLAB's traingd
constexpr int kCheckEvery = 20;

struct Range {
  Eigen::RowVector2d low, half;
  explicit Range(const MatrixX2d& columns) {
    low = columns.colwise().minCoeff();
    half = (columns.colwise().maxCoeff() - low) / 2;
    for (double& each : half) {
      if (!(each > 0.0)) each = 1.0;
    }
  }
  Range(Eigen::RowVector2d least, Eigen::RowVector2d half_range)
      : low(std::move(least)), half(std::move(half_range)) {}
  [[nodiscard]] MatrixX2d scaled(const MatrixX2d& columns) const {
    return ((columns.rowwise() - low).array().rowwise() / half.array() - 1.0).matrix();
  }
};

struct Samples {
  int count, padded;
  VectorXd x1, x2, yx, yy, use;
  Samples(const MatrixX2d& x, const MatrixX2d& y)
      : count(static_cast<int>(x.rows())), padded(padded_size(count)) {
    const auto pad = [&](const auto& column) {
      VectorXd result = VectorXd::Zero(padded);
      result.head(count) = column;
      return result;
    };
    x1 = pad(x.col(0));
    x2 = pad(x.col(1));
    yx = pad(y.col(0));
    yy = pad(y.col(1));
    use = pad(VectorXd::Ones(count));
  }
  double error(int hidden, const VectorXd& weights, double* gradient, VectorXd& scratch) const {
    return bpnn_error(
        hidden, padded, x1.data(), x2.data(), yx.data(), yy.data(), use.data(), weights.data(),
        gradient, scratch.data());
  }
};

VectorXd first_weights(int hidden, std::uint64_t seed) {
  // Nguyen-Widrow: slopes and offsets that cover -1..1 evenly.
  RandomSequence random(seed, kStream);
  VectorXd weights(kUnitWeights * hidden + 2);
  const double beta = 0.7 * std::sqrt(static_cast<double>(hidden));
  for (int h = 0; h < hidden; ++h) {
    const Eigen::Vector2d w(random.uniform(-1, 1), random.uniform(-1, 1));
    const double place = hidden > 1 ? 2.0 * h / (hidden - 1) - 1.0 : 0.0;
    auto unit = weights.segment<kUnitWeights>(static_cast<Eigen::Index>(kUnitWeights) * h);
    unit.head<2>() = beta * w / w.norm();
    unit[2] = beta * place * (w[0] >= 0 ? 1 : -1);
    unit[3] = random.uniform(-0.5, 0.5);
    unit[4] = random.uniform(-0.5, 0.5);
  }
  weights.tail<2>().setZero();
  return weights;
}

TrainedResidual load(const SavedResidual& saved) {
  const auto range = [&](const char* low, const char* half) {
    return Range(saved_matrix(saved, low, 1, 2), saved_matrix(saved, half, 1, 2));
  };
  const Range in = range("input_low", "input_half_range");
  const Range out = range("output_scale_low", "output_half_range");
  const VectorXd weights = saved_matrix(saved, "weights", -1, 1);
  const auto hidden = static_cast<int>((weights.size() - 2) / kUnitWeights);
  if (weights.size() != kUnitWeights * hidden + 2) {
    throw std::invalid_argument("\"weights\" makes no network");
  }
  TrainedResidual result;
  result.effective_parameters.setConstant(static_cast<double>(weights.size()) / 2);
  result.correction = [in, out, weights, hidden](const Eigen::Vector2d& q) {
    const MatrixX2d at = in.scaled(q.transpose());
    Eigen::Vector2d sum = weights.tail<2>();
    for (int h = 0; h < hidden; ++h) {
      const auto unit =
          weights.segment<kUnitWeights>(static_cast<Eigen::Index>(kUnitWeights) * h);
      sum += std::tanh(unit[0] * at(0, 0) + unit[1] * at(0, 1) + unit[2]) * unit.tail<2>();
    }
    return Eigen::Vector2d(
        (sum.array() + 1.0) * out.half.transpose().array() + out.low.transpose().array());
  };
  return result;
}

TrainedResidual train(
    const MatrixX2d& q_rad, const MatrixX2d& residual_mm, const ResidualSettings& settings,
    const std::stop_token& stop) {
  const int hidden = settings.bpnn_hidden;
  const Range in(q_rad);
  const Range out(residual_mm);
  const MatrixX2d x = in.scaled(q_rad);
  const MatrixX2d y = out.scaled(residual_mm);
  const HoldoutSplit split =
      holdout_split(static_cast<int>(q_rad.rows()), settings.holdout_fraction, settings.seed);
  const Samples training(x(split.train, Eigen::all), y(split.train, Eigen::all));
  const Samples checking(x(split.check, Eigen::all), y(split.check, Eigen::all));
  VectorXd weights = first_weights(hidden, settings.seed);
  VectorXd gradient(weights.size());
  VectorXd scratch((2 + hidden) * std::max(training.padded, checking.padded));
  // The mean over samples and both outputs, as the toolbox's mse.
  const double per_value = 1.0 / (2.0 * training.count);
  const double mm2 = out.half.squaredNorm() / 2.0;  // of a scaled squared error, on average
  VectorXd best = weights;
  double best_check = std::numeric_limits<double>::infinity();
  double mse = 0.0;
  int epoch = 0;
  for (; epoch < settings.bpnn_epochs && !stop.stop_requested(); ++epoch) {
    mse = per_value * training.error(hidden, weights, gradient.data(), scratch);
    if (epoch % kCheckEvery == 0 && checking.count > 0) {
      const double check = checking.error(hidden, weights, nullptr, scratch);
      if (check < best_check) {
        best_check = check;
        best = weights;
      }
    }
    if (mse * mm2 <= settings.bpnn_target_mse) break;
    weights -= kRate * per_value * gradient;
  }
  if (checking.count == 0) best = weights;
  SavedResidual saved{
      {"input_low", in.low},
      {"input_half_range", in.half},
      {"output_scale_low", out.low},
      {"output_half_range", out.half},
      {"weights", best}};
  TrainedResidual result = load(saved);
  result.saved = std::move(saved);
  result.note =
      fmt::format("2-{}-2, {} epochs, training MSE {:.3g} mm^2", hidden, epoch, mse * mm2);
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
