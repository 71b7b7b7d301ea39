#include "geometry/base_frame.h"

#include <Eigen/QR>
#include <algorithm>
#include <cmath>

#include "geometry/units.h"

namespace sixdial::geometry {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

constexpr double kStep_rad = 3.0 * kRadPerDeg;
constexpr int kFewestSteps = 8;
constexpr int kPolish = 4;
// How well the tool must follow a motion of the base, of its speed; and in the end.
constexpr double kFollows = 1e-6;
constexpr double kClosure_mm = 1e-7;
// A change this much smaller than a plausible one is rounding: the parameter is not of the
// base.
constexpr double kNoChange = 1e-7;
constexpr double kOpen = 1e-10;  // singular value, relative: a direction that moves nothing

/// From where the base stands to X, step by step: the points turn around their own middle,
/// which goes straight.
struct Path {
  MatrixXd velocity;  // of a point at the middle's offset: d = velocity * offset + along
  VectorXd along;
  double turn_rad = 0.0;
};

/// Matrix logarithm of a turn.
MatrixXd log_of(const MatrixXd& R) {
  const double turn = Similarity{R, VectorXd::Zero(R.rows()), 1.0}.turn_rad();
  MatrixXd result = MatrixXd::Zero(R.rows(), R.cols());
  if (R.rows() == 2) {
    result << 0.0, -turn, turn, 0.0;
    return result;
  }
  const MatrixXd skew = (R - R.transpose()) / 2.0;
  if (turn < 1e-8) return skew;
  const double sine = std::sin(turn);
  if (std::abs(sine) > 1e-4) return turn / sine * skew;
  // Half a turn: the axis is the direction that R keeps.
  const MatrixXd twice = (R + MatrixXd::Identity(3, 3)) / 2.0;
  Index column = 0;
  twice.diagonal().maxCoeff(&column);
  Eigen::Vector3d axis = twice.col(column).normalized();
  const Eigen::Vector3d sense(skew(2, 1), skew(0, 2), skew(1, 0));
  if (sense.dot(axis) < 0.0) axis = -axis;
  result << 0, -axis.z(), axis.y(), axis.z(), 0, -axis.x(), -axis.y(), axis.x(), 0;
  return turn * result;
}

class Mover {
 public:
  Mover(const Tool& tool, std::span<const JointPose> poses) : tool_(tool), poses_(poses) {
    const auto& parameters = tool.robot().parameters;
    scale_.resize(std::ssize(parameters));
    for (std::size_t i = 0; i < parameters.size(); ++i) {
      scale_[static_cast<Index>(i)] = parameters[i].change;
    }
  }

  /// All positions one below the other, and their derivative by scaled parameters. False where
  /// a pose cannot be reached.
  bool look(const VectorXd& v, VectorXd& p, MatrixXd& J) const {
    const Index axes = tool_.axes();
    p.resize(axes * std::ssize(poses_));
    J.resize(p.size(), scale_.size());
    for (std::size_t i = 0; i < poses_.size(); ++i) {
      const auto at = tool_.derivative(v, poses_[i].q, poses_[i].assembly);
      if (!at) return false;
      p.segment(axes * static_cast<Index>(i), axes) = at->p_WE;
      J.middleRows(axes * static_cast<Index>(i), axes) = at->J_v * scale_.asDiagonal();
    }
    return true;
  }

  /// The change of the parameters that moves all points as `wanted`; empty: there is none.
  [[nodiscard]] std::optional<VectorXd> change(
      const MatrixXd& J, const VectorXd& wanted, double follows) const {
    Eigen::CompleteOrthogonalDecomposition<MatrixXd> solver;
    solver.setThreshold(kOpen);
    solver.compute(J);
    const VectorXd z = solver.solve(wanted);
    if (!((J * z - wanted).norm() <= follows)) return std::nullopt;
    return VectorXd(scale_.cwiseProduct(z));
  }

  /// dv/ds along the path, s of 0 to 1.
  [[nodiscard]] std::optional<VectorXd> slope(const Path& path, const VectorXd& v) const {
    VectorXd p;
    MatrixXd J;
    if (!look(v, p, J)) return std::nullopt;
    const Index axes = tool_.axes();
    const auto points = p.reshaped(axes, std::ssize(poses_));
    const VectorXd middle = points.rowwise().mean();
    MatrixXd wanted = path.velocity * (points.colwise() - middle);
    wanted.colwise() += path.along;
    const double speed = wanted.norm();
    return change(J, wanted.reshaped(), kFollows * speed);
  }

  [[nodiscard]] const VectorXd& scale() const { return scale_; }

 private:
  const Tool& tool_;
  std::span<const JointPose> poses_;
  VectorXd scale_;
};

/// Runge and Kutta's fourth-order steps along the path.
std::optional<VectorXd> followed(const Mover& mover, const Path& path, VectorXd v) {
  const int steps =
      std::max(kFewestSteps, static_cast<int>(std::ceil(std::abs(path.turn_rad) / kStep_rad)));
  const double h = 1.0 / steps;
  for (int step = 0; step < steps; ++step) {
    const auto k1 = mover.slope(path, v);
    if (!k1) return std::nullopt;
    const auto k2 = mover.slope(path, v + h / 2 * *k1);
    if (!k2) return std::nullopt;
    const auto k3 = mover.slope(path, v + h / 2 * *k2);
    if (!k3) return std::nullopt;
    const auto k4 = mover.slope(path, v + h * *k3);
    if (!k4) return std::nullopt;
    v += h / 6 * (*k1 + 2 * *k2 + 2 * *k3 + *k4);
  }
  return v;
}

}  // namespace

std::optional<VectorXd> with_base_moved(
    const Tool& tool, const VectorXd& v, const Similarity& X,
    std::span<const JointPose> poses) {
  std::vector<JointPose> reached;
  for (const JointPose& pose : poses) {
    if (tool.derivative(v, pose.q, pose.assembly)) reached.push_back(pose);
  }
  const Mover mover(tool, reached);
  VectorXd p;
  MatrixXd J;
  if (reached.empty() || X.mirrored() || !mover.look(v, p, J)) return std::nullopt;
  const Index axes = tool.axes();
  const auto points = p.reshaped(axes, std::ssize(reached));
  const VectorXd middle = points.rowwise().mean();
  const MatrixXd there = (X.R * points).colwise() + X.t;
  const Path path{log_of(X.R), X(middle) - middle, X.turn_rad()};

  auto moved = followed(mover, path, v);
  if (!moved) return std::nullopt;
  for (int round = 0; round < kPolish; ++round) {
    VectorXd now;
    if (!mover.look(*moved, now, J)) return std::nullopt;
    const VectorXd missing = there.reshaped() - now;
    const auto step = mover.change(J, missing, std::max(missing.norm(), kClosure_mm));
    if (!step) return std::nullopt;
    *moved += *step;
  }
  for (Index i = 0; i < v.size(); ++i) {
    if (std::abs((*moved)[i] - v[i]) < kNoChange * mover.scale()[i]) (*moved)[i] = v[i];
  }
  VectorXd now;
  if (!mover.look(*moved, now, J)) return std::nullopt;
  const double left = (there.reshaped() - now).cwiseAbs().maxCoeff();
  if (!(left < kClosure_mm * std::max(1.0, there.cwiseAbs().maxCoeff()))) return std::nullopt;
  return moved;
}

}  // namespace sixdial::geometry
