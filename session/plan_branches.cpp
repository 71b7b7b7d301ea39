// How the robot stands from point to point of a plan, and what an operator has to know of that.
#include <fmt/format.h>

#include "geometry/tool.h"
#include "session/plan.h"
#include "session/plan_in_space.h"

namespace sixdial::session {

Branch branch_of(const geometry::Rig& rig, const PlanPoint& point) {
  const geometry::Robot& robot = rig.robot;
  const geometry::Tool tool(rig);
  const auto assembly = tool.assembly_at(robot.nominal, point.q, point.target_mm);
  if (!assembly) return {robot.working_mode, robot.assembly};
  const auto mode = tool.mode_of(robot.nominal, point.q, *assembly);
  return {mode ? *mode : robot.working_mode, *assembly};
}

std::vector<Stretch> stretches_of(const geometry::Rig& rig, const Plan& plan) {
  std::vector<Stretch> stretches;
  for (std::size_t i = 0; i < plan.points.size(); ++i) {
    const Branch branch = branch_of(rig, plan.points[i]);
    if (stretches.empty() || stretches.back().branch != branch) {
      stretches.push_back({branch, i, 0});
    }
    ++stretches.back().points;
  }
  return stretches;
}

std::vector<std::string> operator_notes(const geometry::Rig& rig, const Plan& plan) {
  std::vector<std::string> notes;
  if (lacks_ranges(rig)) {
    notes.emplace_back(
        "rig.toml does not say how far every joint may go (low_deg and high_deg of [[joint]]): "
        "look whether the robot can take all of these poses");
  }
  const std::vector<Stretch> stretches = stretches_of(rig, plan);
  if (stretches.size() < 2) return notes;
  const Branch* before = nullptr;
  for (const Stretch& stretch : stretches) {
    const PlanPoint& first = plan.points[stretch.first];
    const Branch& now = stretch.branch;
    if (before == nullptr) {
      notes.push_back(fmt::format(
          "{} rows in working mode {} (assembly {})", stretch.points,
          rig.robot.model->mode_name(now.mode), static_cast<int>(now.assembly)));
    } else {
      notes.push_back(fmt::format(
          "then {} in {} (assembly {}): before {} point {} an operator must clear the dials "
          "and bring the legs over from {}, across singular poses; collecting pauses there",
          stretch.points, rig.robot.model->mode_name(now.mode), static_cast<int>(now.assembly),
          first.set, first.point, rig.robot.model->mode_name(before->mode)));
    }
    before = &now;
  }
  return notes;
}

}  // namespace sixdial::session
