// Joint angles that jump by whole turns: a controller that gives them within +-180 deg, where
// the joint itself went on. The robot stands the same, but a network on joint angles would see
// two regions far apart. Within one working mode a joint's angles belong on one arc.
#include <algorithm>
#include <cmath>
#include <map>
#include <numbers>

#include "geometry/tool.h"
#include "session/sample_layout.h"
#include "studies/plausibility/check.h"

namespace sixdial::studies::plausibility {
namespace {

constexpr double kTurn_rad = 2.0 * std::numbers::pi;
constexpr double kWidestArc_rad = 1.5 * std::numbers::pi;
constexpr std::size_t kFewestRows = 4;

using Rows = std::vector<std::size_t>;

/// Rows by the working mode that their angles are in, by the nominal robot.
std::map<int, Rows> rows_by_mode(const session::Session& session) {
  const geometry::Rig& rig = session.rig;
  const geometry::Tool tool(rig);
  std::map<int, Rows> by_mode;
  for (std::size_t i = 0; i < session.samples.size(); ++i) {
    const session::Sample& sample = session.samples[i];
    if (sample.left_out || !sample.q.allFinite()) continue;
    geometry::Assembly assembly = rig.robot.assembly;
    if (sample.target_mm && sample.target_mm->size() == tool.axes()) {
      assembly =
          tool.assembly_at(rig.robot.nominal, sample.q, *sample.target_mm).value_or(assembly);
    }
    const auto mode = tool.mode_of(rig.robot.nominal, sample.q, assembly);
    by_mode[mode ? mode->number : -1].push_back(i);
  }
  return by_mode;
}

/// Where the one arc begins that holds all angles; empty: they already lie on one, or no arc is
/// short enough to say so.
std::optional<double> arc_start(std::vector<double> angles) {
  const auto [low, high] = std::ranges::minmax(angles);
  if (high - low <= std::numbers::pi) return std::nullopt;
  for (double& angle : angles) angle -= kTurn_rad * std::floor(angle / kTurn_rad);
  std::ranges::sort(angles);
  double start = angles.front();
  double gap = angles.front() + kTurn_rad - angles.back();
  for (std::size_t i = 1; i < angles.size(); ++i) {
    if (angles[i] - angles[i - 1] <= gap) continue;
    gap = angles[i] - angles[i - 1];
    start = angles[i];
  }
  const double arc = kTurn_rad - gap;
  if (arc > kWidestArc_rad || arc > (high - low) / 2.0 + 1e-9) return std::nullopt;
  return start;
}

/// The same angles on one arc, on the turn that most of them are on.
std::vector<double> on_one_arc(const std::vector<double>& angles, double start) {
  std::map<long, int> votes;
  std::vector<double> result;
  for (const double angle : angles) {
    const auto turn = static_cast<long>(std::floor((angle - start) / kTurn_rad + 1e-12));
    result.push_back(angle - kTurn_rad * static_cast<double>(turn));
    ++votes[turn];
  }
  const auto most = std::ranges::max_element(
      votes, [](const auto& a, const auto& b) { return a.second < b.second; });
  for (double& angle : result) angle += kTurn_rad * static_cast<double>(most->first);
  return result;
}

}  // namespace

void look_at_turns(Look& look) {
  const session::SampleLayout layout = session::layout_of(look.used.rig);
  const auto by_mode = rows_by_mode(look.used);
  for (std::size_t joint = 0; joint < layout.joints.size(); ++joint) {
    if (layout.joints[joint].unit != "rad") continue;
    const auto k = static_cast<Eigen::Index>(joint);
    Rows turned;
    for (const auto& [mode, rows] : by_mode) {
      if (rows.size() < kFewestRows) continue;
      std::vector<double> angles;
      for (const std::size_t row : rows) angles.push_back(look.used.samples[row].q[k]);
      const auto start = arc_start(angles);
      if (!start) continue;
      const std::vector<double> continuous = on_one_arc(angles, *start);
      for (std::size_t i = 0; i < rows.size(); ++i) {
        if (std::abs(continuous[i] - angles[i]) < 1.0) continue;
        look.used.samples[rows[i]].q[k] = continuous[i];
        turned.push_back(rows[i]);
      }
    }
    if (turned.empty()) continue;
    std::ranges::sort(turned);
    look.tell(
        "joint_wrapped", Severity::kNote, look.rows(turned, layout.joints[joint].column()),
        {{"joint", layout.joints[joint].name}});
  }
}

}  // namespace sixdial::studies::plausibility
