#include "report/export/craig_rows.h"

#include <Eigen/Geometry>
#include <cmath>

namespace sixdial::report {
namespace {

using Number = long double;
using Vector = Eigen::Matrix<Number, 3, 1>;
using Matrix = Eigen::Matrix<Number, 3, 3>;

constexpr Number kParallel = 1e-8L;  // sine of the angle between two axes
constexpr Number kCoincident_mm = 1e-9L;

/// An axis at q = 0: a point on it, its direction, and some direction across it.
struct Axis {
  Vector at, along, across;
};

std::vector<Axis> axes_of(const JointChain& chain) {
  std::vector<Axis> axes;
  Vector p = Vector::Zero();
  Matrix R = Matrix::Identity();
  for (const ChainJoint& joint : chain.joints) {
    p += R * joint.origin.p.cast<Number>();
    R = (R * joint.origin.R.cast<Number>()).eval();
    axes.push_back({p, R.col(2), R.col(0)});
  }
  return axes;
}

/// The common normal of two axes: where it leaves the first (as far along as `from`, if any
/// place will do), where it meets the second, and its direction.
struct Normal {
  Vector foot, meets, direction;
};

/// Of the two directions of a normal the one that the arm's own frames are turned to.
Vector nearer(const Vector& direction, const Vector& across) {
  return direction.dot(across) < 0 ? Vector(-direction) : direction;
}

Normal normal_of(const Axis& one, const Axis& next, const Vector& from) {
  const Vector cross = one.along.cross(next.along);
  const Number sine = cross.norm();
  const Vector between = next.at - one.at;
  if (sine < kParallel) {
    const Vector meets = next.at + next.along * next.along.dot(from - next.at);
    Vector direction = meets - from;
    direction -= one.along * one.along.dot(direction);
    if (direction.norm() < kCoincident_mm) direction = one.across;
    return {from, meets, nearer(direction.normalized(), one.across)};
  }
  const Number s2 = sine * sine;
  const Number t = between.cross(next.along).dot(cross) / s2;
  const Number u = between.cross(one.along).dot(cross) / s2;
  return {one.at + t * one.along, next.at + u * next.along, nearer(cross / sine, one.across)};
}

Number angle_about(const Vector& axis, const Vector& from, const Vector& to) {
  return std::atan2(from.cross(to).dot(axis), from.dot(to));
}

}  // namespace

CraigArm craig_arm(const JointChain& given) {
  const JointChain chain = along_z(given);
  const std::vector<Axis> axes = axes_of(chain);
  CraigArm arm;
  // The origin and the x of the present row's frame, before its d and theta. The rows begin in
  // the arm's base, or, where the first axis is not upright in its middle, on that axis.
  Vector at = Vector::Zero();
  Vector x = Vector::UnitX();
  const Axis& first = axes.front();
  arm.base = chain.base;
  if (first.along != Vector::UnitZ() || !first.at.head<2>().isZero(0.0L)) {
    Matrix R_first;
    R_first << first.across, first.along.cross(first.across), first.along;
    arm.base = behind(chain.base, {first.at.cast<double>(), R_first.cast<double>()});
    at = first.at;
    x = first.across;
  }
  Number a = 0, alpha = 0;
  for (std::size_t i = 0; i < axes.size(); ++i) {
    const bool last = i + 1 == axes.size();
    const Normal normal = last ? Normal{axes[i].at, axes[i].at, axes[i].across}
                               : normal_of(axes[i], axes[i + 1], at);
    CraigRow row;
    row.a_mm = static_cast<double>(a);
    row.alpha_rad = static_cast<double>(alpha);
    row.d_mm = static_cast<double>((normal.foot - at).dot(axes[i].along));
    row.theta_rad = static_cast<double>(angle_about(axes[i].along, x, normal.direction));
    arm.rows.push_back(row);
    x = normal.direction;
    if (last) break;
    a = (normal.meets - normal.foot).dot(x);
    alpha = angle_about(x, axes[i].along, axes[i + 1].along);
    at = normal.meets;
  }
  // The last row's frame is the arm's own there.
  arm.tool = chain.tool;
  return arm;
}

}  // namespace sixdial::report
