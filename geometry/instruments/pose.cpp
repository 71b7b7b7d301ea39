#include "geometry/instruments/pose.h"

#include <cmath>

#include "geometry/instruments/places.h"
#include "geometry/rig.h"
#include "geometry/rotation.h"

namespace sixdial::geometry {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;

tl::expected<std::shared_ptr<const InstrumentModel>, std::string> of_rig(const Rig& rig) {
  if (rig.instrument.dimensions != 3) {
    return tl::unexpected(std::string("a pose is measured in 3 dimensions"));
  }
  auto result = std::make_shared<InstrumentModel>();
  result->kind = &pose_of_tool;
  for (const char* const axis : {"x", "y", "z"}) {
    result->channels.push_back({axis, "mm", rig.instrument.sd_mm});
  }
  for (const char* const axis : {"rx", "ry", "rz"}) {
    result->channels.push_back({axis, "rad", rig.instrument.sd_rad});
  }
  return result;
}

/// d(rotation vector)/d(turn in W) at w: the inverse of the left Jacobian of SO(3).
Matrix3d by_turn(const Vector3d& w) {
  const double angle = w.norm();
  const Matrix3d S = skew<double>(w);
  // 1/angle^2 - (1 + cos) / (2 angle sin), by its series near zero.
  const double c = angle < 1e-3 ? 1.0 / 12 + angle * angle / 720
                                : (1.0 - angle / 2 / std::tan(angle / 2)) / (angle * angle);
  return Matrix3d::Identity() - 0.5 * S + c * S * S;
}

void observe(
    const InstrumentModel& instrument, std::span<const double> /*x*/,
    std::span<const double> /*unknowns*/, std::span<const Pose<double>> X, bool say_shown,
    Observation& out) {
  clear(instrument, X.size(), say_shown, out);
  const Vector3d w = rotation_vector(X[0].R);
  out.reading << X[0].p, w;
  out.by_frames.topLeftCorner<3, 3>().setIdentity();
  out.by_frames.block<3, 3>(3, 3) = by_turn(w);
}

/// measured - reading = e, where R_measured = turned_by(e) R. A small turn of the tool by w
/// leaves turned_by(e) turned_by(-w), so that d(reading)/d(w) is the inverse of the right
/// Jacobian of SO(3) at e: that of the left one, transposed.
void nearest(std::span<const std::optional<double>> measured, Observation& out) {
  if (!measured[3] || !measured[4] || !measured[5]) return;
  const Vector3d seen(*measured[3], *measured[4], *measured[5]);
  if (!seen.allFinite()) return;
  const Matrix3d R = turned_by<double>(Vector3d(out.reading.tail<3>()));
  const Vector3d e = rotation_vector(turned_by<double>(seen) * R.transpose());
  out.reading.tail<3>() = seen - e;
  out.by_frames.block<3, 3>(3, 3) = by_turn(e).transpose();
}

}  // namespace

extern constinit const InstrumentKind pose_of_tool{
    .name = "pose",
    .in_words = "position and orientation of the tool",
    .of_rig = of_rig,
    .observe = observe,
    .sees_tool_only = true,
    .nearest = nearest,
};

}  // namespace sixdial::geometry
