#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <set>

#include "session/rig_deviations.h"
#include "session/rig_figures.h"
#include "session/rig_file.h"
#include "session/rig_instrument.h"
#include "session/toml_write.h"

namespace sixdial::session {
namespace {

using geometry::Dial;

/// Value of a key that a robot kind writes; angles come in radians, under keys in degrees.
std::string value_text(const geometry::FileValue& value, bool degrees) {
  if (const auto* flag = std::get_if<bool>(&value.value)) return *flag ? "true" : "false";
  if (const auto* number = std::get_if<double>(&value.value)) {
    return toml_number(degrees ? degrees_of(*number) : *number);
  }
  if (const auto* text = std::get_if<std::string>(&value.value)) return toml_string(*text);
  std::string list;
  if (const auto* values = std::get_if<std::vector<geometry::FileValue>>(&value.value)) {
    for (const geometry::FileValue& each : *values) {
      list += (list.empty() ? "" : ", ") + value_text(each, degrees);
    }
  }
  return '[' + list + ']';
}
std::string line_of(const std::string& key, const geometry::FileValue& value) {
  return fmt::format("{} = {}\n", key, value_text(value, key.ends_with("_deg")));
}

/// [cuboid] or [instrument]: what measures.
std::string measuring_text(const geometry::Rig& rig) {
  if (rig.instrument.kind != geometry::Instrument{}.kind) return instrument_text(rig);
  const char* mount = rig.cuboid.mount == geometry::Mount::kDistal1   ? "distal1"
                      : rig.cuboid.mount == geometry::Mount::kDistal2 ? "distal2"
                                                                      : "free";
  const std::string out = fmt::format(
      "\n[cuboid]\nside_mm = {}\nmount = \"{}\"\nreference_pose_mm = {}\n",
      toml_number(rig.cuboid.side_mm), mount, toml_pair(rig.cuboid.reference_pose_mm));
  return out + deviations_text(rig.cuboid.deviations);
}

}  // namespace

std::string write_rig(const geometry::Rig& rig) {
  std::string out = "# Measurement rig and nominal robot. Lengths in mm, angles in degrees.\n";
  out += fmt::format(
      "name = {}\n{}\n[robot]\nmodel = \"{}\"\n", toml_string(rig.name),
      rig.tolerance_mm ? fmt::format("tolerance_mm = {}\n", toml_number(*rig.tolerance_mm))
                       : "",
      rig.robot.model->kind->name);
  const geometry::RobotModel& robot = *rig.robot.model;
  geometry::RobotFileText own;
  if (robot.kind->to_file != nullptr) own = robot.kind->to_file(robot, rig.robot.nominal);
  for (const auto& [key, value] : own.robot) out += line_of(key, value);
  for (const geometry::BranchInfo& mode : robot.modes) {
    if (robot.modes.size() == 1 || mode.number != rig.robot.working_mode.number) continue;
    out += fmt::format("working_mode = {}\n", toml_string(mode.name));
  }
  if (robot.assemblies.size() > 1) {
    out += fmt::format("assembly = {}\n", static_cast<int>(rig.robot.assembly));
  }
  for (std::size_t i = 0; i < robot.parameters.size(); ++i) {
    const geometry::ParameterInfo& info = robot.parameters[i];
    if (info.rig_key.empty()) continue;
    const double value = rig.robot.nominal[static_cast<Eigen::Index>(i)];
    out += fmt::format(
        "{} = {}\n", info.rig_key,
        toml_number(info.shown_unit == "deg" ? degrees_of(value) : value));
  }
  if (!rig.robot.connection.empty()) {
    out += fmt::format("connection = {}\n", toml_string(rig.robot.connection));
  }
  for (const geometry::FileValue::Table& joint : own.joints) {
    out += "\n[[joint]]\n";
    for (const auto& [key, value] : joint) out += line_of(key, value);
  }
  out += measuring_text(rig);
  // A figure that all dials share stands in [dials], any other in its [[dial]].
  std::array<bool, kDialFigures.size()> shared{};
  if (!rig.dials.empty()) out += "\n[dials]\n";
  for (std::size_t f = 0; f < kDialFigures.size() && !rig.dials.empty(); ++f) {
    std::set<double> values;
    for (Dial dial : rig.dials) values.insert(kDialFigures[f].of(dial));
    shared[f] = values.size() == 1;
    if (shared[f])
      out += fmt::format("{} = {}\n", kDialFigures[f].key, toml_number(*values.begin()));
  }
  const bool alike = std::ranges::all_of(rig.dials, [&](const Dial& dial) {
    return dial.deviations == rig.dials.front().deviations;
  });
  if (alike && !rig.dials.empty()) out += deviations_text(rig.dials.front().deviations);
  for (Dial dial : rig.dials) {
    out += fmt::format(
        "\n[[dial]]\nid = {}\nposition_mm = {}\naxis = {}\n", toml_string(dial.id),
        toml_pair(dial.geometry.position_mm), toml_pair(dial.geometry.axis));
    for (std::size_t f = 0; f < kDialFigures.size(); ++f) {
      if (shared[f]) continue;
      out +=
          fmt::format("{} = {}\n", kDialFigures[f].key, toml_number(kDialFigures[f].of(dial)));
    }
    if (!alike) out += deviations_text(dial.deviations);
    if (!dial.connection.empty()) {
      out += fmt::format("connection = {}\n", toml_string(dial.connection));
    }
  }
  return out;
}

}  // namespace sixdial::session
