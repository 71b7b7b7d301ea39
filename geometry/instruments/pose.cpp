#include "geometry/instruments/pose.h"

#include <cmath>
#include <numbers>

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

void nearest(std::span<const std::optional<double>> measured, Observation& out) {
  if (!measured[3] || !measured[4] || !measured[5]) return;
  const Vector3d seen(*measured[3], *measured[4], *measured[5]);
  const Vector3d w = out.reading.tail<3>();
  const double angle = w.norm();
  if (angle < 1e-9) return;
  const double whole =
      std::round((seen.dot(w) / angle - angle) / (2 * std::numbers::pi)) * 2 * std::numbers::pi;
  if (whole == 0.0) return;
  const Vector3d same = w * (1.0 + whole / angle);
  out.reading.tail<3>() = same;
  out.by_frames.block<3, 3>(3, 3) = by_turn(same);
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
