#include <algorithm>

#include "geometry/long_work.h"
#include "studies/plausibility/check.h"

namespace sixdial::studies {
namespace plausibility {

WarningPlace Look::rows(std::span<const std::size_t> rows, std::string field) const {
  WarningPlace place{
      .file = "session.csv", .field = std::move(field), .rows = static_cast<int>(rows.size())};
  if (rows.size() == measured.samples.size()) return place;  // all: none is worth a name
  for (const std::size_t row : rows.first(std::min(rows.size(), WarningPlace::kNamedRows))) {
    const session::Sample& sample = measured.samples[row];
    place.named.push_back({sample.line, sample.set, sample.point, sample.repeat});
  }
  return place;
}

WarningPlace Look::rig_key(std::string key) {
  return {.file = "rig.toml", .field = std::move(key)};
}

bool Look::told(std::string_view code) const {
  return std::ranges::any_of(found, [&](const Warning& each) { return each.code == code; });
}

std::string listed(const std::vector<std::string>& names) {
  std::string text;
  for (std::size_t i = 0; i < names.size(); ++i) {
    text += (i == 0 ? "" : i + 1 == names.size() ? " and " : ", ") + names[i];
  }
  return text;
}

std::string dials_in_words(const std::vector<std::string>& ids) {
  return (ids.size() == 1 ? "dial " : "dials ") + listed(ids);
}

const std::vector<PlausibilityCheck>& checks() {
  static const std::vector<PlausibilityCheck> kChecks{
      // What the file says.
      {"sets", {"set_not_used", "set_with_blanks"}, look_at_sets},
      {"copies",
       {"copied_rows", "copied_repeats", "g2_repeats_g1", "g2_at_poses_of_g1",
        "few_validating"},
       look_for_copies},
      {"columns", {"stuck_column", "copied_columns", "silent_dial"}, look_at_columns},
      {"clock",
       {"wrong_date", "clock_set_back", "not_in_order_of_time", "same_time", "long_pause"},
       look_at_clock},
      {"temperatures",
       {"temperature_unit", "wrong_temperature", "no_temperature"},
       look_at_temperatures},
      {"angles", {"row_in_degrees"}, look_at_angles},
      // What the columns hold: the nominal robot knows it better than their names do.
      {"far_positions", {"far_position"}, look_for_far_positions},
      {"joints",
       {"joints_in_degrees", "joint_unit", "joints_exchanged", "joint_reversed",
        "joints_of_other_row"},
       look_at_joints},
      {"turns", {"joint_wrapped"}, look_at_turns},
      {"dials", {"dials_exchanged", "dial_unit", "dial_reversed"}, look_at_dials},
      // A single row by its joint values, before its target is doubted.
      {"rows_elsewhere", {"row_elsewhere"}, look_at_rows_elsewhere},
      {"targets", {"targets_elsewhere"}, look_at_targets},
      {"sides", {"sides_reversed", "sides_from_rows"}, look_at_sides},
      // What no dial and no such rig can show.
      {"travel",
       {"reading_for_none", "sign_of_dial", "outside_travel", "end_of_travel"},
       look_at_travel},
      {"resolution", {"resolution"}, look_at_resolution},
      {"modes", {kWrongMode, "wrong_assembly"}, look_at_modes},
      {"cuboid_angle", {"reference_pose", "mount"}, look_at_cuboid_angle},
      {"two_instruments", {"positions_and_dials_differ"}, look_at_two_instruments},
      // Where it was measured, once it is known by what.
      {"frame",
       {"position_unit", "position_scale", "columns_exchanged", "axis_reversed",
        "frame_mirrored", "frame_registered", "base_registered"},
       look_at_frame},
      {"frame_moved", {"frame_moved"}, look_for_moved_frame},
      {"tool_turn",
       {"few_turns", "turns_fit_nowhere", "turns_not_explained", "far_turn", "far_turns",
        "tool_turn_registered", "tool_turn_not_set"},
       look_at_tool_turn},
      // Which joint values are right, once all else is.
      {"joint_values",
       {"joints_echo_command", "commanded_joints_fit_better", "read_joints_fit_better",
        "commanded_joints_alike", "few_poses_for_commands"},
       look_at_joint_values},
      // What the figures can be traced to.
      {"certificates", {"certificate_expired"}, look_at_certificates},
  };
  return kChecks;
}

}  // namespace plausibility

bool is_clean(const std::vector<Warning>& warnings) {
  return std::ranges::all_of(
      warnings, [](const Warning& each) { return each.severity == Severity::kNote; });
}

bool forbids_commands(const std::vector<Warning>& warnings) {
  return std::ranges::any_of(
      warnings, [](const Warning& each) { return each.severity == Severity::kWrong; });
}

geometry::WorkingMode working_mode_in_use(
    const std::vector<Warning>& warnings, const geometry::Rig& rig) {
  const auto found = std::ranges::find(warnings, plausibility::kWrongMode, &Warning::code);
  if (found == warnings.end()) return rig.robot.working_mode;
  const auto mode = found->parts.find("mode");
  if (mode == found->parts.end()) return rig.robot.working_mode;
  const auto* name = std::get_if<std::string>(&mode->second);
  return name == nullptr ? rig.robot.working_mode
                         : geometry::working_mode_from(*name).value_or(rig.robot.working_mode);
}

PlausibleSession plausible(const session::Session& session) {
  PlausibleSession judged{session};
  plausibility::Look look{
      session, judged.session, judged.warnings, judged.frame, judged.dial_of_column};
  std::int64_t done = 0;
  for (const plausibility::PlausibilityCheck& check : plausibility::checks()) {
    geometry::tell_step("checking the data", done++, std::ssize(plausibility::checks()));
    check.look(look);
  }
  return judged;
}

}  // namespace sixdial::studies
