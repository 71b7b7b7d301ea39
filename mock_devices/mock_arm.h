// The whole mock arm in one object: bench, clock, cables. For tests in their own process and
// for `sixdial-mock-rig --robot serial`.
//
//   MockArm arm({.world = drawn_arm(7, 6), .clock_speed = 20});
//   arm.start();
//   write_file("rig.toml", arm.rig_text());   // leads to its ports
#pragma once

#include <cstdint>
#include <filesystem>
#include <memory>
#include <string>
#include <string_view>

#include "mock_devices/arm_bench.h"
#include "mock_devices/rig_bench.h"
#include "mock_devices/served_controller.h"
#include "mock_devices/wire.h"

namespace sixdial::mock_devices {

/// "cause:where:amplitude", or "cause" or "cause:where" with the rest drawn from the seed.
/// Throws std::invalid_argument with what would be right.
[[nodiscard]] ArmEffect parse_arm_effect(
    const ArmWorld& world, std::string_view text, std::uint64_t seed);
/// What is hidden in it, as JSON.
[[nodiscard]] std::string arm_answer_json(const ArmWorld& world);

struct MockArmOptions {
  ArmWorld world;
  int rows = 150;  // samples that a session will have
  double clock_speed = 1.0;
  std::string start_time = "2026-03-02T08:30:00.000Z";
  std::string address = "127.0.0.1";
  std::uint16_t dial_port = 0;  // 0: any free one
  std::uint16_t robot_port = 0;
  /// Of served_controller.h; empty: the controller with registers.
  std::string robot_controller{};
  std::filesystem::path robot_link{};  // of that controller
};

class MockArm {
 public:
  explicit MockArm(MockArmOptions options);

  /// Opens the ports; mock time starts with construction. Throws std::system_error, and
  /// std::invalid_argument for a controller that cannot move so many joints.
  void start();
  /// Throws std::logic_error unless started.
  [[nodiscard]] std::uint16_t dial_port() const;
  [[nodiscard]] std::uint16_t robot_port() const;  // 0: it has a socket file
  /// Of the robot's controller, in rig.toml's words.
  [[nodiscard]] std::string robot_connection() const;
  /// By its pseudo-terminal; empty: it has none.
  [[nodiscard]] std::string robot_serial_connection() const;
  /// rig.toml that leads to its ports.
  [[nodiscard]] std::string rig_text() const;
  [[nodiscard]] std::int64_t utc_ms() const { return clock_.utc_ms(); }
  [[nodiscard]] ArmBench& bench() { return bench_; }

 private:
  [[nodiscard]] const Wire& wire() const;

  const MockArmOptions options_;
  MockClock clock_;
  ArmBench bench_;
  std::unique_ptr<Wire> wire_;
  std::unique_ptr<ServedController> served_;
};

}  // namespace sixdial::mock_devices
