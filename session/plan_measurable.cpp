// Whether a target can be measured: by the nominal robot and the dials.
#include <fmt/format.h>

#include <cmath>
#include <numbers>
#include <utility>

#include "geometry/tool.h"
#include "geometry/units.h"
#include "session/plan.h"
#include "session/plan_draw.h"
#include "session/trials.h"

namespace sixdial::session {
namespace {

using Eigen::Vector2d;

// The clamp angle is known to a degree.
constexpr double kClampError_rad = geometry::kRadPerDeg;

std::optional<PlanRefusal> contacts_refused(
    const geometry::Rig& rig, const Vector2d& target, const geometry::CuboidPose& pose) {
  const auto dials = rig.dial_geometries();
  std::vector<geometry::DialReading> readings;
  std::string missing;
  for (std::size_t i = 0; i < dials.size(); ++i) {
    const auto contact = geometry::touch(dials[i], pose, rig.cuboid.side_mm);
    if (!contact && contact.error() == geometry::ContactTrouble::kBeyondTravel) {
      return refusal_of(
          target,
          fmt::format(
              "the cuboid would push dial {} beyond its travel of {} mm", rig.dials[i].id,
              dials[i].travel_mm),
          "keep the targets away from that dial or move it back");
    }
    if (contact && in_contact(rig.dials[i], contact->displacement_mm)) {
      readings.push_back(
          {static_cast<int>(i), contact->displacement_mm, reading_sigma_mm(rig.dials[i])});
      continue;
    }
    if (!missing.empty()) missing += ", ";
    missing += fmt::format(
        "{}: {}", rig.dials[i].id,
        contact ? "at the end of its travel" : describe(contact.error()));
  }
  const auto three =
      geometry::best_active_three(dials, readings, rig.cuboid.side_mm, pose.gamma_rad);
  if (three) return std::nullopt;
  return refusal_of(
      target,
      fmt::format(
          "with the robot at ({:.3f}, {:.3f}) mm and the cuboid turned by {:.2f} deg there are "
          "{} ({})",
          pose.p_WE.x(), pose.p_WE.y(), pose.gamma_rad * geometry::kDegPerRad,
          describe(three.error()), missing),
      "choose a smaller rectangle, a smaller robot error, or move the dials");
}

/// The tool on its target and off by the robot's error in eight directions, the clamp either
/// way.
std::optional<PlanRefusal> contacts_refused_around(
    const geometry::Rig& rig, const Vector2d& target, double gamma_rad, double robot_error_mm) {
  for (int direction = -1; direction < 8; ++direction) {
    const double angle = direction * std::numbers::pi / 4;
    const Vector2d off =
        direction < 0 ? Vector2d(0, 0)
                      : Vector2d(robot_error_mm * Vector2d(std::cos(angle), std::sin(angle)));
    for (const double clamp : {0.0, -kClampError_rad, kClampError_rad}) {
      const geometry::CuboidPose cuboid{target + off, gamma_rad + clamp};
      if (auto refusal = contacts_refused(rig, target, cuboid)) return refusal;
    }
  }
  return std::nullopt;
}

}  // namespace

std::string singular_there(
    const geometry::Rig& rig, const Eigen::VectorXd& q, geometry::Assembly assembly) {
  constexpr double kMostGain = 10.0;  // mm of the tool per mm of a length
  const auto there = geometry::Tool(rig).derivative(rig.robot.nominal, q, assembly);
  if (!there) return std::string(describe(there.error()));
  const auto& parameters = rig.robot.model->parameters;
  double most = 0.0;
  std::size_t worst = 0;
  for (std::size_t i = 0; i < parameters.size(); ++i) {
    if (parameters[i].unit != "mm") continue;
    const double gain = there->J_v.col(static_cast<Eigen::Index>(i)).norm();
    if (gain <= most) continue;
    most = gain;
    worst = i;
  }
  if (most <= kMostGain) return "";
  return fmt::format(
      "it is almost singular there: an error of 1 mm in {} moves the tool by {:.0f} mm",
      parameters[worst].name, most);
}

tl::expected<Eigen::VectorXd, PlanRefusal> measurable(
    const geometry::Rig& rig, const Position& target_mm, geometry::WorkingMode mode,
    double robot_error_mm, const Eigen::VectorXd& near) {
  const auto refuse = [&](std::string reason) {
    return tl::unexpected(refusal_of(
        target_mm, std::move(reason), "choose a rectangle inside the robot's workspace"));
  };
  const geometry::Tool tool(rig);
  const Eigen::VectorXd& v = rig.robot.nominal;
  const auto exact = tool.inverse(v, target_mm, mode, near);
  if (!exact) return refuse(std::string(describe(exact.error())));
  const Eigen::VectorXd q = rounded(*exact, kJointDigits);
  const auto assembly = tool.assembly_at(v, q, target_mm);
  if (!assembly) return refuse(std::string(describe(assembly.error())));
  if (std::string why = singular_there(rig, q, *assembly); !why.empty()) {
    return refuse(std::move(why));
  }
  if (rig.dials.empty() || !rig.on_cuboid()) return q;
  const auto reference = geometry::reference_link_angle(rig);
  if (!reference) return q;
  const auto pose =
      geometry::planar_pose(*rig.robot.model, v, q, *assembly, geometry::cuboid_link(rig));
  if (!pose) return refuse(std::string(describe(pose.error())));
  const double gamma_rad = geometry::cuboid_angle(rig, *reference, pose->link_rad, 0.0);
  if (auto refusal = contacts_refused_around(rig, target_mm, gamma_rad, robot_error_mm)) {
    return tl::unexpected(std::move(*refusal));
  }
  return q;
}

}  // namespace sixdial::session
