#include "diagnosis/kernel_basis.h"

#include <cmath>
#include <numbers>

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

Eigen::MatrixXd basis_of(const Eigen::VectorXd& u, double half_width, int count) {
  Eigen::MatrixXd basis(u.size(), count);
  for (int j = 0; j < count; ++j) {
    basis.col(j) = ((u.array() + half_width) * (kPi * (j + 1) / (2 * half_width))).sin() /
                   std::sqrt(half_width);
  }
  return basis;
}

double spectrum(int j, double half_width, double length) {
  const double omega = kPi * (j + 1) / (2 * half_width);
  if (length < 0) return -length / (1 + omega * omega * length * length);
  return length * std::exp(-0.5 * omega * omega * length * length);
}

Eigen::MatrixXd prominent(const Eigen::MatrixXd& columns, const Eigen::VectorXd& spread) {
  constexpr double kLeastShare = 1e-4;
  const Eigen::VectorXd size = columns.colwise().norm().transpose().cwiseProduct(spread);
  Eigen::MatrixXd result(columns.rows(), columns.cols());
  Eigen::Index kept = 0;
  for (Eigen::Index j = 0; j < columns.cols(); ++j) {
    if (size[j] > kLeastShare * size.maxCoeff()) {
      result.col(kept++) = columns.col(j) * spread[j];
    }
  }
  return result.leftCols(kept);
}

}  // namespace sixdial::diagnosis
