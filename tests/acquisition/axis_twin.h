// Mock machines that take G-code, whatever it is carried in, as the tests of their drivers see
// them, and a robot of three joints there.
#pragma once

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <array>
#include <functional>
#include <memory>
#include <string>
#include <string_view>
#include <thread>
#include <utility>
#include <vector>

#include "acquisition/robot_driver.h"
#include "mock_devices/gcode_cable.h"
#include "mock_devices/klipper_api.h"
#include "mock_devices/linuxcnc_remote.h"
#include "mock_devices/machine_socket.h"
#include "tests/acquisition/wire.h"

namespace sixdial::test {

inline const std::vector<acquisition::RobotJoint> kAxisJoints{
    {"q1", true}, {"q2", true}, {"q3", false}};

inline std::unique_ptr<acquisition::RobotPort> opened(
    const std::string& connection, acquisition::Clock& clock) {
  const auto parsed = acquisition::parse_robot_connection(connection, kAxisJoints);
  EXPECT_TRUE(parsed) << parsed.error();
  return parsed.value().open({.clock = clock});
}
/// Why a connection string cannot be used; empty: it can.
inline std::string refusal(std::string_view connection) {
  const auto parsed = acquisition::parse_robot_connection(connection, kAxisJoints);
  return parsed ? "" : parsed.error();
}

struct TwinOptions {
  double low = -180.0, high = 180.0;
  double offset = 0.0;  // machine less work coordinates
};

class AxisTwin {
 public:
  virtual ~AxisTwin() = default;
  /// In the coordinates of commands.
  [[nodiscard]] std::vector<double> position() const {
    std::vector<double> at;
    socket_->with([&](double time_s) { at = position_at(time_s); });
    return at;
  }
  void move_by_hand(const std::vector<double>& to, double speed) {
    socket_->with([&](double time_s) { order(to, speed, time_s); });
  }
  /// Acts once the third axis is beyond `value`.
  [[nodiscard]] std::jthread once_beyond(double value, std::function<void()> act) {
    return std::jthread([this, value, act = std::move(act)] {
      EXPECT_TRUE(eventually([&] { return position()[2] > value; }));
      act();
    });
  }
  [[nodiscard]] mock_devices::MachineSocket& socket() const { return *socket_; }
  /// Of a rig file; options as in "?feed=600".
  [[nodiscard]] virtual std::string connection(const std::string& options) const = 0;
  [[nodiscard]] bool stands() const {
    const auto before = position();
    std::this_thread::sleep_for(std::chrono::milliseconds(150));
    return before == position();
  }

 protected:
  virtual std::vector<double> position_at(double time_s) const = 0;
  virtual void order(const std::vector<double>& to, double speed, double time_s) = 0;
  std::unique_ptr<mock_devices::MachineSocket> socket_;
};

class KlipperTwin final : public AxisTwin {
 public:
  KlipperTwin(mock_devices::KlipperMachine machine, std::string path)
      : api(std::move(machine)), path_(std::move(path)) {
    socket_ = std::make_unique<mock_devices::MachineSocket>(
        api, mock_devices::MachineSocketOptions{.unix_socket = path_});
  }
  ~KlipperTwin() override { socket_.reset(); }
  [[nodiscard]] std::string connection(const std::string& options) const override {
    return "klipper:" + path_ + options;
  }

  mock_devices::KlipperApi api;  // looked at by socket().with() only

 protected:
  std::vector<double> position_at(double time_s) const override { return api.position(time_s); }
  void order(const std::vector<double>& to, double speed, double time_s) override {
    api.move_by_hand(to, speed, time_s);
  }

 private:
  std::string path_;
};

class LinuxCncTwin final : public AxisTwin {
 public:
  explicit LinuxCncTwin(mock_devices::LinuxCncMachine machine) : remote(std::move(machine)) {
    socket_ = std::make_unique<mock_devices::MachineSocket>(
        remote, mock_devices::MachineSocketOptions{});
  }
  ~LinuxCncTwin() override { socket_.reset(); }
  [[nodiscard]] std::string connection(const std::string& options) const override {
    return fmt::format("linuxcnc:127.0.0.1:{}{}", socket_->port(), options);
  }

  mock_devices::LinuxCncRemote remote;  // looked at by socket().with() only

 protected:
  std::vector<double> position_at(double time_s) const override {
    return remote.position(time_s);
  }
  void order(const std::vector<double>& to, double speed, double time_s) override {
    std::vector<double> six = to;
    six.resize(6, 0.0);
    remote.move_by_hand(six, speed, time_s);
  }
};

/// Grbl, Marlin or Klipper on a line.
class GcodeTwin final : public AxisTwin {
 public:
  /// `pty_link`: leads to its serial line; empty: it has none.
  explicit GcodeTwin(
      const mock_devices::GcodeMachine& machine, const std::string& pty_link = "")
      : cable(machine), dialect_(kDialects.at(static_cast<std::size_t>(machine.firmware))) {
    socket_ = std::make_unique<mock_devices::MachineSocket>(
        cable, mock_devices::MachineSocketOptions{.pty_link = pty_link});
  }
  ~GcodeTwin() override { socket_.reset(); }
  [[nodiscard]] std::string connection(const std::string& options) const override {
    std::string text =
        fmt::format("gcode-tcp:127.0.0.1:{}?dialect={}", socket_->port(), dialect_);
    if (!options.empty()) text += "&" + options.substr(1);
    return text;
  }

  mock_devices::GcodeCable cable;  // looked at by socket().with() only

 protected:
  std::vector<double> position_at(double time_s) const override {
    return cable.machine().position(time_s);
  }
  void order(const std::vector<double>& to, double speed, double time_s) override {
    cable.machine().receive(
        fmt::format("G1 X{} Y{} Z{} F{}\n", to[0], to[1], to[2], 60.0 * speed), time_s);
  }

 private:
  static constexpr std::array kDialects{
      "grbl", "marlin", "klipper"};  // as GcodeFirmware has them
  const char* dialect_;
};

}  // namespace sixdial::test
