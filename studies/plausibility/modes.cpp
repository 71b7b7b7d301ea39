// The working mode of the rig file against that of the samples. A rig file of another mode
// turns the cuboid's reference and commands the other branch.
#include <algorithm>
#include <map>
#include <optional>

#include "geometry/tool.h"
#include "session/trials.h"
#include "studies/plausibility/check.h"

namespace sixdial::studies::plausibility {
namespace {

/// The way in which the distal links close, by targets, positions or readings.
void look_at_assembly(Look& look) {
  geometry::Robot& robot = look.used.rig.robot;
  if (robot.model->assemblies.size() < 2) return;
  int samples = 0;
  std::optional<geometry::Assembly> all;
  for (const session::Sample& sample : look.used.samples) {
    if (sample.left_out) continue;
    const geometry::Assembly each = session::assembly_of(look.used.rig, sample);
    if (each == robot.assembly || (all && *all != each)) return;
    all = each;
    ++samples;
  }
  if (!all) return;
  look.tell(
      "wrong_assembly", Severity::kDoubt, Look::rig_key("[robot] assembly"),
      {{"samples", static_cast<double>(samples)},
       {"assembly", static_cast<double>(*all)},
       {"rig_assembly", static_cast<double>(robot.assembly)}});
  robot.assembly = *all;
}

}  // namespace

void look_at_modes(Look& look) {
  look_at_assembly(look);
  geometry::Robot& robot = look.used.rig.robot;
  const geometry::Tool tool(look.used.rig);
  std::map<int, std::vector<std::size_t>> rows_of;  // by mode
  for (std::size_t i = 0; i < look.used.samples.size(); ++i) {
    const session::Sample& sample = look.used.samples[i];
    if (sample.left_out) continue;
    const auto mode =
        tool.mode_of(robot.nominal, sample.q, session::assembly_of(look.used.rig, sample));
    if (mode) rows_of[mode->number].push_back(i);
  }
  if (rows_of.empty() || rows_of.contains(robot.working_mode.number)) return;
  const auto most = std::ranges::max_element(
      rows_of, {}, [](const auto& each) { return each.second.size(); });
  const geometry::WorkingMode found(most->first);
  look.tell(
      kWrongMode, Severity::kDoubt, Look::rig_key("[robot] working_mode"),
      {{"samples", static_cast<double>(most->second.size())},
       {"mode", geometry::to_string(found)},
       {"rig_mode", geometry::to_string(robot.working_mode)}});
  robot.working_mode = found;
}

}  // namespace sixdial::studies::plausibility
