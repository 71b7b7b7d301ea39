#include "studies/plausibility/tool_seen.h"

#include "geometry/tool.h"
#include "session/sample_layout.h"
#include "session/trials.h"

namespace sixdial::studies::plausibility {
namespace {

using geometry::Assembly;
using session::Sample;

constexpr double kNearTarget_mm = 10.0;

}  // namespace

std::vector<std::size_t> looked_rows(const session::Session& session, std::size_t most) {
  std::vector<std::size_t> all;
  for (std::size_t i = 0; i < session.samples.size(); ++i) {
    const Sample& sample = session.samples[i];
    if (!sample.left_out && sample.q.allFinite()) all.push_back(i);
  }
  if (all.size() <= most) return all;
  std::vector<std::size_t> spread;
  for (std::size_t k = 0; k < most; ++k) spread.push_back(all[k * all.size() / most]);
  return spread;
}

MeasuredTool measured_tool(const session::Session& session) {
  const geometry::Tool tool(session.rig);
  const std::vector<std::size_t> rows = looked_rows(session);
  MeasuredTool result;
  std::vector<geometry::Position> at;
  const auto add = [&](std::size_t row, const auto& p_mm) {
    if (!p_mm || p_mm->size() != tool.axes() || !p_mm->allFinite()) return;
    result.row.push_back(row);
    at.emplace_back(*p_mm);
  };
  for (const std::size_t row : rows) {
    add(row, session::position_of(session.samples[row], session.rig.dials.size()));
  }
  if (at.empty()) {
    result.by_dials = true;
    for (const std::size_t row : rows) {
      Sample sample = session.samples[row];
      sample.target_mm.reset();  // which may be anything
      add(row, session::trial_of(session.rig, sample).position_mm);
    }
  }
  result.p_mm.resize(tool.axes(), std::ssize(at));
  for (std::size_t i = 0; i < at.size(); ++i) {
    result.p_mm.col(static_cast<Eigen::Index>(i)) = at[i];
  }
  return result;
}

ToolSeen tool_seen(
    const session::Session& session, const MeasuredTool& measured, Assembly assembly,
    const JointMap& joints) {
  const geometry::Rig& rig = session.rig;
  const geometry::Tool tool(rig);
  ToolSeen seen;
  std::vector<Eigen::Index> column;
  std::vector<geometry::Position> nominal;
  for (std::size_t i = 0; i < measured.row.size(); ++i) {
    const Sample& sample = session.samples[measured.row[i]];
    geometry::JointPose pose{joints ? joints(sample.q) : sample.q, assembly};
    if (!joints) pose.assembly = assembly_by_target(rig, sample).value_or(assembly);
    const auto at = tool.position(rig.robot.nominal, pose.q, pose.assembly);
    if (!at) continue;
    column.push_back(static_cast<Eigen::Index>(i));
    nominal.push_back(*at);
    seen.row.push_back(measured.row[i]);
    seen.pose.push_back(std::move(pose));
  }
  seen.measured_mm = measured.p_mm(Eigen::all, column);
  seen.nominal_mm.resize(tool.axes(), std::ssize(nominal));
  for (std::size_t i = 0; i < nominal.size(); ++i) {
    seen.nominal_mm.col(static_cast<Eigen::Index>(i)) = nominal[i];
  }
  return seen;
}

std::vector<ToolSeen> tools_seen(
    const session::Session& session, const MeasuredTool& measured, const JointMap& joints) {
  std::vector<ToolSeen> all;
  for (const geometry::BranchInfo& each : session.rig.robot.model->assemblies) {
    all.push_back(tool_seen(session, measured, static_cast<Assembly>(each.number), joints));
  }
  return all;
}

std::optional<Assembly> assembly_by_target(const geometry::Rig& rig, const Sample& sample) {
  const geometry::Tool tool(rig);
  if (!sample.target_mm || sample.target_mm->size() != tool.axes()) return std::nullopt;
  const auto assembly = tool.assembly_at(rig.robot.nominal, sample.q, *sample.target_mm);
  if (!assembly) return std::nullopt;
  const auto at = tool.position(rig.robot.nominal, sample.q, *assembly);
  if (!at || (*at - *sample.target_mm).norm() > kNearTarget_mm) return std::nullopt;
  return *assembly;
}

std::optional<geometry::Position> nominal_at_target(
    const geometry::Rig& rig, const Sample& sample) {
  const geometry::Tool tool(rig);
  if (!sample.target_mm || sample.target_mm->size() != tool.axes()) return std::nullopt;
  std::optional<geometry::Position> nearest;
  for (const geometry::BranchInfo& each : rig.robot.model->assemblies) {
    const auto at =
        tool.position(rig.robot.nominal, sample.q, static_cast<Assembly>(each.number));
    if (!at) continue;
    const bool nearer = !nearest || (*at - *sample.target_mm).squaredNorm() <
                                        (*nearest - *sample.target_mm).squaredNorm();
    if (nearer) nearest = *at;
  }
  return nearest;
}

}  // namespace sixdial::studies::plausibility
