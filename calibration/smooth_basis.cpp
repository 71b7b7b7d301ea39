#include "calibration/smooth_basis.h"

#include <Eigen/Eigenvalues>
#include <algorithm>

namespace sixdial::calibration {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

constexpr Index kMostPins = 64;     // places that a random function is pinned at
constexpr Index kMostShapes = 160;  // of all channels together
/// Variance of a shape, relative to the largest. The first shapes of a slow function are what
/// the robot's parameters take over; what gives it away are the next ones, a thousandth as
/// large.
constexpr double kLeastShape = 1e-7;

/// exp(-d^2 / (2 l^2)) between columns.
MatrixXd kernel(const MatrixXd& a, const MatrixXd& b, double length) {
  MatrixXd k(a.cols(), b.cols());
  for (Index j = 0; j < b.cols(); ++j) {
    k.col(j) = ((a.colwise() - b.col(j)).colwise().squaredNorm() / (-2.0 * length * length))
                   .array()
                   .exp()
                   .transpose();
  }
  return k;
}

/// Columns far from each other: each next one is farthest from all before.
MatrixXd spread(const MatrixXd& at, Index most) {
  if (at.cols() <= most) return at;
  MatrixXd chosen(at.rows(), most);
  chosen.col(0) = at.col(0);
  VectorXd nearest = (at.colwise() - at.col(0)).colwise().squaredNorm().transpose();
  for (Index k = 1; k < most; ++k) {
    Index farthest = 0;
    nearest.maxCoeff(&farthest);
    chosen.col(k) = at.col(farthest);
    nearest =
        nearest.cwiseMin((at.colwise() - at.col(farthest)).colwise().squaredNorm().transpose());
  }
  return chosen;
}

MatrixXd raw_places(const ObservationSpace& space, SmoothOver over) {
  if (over == SmoothOver::kJoints) return space.joints;
  MatrixXd at(1, space.samples());
  for (int i = 0; i < space.samples(); ++i)
    at(0, i) = space.sample[static_cast<std::size_t>(i)];
  return at;
}

}  // namespace

std::string_view to_string(SmoothOver over) {
  return over == SmoothOver::kJoints ? "joints" : "order";
}

// Nystroem: the function is known at the pins, and the largest shapes there are kept.
SmoothBasis::SmoothBasis(const ObservationSpace& space, SmoothOver over, double length)
    : over_(over), length_(length) {
  const MatrixXd raw = raw_places(space, over);
  low_ = raw.rowwise().minCoeff();
  range_ = raw.rowwise().maxCoeff() - low_;
  range_ = (range_.array() > 0.0).select(range_, 1.0);
  pins_ = spread(places(space), kMostPins);
  const Eigen::SelfAdjointEigenSolver<MatrixXd> modes(kernel(pins_, pins_, length));
  const VectorXd& size = modes.eigenvalues();  // rising
  const Index large = (size.array() > kLeastShape * size[size.size() - 1]).count();
  const Index count =
      std::min<Index>(large, std::max<Index>(kMostShapes / std::max(space.channels(), 1), 1));
  to_shape_ = modes.eigenvectors().rightCols(count) *
              size.tail(count).cwiseSqrt().cwiseInverse().asDiagonal();
}

MatrixXd SmoothBasis::places(const ObservationSpace& space) const {
  const MatrixXd raw = raw_places(space, over_);
  return ((raw.colwise() - low_).array().colwise() / range_.array()).matrix();
}

MatrixXd SmoothBasis::operator()(const ObservationSpace& space) const {
  return kernel(places(space), pins_, length_) * to_shape_;
}

}  // namespace sixdial::calibration
