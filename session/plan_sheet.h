// A plan on paper, for a robot that is moved by hand or by its own pendant: what to drive to,
// in degrees, and session.csv as it is before anything is measured, to be filled in.
#pragma once

#include <string>

#include "session/plan.h"

namespace sixdial::session {

/// set, point, repeat, socket and the planned joint values: angles in degrees to 0.01, lengths
/// in mm to 0.01.
[[nodiscard]] std::string pose_sheet(const Plan& plan, const geometry::Rig& rig);

/// session.csv with a row for each point and no joint value yet, angles to be in degrees.
[[nodiscard]] std::string empty_session(const Plan& plan, const geometry::Rig& rig);
/// The same with the joint values of the plan as those that were read: angles to 0.0001 deg.
[[nodiscard]] std::string filled_session(const Plan& plan, const geometry::Rig& rig);

}  // namespace sixdial::session
