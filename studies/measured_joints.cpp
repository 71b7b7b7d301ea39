#include "studies/measured_joints.h"

#include <algorithm>

#include "geometry/tool.h"

namespace sixdial::studies {

std::vector<MeasuredJoints> measured_joints_of(
    std::span<const simulation::Trial> trials, const geometry::Rig& rig) {
  const geometry::Tool tool(rig);
  std::vector<MeasuredJoints> all;
  for (const simulation::Trial& trial : trials) {
    const auto mode = tool.mode_of(rig.robot.nominal, trial.q, trial.assembly);
    if (!mode) continue;
    const auto known = std::ranges::find(all, *mode, &MeasuredJoints::mode);
    if (known == all.end()) {
      all.push_back({*mode, trial.q, trial.q});
      continue;
    }
    known->low = known->low.cwiseMin(trial.q);
    known->high = known->high.cwiseMax(trial.q);
  }
  return all;
}

std::map<int, Eigen::VectorXd> middles_of(
    const std::optional<std::vector<MeasuredJoints>>& measured) {
  std::map<int, Eigen::VectorXd> middles;
  if (!measured) return middles;
  for (const MeasuredJoints& each : *measured) {
    middles[each.mode.number] = (each.low + each.high) / 2.0;
  }
  return middles;
}

}  // namespace sixdial::studies
