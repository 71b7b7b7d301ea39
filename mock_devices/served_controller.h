// A mock robot's controller as one of the machines that take G-code, Klipper's API socket or
// LinuxCNC's remote, beside the one with registers: the machine moves its axes, and the mock
// robot's joints follow them. Degrees on the cable, radians on the bench.
//
//   ServedController served(bench, {.name = "grbl"});
//   served.connection();  // "gcode-tcp:127.0.0.1:40123?dialect=grbl"
#pragma once

#include <cstdint>
#include <filesystem>
#include <memory>
#include <span>
#include <string>
#include <string_view>

#include "mock_devices/bench.h"

namespace sixdial::mock_devices {

/// "grbl", "marlin", "klipper", "klipper-socket", "linuxcnc".
[[nodiscard]] std::span<const std::string_view> served_controllers();

struct ServedControllerOptions {
  std::string name;
  std::string address = "127.0.0.1";
  std::uint16_t port = 0;  // 0: any free one
  /// Of klipper-socket its socket; of grbl, marlin and klipper a link to a pseudo-terminal
  /// beside the port. Empty: a socket in the temporary folder; no pseudo-terminal.
  std::filesystem::path link{};
  double speed = 1.0;  // of the mock clock
};

/// Any thread.
class ServedController {
 public:
  /// Throws std::invalid_argument for an unknown name or a robot with more joints than such a
  /// machine has axes, std::system_error if its port or socket cannot be opened. The bench must
  /// outlive it.
  ServedController(Bench& bench, const ServedControllerOptions& options);
  ~ServedController();
  ServedController(const ServedController&) = delete;
  ServedController& operator=(const ServedController&) = delete;

  /// For `connection` of [robot] in rig.toml.
  [[nodiscard]] std::string connection() const;
  /// By its pseudo-terminal; empty: it has none.
  [[nodiscard]] std::string serial_connection() const;
  /// 0: it has a socket file.
  [[nodiscard]] std::uint16_t port() const;

 private:
  class Served;
  std::unique_ptr<Served> served_;
};

}  // namespace sixdial::mock_devices
