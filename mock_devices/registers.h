// The register maps of doc/devices.md: six dials, and the robot controller.
#pragma once

#include <array>
#include <cstdint>
#include <functional>
#include <mutex>
#include <vector>

#include "mock_devices/live_rig.h"
#include "mock_devices/modbus_slave.h"

namespace sixdial::mock_devices {

/// One dial as its gauge box sees it.
struct DialRegisters {
  std::int32_t counts = 0;  // micrometres, or 1e-5 inch when switched
  bool valid = true;
  std::uint16_t status = 0;
  float shown = 0.0F;  // mm, or inch when switched
};
struct DialScan {
  std::vector<DialRegisters> dials;
  std::uint16_t scan = 0;
};

/// Input registers 0..11 int32, 100..105 status, 106 scan counter, 8000..8011 float32; the
/// holding registers are a copy of them that cannot be written.
class DialRegisterMap final : public RegisterMap {
 public:
  explicit DialRegisterMap(std::function<DialScan()> scan) : scan_(std::move(scan)) {}
  std::optional<std::vector<std::uint16_t>> read(
      RegisterTable table, std::uint16_t address, std::uint16_t count) override;
  std::optional<ModbusException> write(
      std::uint16_t address, std::span<const std::uint16_t> values) override;

 private:
  std::function<DialScan()> scan_;
};

/// How the controller's registers reach the robot.
struct RobotCalls {
  std::function<RobotReport()> report;
  std::function<void(const Eigen::VectorXd& q_rad, int speed_percent)> start;
  std::function<void()> stop;
  std::size_t joints = 2;
  /// As another controller moves it: to these joint values in so many seconds.
  std::function<void(const Eigen::VectorXd& q_rad, double seconds)> follow{};
};

/// Of n joints: holding 0..2n-1 targets, then command and speed; input 0..2n-1 actual values,
/// then status, moves, temperature, fault, cycle; input 200 the number of joints, unless it is
/// two.

class RobotRegisterMap final : public RegisterMap {
 public:
  explicit RobotRegisterMap(RobotCalls port)
      : port_(std::move(port)), holding_(2 * port_.joints + 2, 0) {
    holding_.back() = 100;  // full speed
  }
  std::optional<std::vector<std::uint16_t>> read(
      RegisterTable table, std::uint16_t address, std::uint16_t count) override;
  std::optional<ModbusException> write(
      std::uint16_t address, std::span<const std::uint16_t> values) override;

 private:
  RobotCalls port_;
  std::vector<std::uint16_t> holding_;
};

}  // namespace sixdial::mock_devices
