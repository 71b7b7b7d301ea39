#include "acquisition/robot_driver.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>

#include "acquisition/connection_text.h"

namespace sixdial::acquisition {

extern const RobotDriver modbus_tcp_robot;
extern const RobotDriver gcode_serial_robot;
extern const RobotDriver gcode_tcp_robot;
extern const RobotDriver klipper_robot;
extern const RobotDriver linuxcnc_robot;
extern const RobotDriver exec_robot;
extern const RobotDriver manual_robot;

namespace {

constexpr std::array kDrivers{&modbus_tcp_robot, &gcode_serial_robot, &gcode_tcp_robot,
                              &klipper_robot,    &linuxcnc_robot,     &exec_robot,
                              &manual_robot};

}  // namespace

std::span<const RobotDriver* const> robot_drivers() { return kDrivers; }

std::string robot_forms() {
  std::string forms;
  for (const RobotDriver* driver : kDrivers) {
    forms += fmt::format("{}{}", forms.empty() ? "" : ", ", driver->form);
  }
  return forms;
}

std::string robot_table() {
  std::string table = "| connection | options | what is there |\n|---|---|---|\n";
  for (const RobotDriver* driver : kDrivers) {
    table +=
        fmt::format("| `{}` | {} | {} |\n", driver->form, driver->options, driver->in_words);
  }
  return table;
}

tl::expected<RobotConnection, std::string> parse_robot_connection(
    std::string_view text, std::span<const RobotJoint> joints) {
  try {
    if (text.empty()) refuse("it is empty; give one of {}", robot_forms());
    const std::string_view scheme = scheme_of(text);
    const auto* const found = std::ranges::find(kDrivers, scheme, &RobotDriver::scheme);
    if (found == kDrivers.end()) {
      std::array<std::string_view, kDrivers.size()> known{};
      std::ranges::transform(kDrivers, known.begin(), &RobotDriver::scheme);
      refuse(
          "unknown scheme '{}'; did you mean '{}'? (known for the robot: {})", scheme,
          nearest(scheme, known), robot_forms());
    }
    const bool bare = scheme.size() == text.size();
    const std::string_view rest = bare ? std::string_view() : text.substr(scheme.size() + 1);
    return RobotConnection{*found, (*found)->parse(rest, joints)};
  } catch (const Refused& refused) {
    return tl::unexpected(refused_connection(text, refused));
  }
}

std::vector<RobotJoint> joints_of(const geometry::Rig& rig) {
  std::vector<RobotJoint> joints;
  for (const geometry::JointInfo& joint : rig.robot.model->joints) {
    joints.push_back({joint.name, joint.unit() == "rad"});
  }
  return joints;
}

tl::expected<RobotConnection, std::string> robot_connection_of(const geometry::Rig& rig) {
  return parse_robot_connection(rig.robot.connection, joints_of(rig));
}

}  // namespace sixdial::acquisition
