#include "diagnosis/drawn_noise.h"

#include <cmath>
#include <cstdint>

#include "calibration/column_products.h"
#include "calibration/random.h"
#include "geometry/long_work.h"

namespace sixdial::diagnosis {
namespace {

constexpr std::uint32_t kStream = 73;

}  // namespace

DrawnNoise::DrawnNoise(const Projector& projector, Eigen::Index draws) {
  const Eigen::MatrixXd& Q = projector.Q();
  const Eigen::MatrixXd& Q_of_u = projector.Q_of_u();
  rows.resize(Q.rows(), draws);
  Eigen::MatrixXd of_u(Q_of_u.rows(), draws);
  for (Eigen::Index draw = 0; draw < draws; ++draw) {
    geometry::check_end();
    const auto normal = [&](Eigen::Index row) {
      return calibration::random_normal(
          1, static_cast<std::uint32_t>(row), static_cast<std::uint32_t>(draw), 0, kStream);
    };
    for (Eigen::Index row = 0; row < rows.rows(); ++row) rows(row, draw) = normal(row);
    for (Eigen::Index row = 0; row < of_u.rows(); ++row) {
      of_u(row, draw) = normal(rows.rows() + row);
    }
  }
  const Eigen::MatrixXd fitted =
      calibration::column_products(Q, rows) + Q_of_u.transpose() * of_u;
  rows -= Q * fitted;
  of_u -= Q_of_u * fitted;
  const double s = std::sqrt(projector.squares() / projector.freedom());
  rows *= s;
  of_u *= s;
  squares = rows.colwise().squaredNorm() + of_u.colwise().squaredNorm();
}

}  // namespace sixdial::diagnosis
