// What a plan is worth, in a sentence.
#pragma once

#include <string>

#include "studies/next_plan.h"
#include "studies/rig_check.h"
#include "studies/separation_plan.h"
#include "studies/socket_plan.h"

namespace sixdial::report {

/// "12 samples of G1: ... with these 10 (I-optimal): ...".
[[nodiscard]] std::string next_plan_text(const studies::NextPlanFigures& figures);
/// What comes apart, and how surely.
[[nodiscard]] std::string separation_text(const studies::SeparationFigures& figures);
/// How many points buy how much, what no pose tells, and what to do about that.
[[nodiscard]] std::string rig_check_text(const studies::RigCheckFigures& figures);
/// What poses in sockets tell of the robot and of the tool's position, how many buy how much,
/// what stays open and what would settle it.
[[nodiscard]] std::string socket_plan_text(const studies::SocketPlanFigures& figures);

}  // namespace sixdial::report
