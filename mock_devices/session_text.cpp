// The bundle files of spec 2 as text, by the mock's own hand: a second writer beside
// session/'s.
#include <fmt/format.h>

#include <chrono>
#include <cmath>
#include <fstream>
#include <nlohmann/json.hpp>
#include <numbers>
#include <stdexcept>

#include "geometry/units.h"
#include "mock_devices/iso_time.h"
#include "mock_devices/session_generator.h"

namespace sixdial::mock_devices {
namespace {

std::string sign_field(int sign) { return fmt::format("{}", sign); }

std::string toml_string(const std::string& text) {
  std::string result = "\"";
  for (const char c : text) {
    if (c == '"' || c == '\\') result += '\\';
    result += c;
  }
  return result + '"';
}

/// A TOML float: always with a point.
std::string toml_number(double value) {
  std::string text = fmt::format("{}", value);
  if (text.find_first_of(".en") == std::string::npos) text += ".0";
  return text;
}

std::string toml_pair(const Eigen::Vector2d& v) {
  return fmt::format("[{}, {}]", toml_number(v.x()), toml_number(v.y()));
}

std::string dial_figures(const geometry::Dial& dial, const geometry::Dial* common) {
  std::string text;
  const auto line = [&](const char* key, double value, double usual) {
    if (common == nullptr || value != usual) {
      text += fmt::format("{} = {}\n", key, toml_number(value));
    }
  };
  const geometry::Dial usual = common != nullptr ? *common : geometry::Dial{};
  line("travel_mm", dial.geometry.travel_mm, usual.geometry.travel_mm);
  line("resolution_mm", dial.resolution_mm, usual.resolution_mm);
  line("accuracy_mm", dial.accuracy_mm, usual.accuracy_mm);
  line("repeatability_mm", dial.repeatability_mm, usual.repeatability_mm);
  line("tip_radius_mm", dial.geometry.tip_radius_mm, usual.geometry.tip_radius_mm);
  line("force_n", dial.force_n, usual.force_n);
  line("spring_n_per_mm", dial.spring_n_per_mm, usual.spring_n_per_mm);
  return text;
}

std::string sd_line(const char* key, const std::optional<double>& sd, double unit = 1.0) {
  return sd ? fmt::format("{} = {}\n", key, toml_number(*sd / unit)) : std::string();
}

std::string deviations(const geometry::DialDeviations& of) {
  std::string text;
  if (of.position_mm) {
    text += fmt::format("position_sd_mm = {}\n", toml_pair(*of.position_mm));
  }
  return text + sd_line("axis_sd_deg", of.axis_rad, geometry::kRadPerDeg) +
         sd_line("tip_radius_sd_mm", of.tip_radius_mm);
}

std::string deviations(const geometry::CuboidDeviations& of) {
  return sd_line("side_sd_mm", of.side_mm) +
         sd_line("squareness_sd_deg", of.squareness_rad, geometry::kRadPerDeg) +
         sd_line("offset_sd_mm", of.offset_mm);
}

}  // namespace

std::string session_csv(
    const GeneratedSession& session, const geometry::Rig& rig, const std::string& start_time) {
  const std::int64_t start_ms = milliseconds_of(start_time);
  std::string text =
      "set,point,repeat,time_utc,theta1_rad,theta2_rad,target_x_mm,target_y_mm,approach1,"
      "approach2,temperature_c";
  for (const geometry::Dial& dial : rig.dials) text += fmt::format(",dial_{}_mm", dial.id);
  text += '\n';
  for (const MeasuredRow& row : session.rows) {
    const PlannedPose& pose = row.planned;
    text += fmt::format(
        "{},{},{},{},{:.9f},{:.9f},", pose.set, pose.point, pose.repeat,
        iso8601(start_ms + std::llround(pose.time_s * 1000.0)), pose.q_rad[0], pose.q_rad[1]);
    text += pose.target_mm
                ? fmt::format("{:.6f},{:.6f}", pose.target_mm->x(), pose.target_mm->y())
                : std::string(",");
    text += fmt::format(
        ",{},{},{:.2f}", sign_field(row.approach[0]), sign_field(row.approach[1]),
        row.temperature_c);
    for (const std::optional<double>& value : row.dial_mm) {
      text += value ? fmt::format(",{:.3f}", *value) : std::string(",");
    }
    text += '\n';
  }
  return text;
}

std::string rig_toml(const geometry::Rig& rig) {
  std::string text =
      fmt::format("name = {}\n\n[robot]\nmodel = \"five_bar\"\n", toml_string(rig.name));
  text += fmt::format(
      "working_mode = \"{}\"\nassembly = {}\n", geometry::to_string(rig.robot.working_mode),
      static_cast<int>(rig.robot.assembly));
  for (int i = 0; i < geometry::kParameterCount; ++i) {
    const geometry::ParameterInfo& info = geometry::kParameters[static_cast<std::size_t>(i)];
    text += fmt::format(
        "{} = {}\n", info.rig_key, toml_number(rig.robot.nominal[i] * info.shown_per_unit));
  }
  if (!rig.robot.connection.empty()) {
    text += fmt::format("connection = {}\n", toml_string(rig.robot.connection));
  }
  const std::string_view mount = rig.cuboid.mount == geometry::Mount::kFree      ? "free"
                                 : rig.cuboid.mount == geometry::Mount::kDistal1 ? "distal1"
                                                                                 : "distal2";
  text += fmt::format(
      "\n[cuboid]\nside_mm = {}\nmount = \"{}\"\nreference_pose_mm = {}\n{}\n[dials]\n",
      toml_number(rig.cuboid.side_mm), mount, toml_pair(rig.cuboid.reference_pose_mm),
      deviations(rig.cuboid.deviations));
  const geometry::Dial common = rig.dials.empty() ? geometry::Dial{} : rig.dials.front();
  text += dial_figures(common, nullptr);
  for (const geometry::Dial& dial : rig.dials) {
    text += fmt::format(
        "\n[[dial]]\nid = {}\nposition_mm = {}\naxis = {}\n", toml_string(dial.id),
        toml_pair(dial.geometry.position_mm), toml_pair(dial.geometry.axis));
    text += dial_figures(dial, &common) + deviations(dial.deviations);
    if (!dial.connection.empty()) {
      text += fmt::format("connection = {}\n", toml_string(dial.connection));
    }
  }
  return text;
}

std::string answer_json(const World& world) {
  nlohmann::ordered_json answer;
  answer["causes"] = nlohmann::ordered_json::array();
  answer["effects"] = nlohmann::ordered_json::array();
  bool unknown = false;
  for (const HiddenEffect& effect : world.effects) {
    const bool in_catalogue = cause_row(effect.cause).in_catalogue;
    if (in_catalogue) answer["causes"].push_back({effect.cause, effect.where});
    unknown = unknown || !in_catalogue;
    answer["effects"].push_back(
        {{"cause", effect.cause}, {"where", effect.where}, {"parameters", effect.parameters}});
  }
  if (world.warp.amplitude_mm != 0.0) {
    unknown = true;
    answer["warp"] = {
        {"amplitude_mm", world.warp.amplitude_mm}, {"wavelength_mm", world.warp.wavelength_mm}};
  }
  answer["unknown"] = unknown;
  for (int i = 0; i < geometry::kParameterCount; ++i) {
    const std::string name(geometry::kParameters[static_cast<std::size_t>(i)].name);
    answer["true_robot"][name] = world.robot.parameters[i];
  }
  answer["clamp_rad"] = world.robot.clamp_rad;
  answer["noise_mm"] = world.dials.noise_sd_mm;
  answer["seed"] = world.seed;
  return answer.dump(2) + "\n";
}

void write_bundle(
    const std::filesystem::path& folder, const GeneratedSession& session,
    const geometry::Rig& rig, const std::string& start_time) {
  std::filesystem::create_directories(folder);
  const auto write = [&](const char* name, const std::string& text) {
    std::ofstream file(folder / name, std::ios::binary);
    file << text;
    if (!file.flush()) {
      throw std::runtime_error(fmt::format("cannot write {}", (folder / name).string()));
    }
  };
  write("session.csv", session_csv(session, rig, start_time));
  write("rig.toml", rig_toml(rig));
}

}  // namespace sixdial::mock_devices
