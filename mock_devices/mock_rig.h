// The whole mock rig in one object: true world, clock, cables. For tests in their own process
// and for the program sixdial-mock-rig.
//
//   MockRig rig({.clock_speed = 50, .pty_directory = "ptys"});
//   rig.start();
//   connect(rig.connected_rig("mux10"));   // a rig file's content, with connection strings
#pragma once

#include <cstdint>
#include <filesystem>
#include <map>
#include <memory>
#include <string>
#include <vector>

#include "mock_devices/rig_bench.h"
#include "mock_devices/served_controller.h"
#include "mock_devices/wire.h"
#include "mock_devices/world.h"

namespace sixdial::mock_devices {

struct MockRigOptions {
  World world;
  LiveRigHabits habits;
  double clock_speed = 1.0;  // mock seconds a wall second
  std::string start_time = "2026-03-02T08:30:00.000Z";
  std::string address = "127.0.0.1";
  std::uint16_t dial_port = 0;  // 0: any free one
  std::uint16_t robot_port = 0;
  std::filesystem::path pty_directory;  // empty: no serial lines
  std::vector<std::string> dialects{"mux10", "sylvac"};
  int rtu_baud = 19200;  // of the gauge box on modbus_rtu
  /// Of served_controller.h; empty: the controller with registers.
  std::string robot_controller{};
  std::filesystem::path robot_link{};  // of that controller
};

struct MockPorts {
  std::uint16_t dials = 0;
  std::uint16_t robot = 0;                              // 0: it has a socket file
  std::map<std::string, std::filesystem::path> serial;  // "mux10", "sylvac_A", ...
};

class MockRig {
 public:
  /// Throws std::invalid_argument for a world that makes no sense.
  explicit MockRig(MockRigOptions options);
  ~MockRig();
  MockRig(const MockRig&) = delete;
  MockRig& operator=(const MockRig&) = delete;

  /// Opens the ports; mock time starts with construction. Throws std::system_error.
  void start();
  /// Closes every port and joins. Idempotent.
  void stop();
  /// Throws std::logic_error unless started.
  [[nodiscard]] MockPorts ports() const;

  /// The nominal rig with `connection` filled in: "modbus-tcp", or the name of a serial dialect
  /// that is served.
  [[nodiscard]] geometry::Rig connected_rig(const std::string& kind) const;
  /// Of the robot's controller, in rig.toml's words.
  [[nodiscard]] std::string robot_connection() const;
  /// By its pseudo-terminal; empty: it has none.
  [[nodiscard]] std::string robot_serial_connection() const;

  /// Mock seconds since construction, and mock UTC.
  [[nodiscard]] double seconds() const { return clock_.seconds(); }
  [[nodiscard]] std::int64_t utc_ms() const { return clock_.utc_ms(); }
  [[nodiscard]] const MockClock& clock() const { return clock_; }

  /// What nobody may see through the cables.
  [[nodiscard]] TruePose true_pose() const { return bench_.true_pose(); }
  [[nodiscard]] RobotReport robot() const { return bench_.robot(); }
  [[nodiscard]] const World& world() const { return bench_.world(); }

  /// Throws std::invalid_argument if the rig has no such dial.
  void order_fault(const std::string& dial_id, const FaultOrder& order);
  void clear_faults();

 private:
  const MockRigOptions options_;
  MockClock clock_;
  RigBench bench_;
  std::unique_ptr<Wire> wire_;
  std::unique_ptr<ServedController> served_;
};

}  // namespace sixdial::mock_devices
