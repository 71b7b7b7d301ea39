// What an effect does to joint values and tool, as text that C and Python both read: an
// exported model carries it to where this program is not. Each row stands in the effect's own
// file in effects/; an effect without a row is not exported and is told as left out.
//
// Statements, one a line, of these names:
//
//   q[i]                  joint values as the effects before left them [rad, mm]
//   v[k]                  parameters of a robot in the plane
//   approach[i] temperature_degC time_h travel[axis]     as of a Circumstance
//   weight[i][0] weight[i][1]                            Circumstance::weight_m
//   p[axis] was[axis]     the tool, and where it was before this effect [mm]
//   turn[axis]            of all frames about W's origin, as the instrument sees it [rad]
//   end[axis] stands[axis]                               Scene::end_mm, Scene::stands_mm
//   sin(a) cos(a) smooth_value(curve, a)                 smooth_function.h
//
// In braces: {joint} and {other} of the place, {0} {1} ... the effect's numbers, {curve} all of
// them. A line with {axis} stands for one line an axis, one with {grows} for one a parameter
// that grows.
//
// Example:
//   const EffectInCode& gain = *find_effect_in_code("joint_gain");
//   gain.at({.joint = 1}).joints;  // -> "q[{joint}] += {0} * q[{joint}]"
#pragma once

#include <string_view>

#include "simulation/effect.h"

namespace sixdial::simulation {

struct EffectStatements {
  std::string_view joints{};  // before the robot's kinematics
  std::string_view tool{};    // after them; both empty: at this place it moves neither
};

struct EffectInCode {
  std::string_view cause;
  EffectStatements (*at)(const Place&) = nullptr;
};

/// Null: the effect has no row.
[[nodiscard]] const EffectInCode* find_effect_in_code(std::string_view cause);

/// Whether the effect may move joint values or the tool, not only what an instrument shows.
[[nodiscard]] inline bool moves_the_robot(const Effect& effect) {
  return effect.before_kinematics || effect.after_kinematics;
}

}  // namespace sixdial::simulation
