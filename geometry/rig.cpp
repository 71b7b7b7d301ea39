#include "geometry/rig.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "geometry/tool.h"
#include "geometry/units.h"

namespace sixdial::geometry {

std::optional<std::size_t> Rig::find_dial(std::string_view id) const {
  for (std::size_t i = 0; i < dials.size(); ++i) {
    if (dials[i].id == id) return i;
  }
  return std::nullopt;
}

bool Rig::states_deviations() const {
  if (cuboid.deviations != CuboidDeviations{}) return true;
  return std::ranges::any_of(
      dials, [](const Dial& dial) { return dial.deviations != DialDeviations{}; });
}

std::vector<DialGeometry> Rig::dial_geometries() const {
  std::vector<DialGeometry> result;
  result.reserve(dials.size());
  for (const Dial& dial : dials) result.push_back(dial.geometry);
  return result;
}

Rig default_rig() {
  Rig rig;
  rig.name = "five-bar rig";
  rig.robot.nominal << 60, 60, 60, 60, 90, 0, 0, 0, 0, 0;
  const auto add = [&](const char* id, double x, double y, double ax, double ay) {
    Dial dial;
    dial.id = id;
    dial.geometry.position_mm = {x, y};
    dial.geometry.axis = {ax, ay};
    rig.dials.push_back(dial);
  };
  add("A", 52, 48, -1, 0);
  add("B", 4, 48, 1, 0);
  add("C", 16, 24, 0, 1);
  add("D", 40, 24, 0, 1);
  add("E", 16, 72, 0, -1);
  add("F", 40, 72, 0, -1);
  return rig;
}

ParameterVector table_2_robot() {
  ParameterVector v;
  v << 59.742, 60.483, 60.341, 59.704, 89.511, 0.851, -0.556, 0.148 * kRadPerDeg,
      -0.873 * kRadPerDeg, -1.032 * kRadPerDeg;
  return v;
}

std::optional<int> cuboid_link(const Rig& rig) {
  if (rig.cuboid.mount == Mount::kFree) return std::nullopt;
  return rig.robot.model->find_frame(
      rig.cuboid.mount == Mount::kDistal1 ? "distal1" : "distal2");
}

tl::expected<double, KinematicTrouble> reference_link_angle(const Rig& rig) {
  const std::optional<int> link = cuboid_link(rig);
  if (!link) return 0.0;
  const Robot& robot = rig.robot;
  const Tool tool(robot.model, 2);
  const auto q = tool.inverse(robot.nominal, rig.cuboid.reference_pose_mm, robot.working_mode);
  if (!q) return tl::unexpected(q.error());
  const auto assembly = tool.assembly_at(robot.nominal, *q, rig.cuboid.reference_pose_mm);
  if (!assembly) return tl::unexpected(assembly.error());
  return planar_pose(*robot.model, robot.nominal, *q, *assembly, link)
      .map([](const PlanarPose& pose) { return pose.link_rad; });
}

double cuboid_angle(
    const Rig& rig, double reference_angle_rad, double link_rad, double clamp_rad) {
  if (rig.cuboid.mount == Mount::kFree) return clamp_rad;
  return std::remainder(link_rad - reference_angle_rad, 2 * std::numbers::pi) + clamp_rad;
}

double cuboid_angle(
    const Rig& rig, double reference_angle_rad, const ForwardPose& pose, double clamp_rad) {
  if (rig.cuboid.mount == Mount::kFree) return clamp_rad;
  const double link_rad = pose.distal_angle(rig.cuboid.mount == Mount::kDistal1 ? 0 : 1);
  return cuboid_angle(rig, reference_angle_rad, link_rad, clamp_rad);
}

}  // namespace sixdial::geometry
