// A robot's controller on Modbus TCP, of any number of joints: the registers of doc/devices.md.
#pragma once

#include <atomic>
#include <mutex>
#include <span>
#include <string>
#include <vector>

#include "acquisition/longest_silence.h"
#include "acquisition/modbus_link.h"
#include "acquisition/robot.h"

namespace sixdial::acquisition {

/// Joint values on the wire are int32; what does not fit is refused as unreachable.
inline constexpr double kRadPerCount = 1e-8;
inline constexpr double kMmPerCount = 1e-5;
/// So many joints fit into one request.
inline constexpr std::size_t kMostModbusJoints = 60;

/// "modbus-tcp://host:port?unit=1&timeout_ms=300&quiet_ms=1000".
[[nodiscard]] tl::expected<ModbusConnection, std::string> parse_modbus_robot(
    std::string_view text);

/// Two joints that turn: the map that controllers of a five-bar have.
[[nodiscard]] std::vector<RobotJoint> two_turning_joints();

/// The controller of doc/devices.md. Any thread: one exchange at a time.
class ModbusRobot final : public RobotPort {
 public:
  /// `clock` must outlive the robot.
  ModbusRobot(
      const ModbusConnection& connection, Clock& clock,
      std::span<const RobotJoint> joints = two_turning_joints());
  [[nodiscard]] tl::expected<RobotState, RobotFault> state(
      const std::stop_token& stop) override;
  [[nodiscard]] tl::expected<RobotState, RobotFault> move_to(
      const Eigen::VectorXd& q, std::chrono::milliseconds timeout,
      const std::stop_token& stop) override;
  [[nodiscard]] tl::expected<std::optional<int>, RobotFault> speed(
      const std::stop_token& stop) override;
  [[nodiscard]] tl::expected<void, RobotFault> set_speed(
      int percent, const std::stop_token& stop) override;
  [[nodiscard]] tl::expected<void, RobotFault> halt(const std::stop_token& stop) override;
  [[nodiscard]] std::chrono::milliseconds silent_for() const override {
    return silence_.lasts(clock_);
  }
  [[nodiscard]] LinkState link_state() const;

 private:
  tl::expected<Words, Fault> read(
      int function, int address, int count, const std::stop_token& stop);
  tl::expected<void, Fault> write(int address, const Words& words, const std::stop_token& stop);
  tl::expected<void, RobotFault> start(
      const Eigen::VectorXd& q, std::uint16_t moves_before, const std::stop_token& stop);
  tl::expected<RobotState, RobotFault> wait_in_position(
      std::uint16_t moves_before, DeviceTime deadline, const std::stop_token& stop);

  tl::expected<void, RobotFault> check_joints(const std::stop_token& stop);
  [[nodiscard]] RobotState state_of(const Words& words) const;

  /// Registers: target and actual value of each joint come first, two words each.
  [[nodiscard]] int joints() const { return static_cast<int>(per_count_.size()); }
  [[nodiscard]] int command_register() const { return 2 * joints(); }
  [[nodiscard]] int speed_register() const { return 2 * joints() + 1; }

  std::vector<double> per_count_;  // of each joint [rad, mm]
  std::string unit_word_;          // of the joint values in messages
  std::atomic<bool> joints_checked_;
  int unit_;
  Clock& clock_;
  mutable std::mutex mutex_;
  ModbusLink link_;
  Silence silence_;
};

}  // namespace sixdial::acquisition
