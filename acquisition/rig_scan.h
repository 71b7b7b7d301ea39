// Who is at the other end of which cable: every serial port by its stable name, every dialect
// tried on it, gauge boxes asked, live values read, and a rig file compared with what answers.
// Each line comes with what to do about it.
#pragma once

#include <filesystem>
#include <optional>
#include <span>
#include <stop_token>
#include <string>
#include <vector>

#include "acquisition/clock.h"
#include "acquisition/reading.h"
#include "acquisition/robot.h"
#include "geometry/rig.h"

namespace sixdial::acquisition {

struct PortName {
  std::string name;    // stable: /dev/serial/by-id/..., else the device itself
  std::string device;  // what it is today: /dev/ttyUSB0
  std::string about;   // as the adapter calls itself
};
/// The links in `by_id`, then what the system lists besides (built-in ports without a name).
[[nodiscard]] std::vector<PortName> serial_ports(
    const std::filesystem::path& by_id = "/dev/serial/by-id");

struct FoundDial {
  std::string connection;  // to write into the rig file
  std::string answer;      // as it came, or the register's place
  Reading reading;
};

struct ScannedPlace {
  std::string name;
  std::vector<FoundDial> dials;
  std::string trouble;  // empty if dials were found
  std::string fix;
};

/// Asks in every dialect, and for a Modbus unit 1 at 19200 and 9600 baud, until one is
/// understood.
[[nodiscard]] ScannedPlace scan_serial(
    const std::string& device, Clock& clock, const std::stop_token& stop);
/// "host:port", unit 1, the registers of doc/devices.md.
[[nodiscard]] ScannedPlace scan_gauge_box(
    const std::string& host_and_port, Clock& clock, const std::stop_token& stop);

struct CheckedDial {
  std::string id;
  std::string connection;
  Reading reading;
  bool good = false;
  std::string trouble;
  std::string fix;
};
struct CheckedRig {
  std::string trouble;  // of the connection strings; nothing was asked then
  std::vector<CheckedDial> dials;
  std::optional<RobotState> robot;  // empty: none, moved by hand, or no answer
  std::string robot_trouble;
  std::string robot_fix;
  [[nodiscard]] bool good() const;
};

/// Reads every dial of the rig file and asks the robot where it is; values are compared with
/// the nominal robot's at that pose. `found`: dials that a scan saw, to say where a silent one
/// may be.
[[nodiscard]] CheckedRig check_rig(
    const geometry::Rig& rig, std::span<const ScannedPlace> found, Clock& clock,
    const std::stop_token& stop);

/// What to do about a reading's reason ("timeout", "frozen", ...).
[[nodiscard]] std::string advice_for(const std::string& reason);

}  // namespace sixdial::acquisition
