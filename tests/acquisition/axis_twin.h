// Mock machines that are spoken to in a protocol of their own, as the tests of their drivers
// see them: one row each.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "mock_devices/klipper_api.h"
#include "mock_devices/linuxcnc_remote.h"
#include "mock_devices/machine_socket.h"
#include "tests/acquisition/wire.h"

namespace sixdial::test {

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
  [[nodiscard]] mock_devices::MachineSocket& socket() const { return *socket_; }
  /// Of a rig file, without options.
  [[nodiscard]] virtual std::string connection() const = 0;
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
  [[nodiscard]] std::string connection() const override { return "klipper:" + path_; }

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
  [[nodiscard]] std::string connection() const override {
    return "linuxcnc:127.0.0.1:" + std::to_string(socket_->port());
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

}  // namespace sixdial::test
