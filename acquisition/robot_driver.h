// How a robot's controller is reached: a row for each kind of connection, its file is in
// robots/. `connection` of [robot] in a rig file names the row and what it needs.
//
//   modbus-tcp://HOST:PORT?unit=1
//   gcode-serial:/dev/serial/by-id/...?dialect=grbl&axes=X,Y,Z
//   gcode-tcp:HOST:PORT?dialect=marlin
//   klipper:/tmp/klippy_uds
//   linuxcnc:HOST:5007
//   exec:/home/me/move.sh {q1_deg} {q2_deg}
//   manual
//
// A new one is a file with a RobotPort and its row, and a line in robot_driver.cpp.
//
// Example:
//   const std::vector<RobotJoint> driven = joints_of(rig);
//   driven.size();  // -> 2U
//   const auto connection = parse_robot_connection("modbus-tcp://10.0.0.7:502", driven);
//   connection->driver->scheme;  // -> "modbus-tcp"
//   connection->driver->by_hand;  // -> false
#pragma once

#include <functional>
#include <memory>
#include <span>
#include <string>
#include <string_view>
#include <tl/expected.hpp>
#include <vector>

#include "acquisition/clock.h"
#include "acquisition/robot.h"
#include "acquisition/robots/manual_robot.h"
#include "geometry/rig.h"

namespace sixdial::acquisition {

/// What a robot's port stands in. The clock outlives it.
struct RobotSite {
  Clock& clock;
  ManualRobot::Ask ask{};  // of a robot that is moved by hand
};
/// Makes the port; nothing is opened or asked before its first call.
using OpenRobot = std::function<std::unique_ptr<RobotPort>(const RobotSite&)>;

struct RobotDriver {
  std::string_view scheme;     // what the string begins with, up to the colon
  std::string_view form;       // for people: "modbus-tcp://HOST:PORT"
  std::string_view in_words;   // what is at the other end; a row of doc/devices.md
  std::string_view options{};  // that may follow, likewise
  /// A person moves the robot: there is nothing to stop, and nothing to ask.
  bool by_hand = false;
  /// It starts a program on this machine: the service does so only where it was told that it
  /// may.
  bool runs_programs = false;
  /// `rest` is what follows the scheme and its colon. Pure. Throws Refused
  /// (connection_text.h).
  OpenRobot (*parse)(std::string_view rest, std::span<const RobotJoint> joints) = nullptr;
};

/// All kinds, in the order in which people see them.
[[nodiscard]] std::span<const RobotDriver* const> robot_drivers();
/// "modbus-tcp://HOST:PORT, manual".
[[nodiscard]] std::string robot_forms();
/// The table of doc/devices.md.
[[nodiscard]] std::string robot_table();

struct RobotConnection {
  const RobotDriver* driver = nullptr;
  OpenRobot open;
};
/// The error is one sentence that names what is wrong and the nearest thing that would be
/// right.
[[nodiscard]] tl::expected<RobotConnection, std::string> parse_robot_connection(
    std::string_view text, std::span<const RobotJoint> joints);

[[nodiscard]] std::vector<RobotJoint> joints_of(const geometry::Rig& rig);
/// Of the rig's robot.
[[nodiscard]] tl::expected<RobotConnection, std::string> robot_connection_of(
    const geometry::Rig& rig);

}  // namespace sixdial::acquisition
