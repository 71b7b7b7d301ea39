// Where the nominal robot has its tool at a session's joint values, beside where it was
// measured: what units, frames and exchanged columns are judged by.
#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <functional>
#include <optional>
#include <vector>

#include "geometry/base_frame.h"
#include "session/session.h"

namespace sixdial::studies::plausibility {

/// Enough to judge a column by; more rows would only take longer.
inline constexpr std::size_t kMostLooked = 400;

/// Rows that count, at most so many of them, evenly spread.
[[nodiscard]] std::vector<std::size_t> looked_rows(
    const session::Session& session, std::size_t most = kMostLooked);

struct MeasuredTool {
  std::vector<std::size_t> row;  // of the session
  Eigen::MatrixXd p_mm;          // axes x rows
  bool by_dials = false;         // computed from readings; else an instrument gave it
};
/// Positions as an instrument gave them; where there is none, as the dials put the tool.
[[nodiscard]] MeasuredTool measured_tool(const session::Session& session);

/// Joint values in another column, unit or sense.
using JointMap = std::function<Eigen::VectorXd(const Eigen::VectorXd& q)>;

struct ToolSeen {
  std::vector<std::size_t> row;
  std::vector<geometry::JointPose> pose;
  Eigen::MatrixXd nominal_mm, measured_mm;  // axes x rows
};
/// The rows of `measured` that the nominal robot can reach. A sample's assembly is that which
/// its target names, if it fits one and `joints` is empty, else `assembly`.
[[nodiscard]] ToolSeen tool_seen(
    const session::Session& session, const MeasuredTool& measured, geometry::Assembly assembly,
    const JointMap& joints = {});

/// The same for each assembly of the robot.
[[nodiscard]] std::vector<ToolSeen> tools_seen(
    const session::Session& session, const MeasuredTool& measured, const JointMap& joints = {});

/// The assembly that a sample's target names: it puts the tool near it, and nearer than others.
[[nodiscard]] std::optional<geometry::Assembly> assembly_by_target(
    const geometry::Rig& rig, const session::Sample& sample);

/// Where the nominal robot has its tool, nearest to the target of all its assemblies; empty: no
/// target, or none can be reached.
[[nodiscard]] std::optional<geometry::Position> nominal_at_target(
    const geometry::Rig& rig, const session::Sample& sample);

}  // namespace sixdial::studies::plausibility
