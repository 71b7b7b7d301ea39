#include <fmt/format.h>

#include <array>
#include <cmath>
#include <set>

#include "geometry/units.h"
#include "session/csv.h"
#include "session/rig_figures.h"
#include "session/rig_file.h"

namespace sixdial::session {
namespace {

using geometry::Dial;
using geometry::kRadPerDeg;

std::string toml_text(const std::string& text) {
  std::string quoted = "\"";
  for (const char c : text) {
    if (c == '"' || c == '\\') {
      quoted += '\\';
      quoted += c;
    } else if (static_cast<unsigned char>(c) < 0x20U || c == 0x7F) {
      quoted += fmt::format("\\u{:04X}", static_cast<unsigned>(c));
    } else {
      quoted += c;
    }
  }
  return quoted + '"';
}

/// Shortest text that reads back as the same double, always with a point or an exponent.
std::string toml_number(double value) {
  std::string text = fmt::format("{}", value);
  if (text.find_first_of(".en") == std::string::npos) text += ".0";
  return text;
}

std::string toml_pair(const Eigen::Vector2d& pair) {
  return fmt::format("[{}, {}]", toml_number(pair.x()), toml_number(pair.y()));
}

/// Degrees that convert back to the same radians, if a double does; the shortest such text.
double degrees_of(double rad) {
  const double near = rad / kRadPerDeg;
  for (const int digits : {6, 9, 12, 15}) {
    const double rounded = parse_number(fmt::format("{:.{}g}", near, digits)).value;
    if (rounded * kRadPerDeg == rad) return rounded;
  }
  double down = near;
  double up = near;
  for (int step = 0; step < 4; ++step) {
    if (down * kRadPerDeg == rad) return down;
    if (up * kRadPerDeg == rad) return up;
    down = std::nextafter(down, -1e300);
    up = std::nextafter(up, 1e300);
  }
  return near;
}

/// [cuboid] or [instrument]: what measures.
std::string instrument_text(const geometry::Rig& rig) {
  const geometry::Instrument usual;
  std::string out;
  if (rig.instrument.kind != usual.kind) {
    out += fmt::format("\n[instrument]\nkind = {}\n", toml_text(rig.instrument.kind));
    if (rig.instrument.sd_mm > 0.0) {
      out += fmt::format("sd_mm = {}\n", toml_number(rig.instrument.sd_mm));
    }
    if (rig.instrument.dimensions != usual.dimensions) {
      out += fmt::format("dimensions = {}\n", rig.instrument.dimensions);
    }
    return out;
  }
  const char* mount = rig.cuboid.mount == geometry::Mount::kDistal1   ? "distal1"
                      : rig.cuboid.mount == geometry::Mount::kDistal2 ? "distal2"
                                                                      : "free";
  out += fmt::format(
      "\n[cuboid]\nside_mm = {}\nmount = \"{}\"\nreference_pose_mm = {}\n",
      toml_number(rig.cuboid.side_mm), mount, toml_pair(rig.cuboid.reference_pose_mm));
  return out;
}

}  // namespace

std::string write_rig(const geometry::Rig& rig) {
  std::string out = "# Measurement rig and nominal robot. Lengths in mm, angles in degrees.\n";
  out += fmt::format(
      "name = {}\n{}\n[robot]\nmodel = \"{}\"\n", toml_text(rig.name),
      rig.tolerance_mm ? fmt::format("tolerance_mm = {}\n", toml_number(*rig.tolerance_mm))
                       : "",
      rig.robot.model->kind->name);
  const geometry::RobotModel& robot = *rig.robot.model;
  if (robot.kind->to_file != nullptr) out += robot.kind->to_file(robot);
  for (const geometry::BranchInfo& mode : robot.modes) {
    if (robot.modes.size() == 1 || mode.number != rig.robot.working_mode.number) continue;
    out += fmt::format("working_mode = {}\n", toml_text(mode.name));
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
    out += fmt::format("connection = {}\n", toml_text(rig.robot.connection));
  }
  out += instrument_text(rig);
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
  for (Dial dial : rig.dials) {
    out += fmt::format(
        "\n[[dial]]\nid = {}\nposition_mm = {}\naxis = {}\n", toml_text(dial.id),
        toml_pair(dial.geometry.position_mm), toml_pair(dial.geometry.axis));
    for (std::size_t f = 0; f < kDialFigures.size(); ++f) {
      if (shared[f]) continue;
      out +=
          fmt::format("{} = {}\n", kDialFigures[f].key, toml_number(kDialFigures[f].of(dial)));
    }
    if (!dial.connection.empty()) {
      out += fmt::format("connection = {}\n", toml_text(dial.connection));
    }
  }
  return out;
}

}  // namespace sixdial::session
