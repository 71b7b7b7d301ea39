#include "diagnosis/kernel_basis.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "simulation/smooth_function.h"

namespace sixdial::diagnosis {
namespace {

constexpr double kPi = std::numbers::pi;

}  // namespace

const std::vector<Box>& boxes_along() {
  static const std::vector<Box> kBoxes{
      {1.3, {0.08, 0.15, 0.3, -0.5, -2.0}}, {2.0, {0.6}}, {3.5, {1.2, 2.5}}};
  return kBoxes;
}

std::optional<Eigen::VectorXd> scaled(const Eigen::VectorXd& values) {
  const double low = values.minCoeff();
  const double high = values.maxCoeff();
  if (!(high - low > 1e-9 * (1 + std::abs(high)))) return std::nullopt;
  return Eigen::VectorXd((values.array() - 0.5 * (low + high)).matrix() / (0.5 * (high - low)));
}

Eigen::MatrixXd basis_of(const Eigen::VectorXd& u, double half_width, int count, int first) {
  Eigen::MatrixXd basis(u.size(), count);
  for (int j = 0; j < count; ++j) {
    basis.col(j) =
        u.unaryExpr([&](double at) { return simulation::box_sine(at, half_width, first + j); });
  }
  return basis;
}

std::optional<double> sine_length(const Kernel& kernel) {
  if (kernel.wave < 0) return std::nullopt;
  return 2 * kernel.half_width * kernel.range() / (kernel.wave + 1);
}

Eigen::VectorXd kernel_values(const Kernel& kernel, double at) {
  const double middle = (kernel.low + kernel.high) / 2;
  const double half = (kernel.high - kernel.low) / 2;
  const double u = std::clamp((at - middle) / half, -1.0, 1.0);
  Eigen::VectorXd result(kernel.size.size());
  for (Eigen::Index k = 0; k < result.size(); ++k) {
    const int j = kernel.functions[static_cast<std::size_t>(k)];
    result[k] = kernel.size[k] * simulation::box_sine(u, kernel.half_width, j);
  }
  return result;
}

double spectrum(int j, double half_width, double length) {
  const double omega = kPi * (j + 1) / (2 * half_width);
  if (length < 0) return -length / (1 + omega * omega * length * length);
  return length * std::exp(-0.5 * omega * omega * length * length);
}

double spectrum(int j, const Box& box, double length) {
  if (box.wave < 0) return spectrum(j, box.half_width, length);
  const double off = (j - box.wave) / length;
  return std::exp(-0.5 * off * off);
}

std::vector<Eigen::Index> prominent(
    const Eigen::MatrixXd& columns, const Eigen::VectorXd& spread) {
  constexpr double kLeastShare = 1e-4;
  const Eigen::VectorXd size = columns.colwise().norm().transpose().cwiseProduct(spread);
  std::vector<Eigen::Index> result;
  for (Eigen::Index j = 0; j < columns.cols(); ++j) {
    if (size[j] > kLeastShare * size.maxCoeff()) result.push_back(j);
  }
  return result;
}

Eigen::MatrixXd scaled_columns(
    const Eigen::MatrixXd& columns, const Eigen::VectorXd& spread,
    const std::vector<Eigen::Index>& which) {
  Eigen::MatrixXd result(columns.rows(), std::ssize(which));
  for (std::size_t k = 0; k < which.size(); ++k) {
    result.col(static_cast<Eigen::Index>(k)) = columns.col(which[k]) * spread[which[k]];
  }
  return result;
}

}  // namespace sixdial::diagnosis
