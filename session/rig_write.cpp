#include "session/rig_write.h"

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

/// Whether a rig file says anything of the cuboid that is not so without [cuboid].
bool is_usual(const geometry::Cuboid& cuboid) {
  const geometry::Cuboid usual;
  return cuboid.side_mm == usual.side_mm && cuboid.mount == usual.mount &&
         cuboid.reference_pose_mm == usual.reference_pose_mm &&
         cuboid.deviations == usual.deviations;
}

/// [instrument] and [cuboid]: what measures.
std::string measuring_text(const geometry::Rig& rig, const std::string& traced) {
  const std::string instrument = instrument_text(rig);
  const bool on_cuboid = rig.instrument.kind == geometry::Instrument{}.kind;
  if (!on_cuboid && traced.empty() && is_usual(rig.cuboid)) return instrument;
  const char* mount = rig.cuboid.mount == geometry::Mount::kDistal1   ? "distal1"
                      : rig.cuboid.mount == geometry::Mount::kDistal2 ? "distal2"
                                                                      : "free";
  return fmt::format(
      "{}\n[cuboid]\nside_mm = {}\nmount = \"{}\"\nreference_pose_mm = {}\n{}{}", instrument,
      toml_number(rig.cuboid.side_mm), mount, toml_pair(rig.cuboid.reference_pose_mm),
      deviations_text(rig.cuboid.deviations), traced);
}

/// The keys of a part, a line each; empty: nothing is known of it.
std::string lines_of(const Traceability& traced, std::string_view what) {
  const TracedPart* part = traced.find(what);
  if (part == nullptr) return "";
  std::string lines;
  const auto date = [&](const char* key, const std::string& value) {
    if (!value.empty()) lines += fmt::format("{} = {}\n", key, value);
  };
  const auto text = [&](const char* key, const std::string& value) {
    if (!value.empty()) lines += fmt::format("{} = {}\n", key, toml_string(value));
  };
  text("serial", part->serial);
  text("certificate", part->certificate);
  date("certified", part->certified);
  date("due", part->due);
  return lines;
}

/// [dials] and each [[dial]].
std::string dials_text(const geometry::Rig& rig, const Traceability& traced) {
  if (rig.dials.empty()) return "";
  std::string out = "\n[dials]\n";
  // A figure that all dials share stands in [dials], any other in its [[dial]].
  std::array<bool, kDialFigures.size()> shared{};
  for (std::size_t f = 0; f < kDialFigures.size(); ++f) {
    std::set<double> values;
    for (Dial dial : rig.dials) values.insert(kDialFigures[f].of(dial));
    shared[f] = values.size() == 1;
    if (shared[f])
      out += fmt::format("{} = {}\n", kDialFigures[f].key, toml_number(*values.begin()));
  }
  const bool alike = std::ranges::all_of(rig.dials, [&](const Dial& dial) {
    return dial.deviations == rig.dials.front().deviations;
  });
  if (alike) out += deviations_text(rig.dials.front().deviations);
  for (Dial dial : rig.dials) {
    out += fmt::format("\n[[dial]]\nid = {}\n", toml_string(dial.id));
    if (rig.on_cuboid()) {
      out += fmt::format(
          "position_mm = {}\naxis = {}\n", toml_pair(dial.geometry.position_mm),
          toml_pair(dial.geometry.axis));
    }
    for (std::size_t f = 0; f < kDialFigures.size(); ++f) {
      if (shared[f]) continue;
      out +=
          fmt::format("{} = {}\n", kDialFigures[f].key, toml_number(kDialFigures[f].of(dial)));
    }
    if (!alike) out += deviations_text(dial.deviations);
    if (!dial.connection.empty()) {
      out += fmt::format("connection = {}\n", toml_string(dial.connection));
    }
    out += lines_of(traced, "dial " + dial.id);
  }
  return out;
}

}  // namespace

std::string write_rig(const geometry::Rig& rig) { return write_rig(rig, {}); }

std::string write_rig(const geometry::Rig& rig, const Traceability& traced) {
  std::string out = "# Measurement rig and nominal robot. Lengths in mm, angles in degrees.\n";
  out += fmt::format("name = {}\n", toml_string(rig.name));
  if (rig.tolerance_mm) {
    out += fmt::format("tolerance_mm = {}\n", toml_number(*rig.tolerance_mm));
  }
  if (!traced.operator_name.empty()) {
    out += fmt::format("operator = {}\n", toml_string(traced.operator_name));
  }
  out += fmt::format("\n[robot]\nmodel = \"{}\"\n", rig.robot.model->kind->name);
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
  out += lines_of(traced, "robot");
  for (const geometry::FileValue::Table& joint : own.joints) {
    out += "\n[[joint]]\n";
    for (const auto& [key, value] : joint) out += line_of(key, value);
  }
  out += measuring_text(rig, lines_of(traced, "cuboid"));
  out += dials_text(rig, traced);
  const std::string thermometer = lines_of(traced, "thermometer");
  if (!thermometer.empty()) out += "\n[thermometer]\n" + thermometer;
  return out;
}

std::string self_contained(const geometry::Rig& rig, std::string_view rig_text) {
  return rig.robot.model->from_other_file ? write_rig(rig, traceability_of(rig_text))
                                          : std::string(rig_text);
}

}  // namespace sixdial::session
