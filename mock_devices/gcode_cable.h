// The cable of a mock machine that takes G-code: one line that its clients share. Whoever says
// something, the machine hears it; what it says, each of them gets.
#pragma once

#include <map>
#include <string>
#include <string_view>

#include "mock_devices/gcode_controller.h"
#include "mock_devices/machine_socket.h"

namespace sixdial::mock_devices {

class GcodeCable final : public SocketMachine {
 public:
  explicit GcodeCable(const GcodeMachine& machine) : machine_(machine) {}

  void connected(int client, double time_s) override;
  void receive(int client, std::string_view bytes, double time_s) override;
  [[nodiscard]] std::string due(int client, double time_s) override;
  void gone(int client) override;

  [[nodiscard]] GcodeController& machine() { return machine_; }
  [[nodiscard]] const GcodeController& machine() const { return machine_; }

 private:
  void say_what_is_due(double time_s);

  GcodeController machine_;
  std::map<int, std::string> out_;  // to each client
};

}  // namespace sixdial::mock_devices
