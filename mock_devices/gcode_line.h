// The cable of a mock machine that takes G-code: a TCP port and a pseudo-terminal, served by
// one thread. Mock time runs `speed` times as fast as the wall's.
#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "mock_devices/gcode_controller.h"

namespace sixdial::mock_devices {

struct GcodeLineOptions {
  std::string address = "127.0.0.1";
  std::uint16_t port = 0;            // 0: any free one
  std::filesystem::path pty_link{};  // empty: no pseudo-terminal
  double speed = 1.0;
};

/// Any thread.
class GcodeLineServer {
 public:
  /// Throws std::system_error if a port cannot be opened.
  GcodeLineServer(const GcodeMachine& machine, const GcodeLineOptions& options);
  ~GcodeLineServer();
  GcodeLineServer(const GcodeLineServer&) = delete;
  GcodeLineServer& operator=(const GcodeLineServer&) = delete;

  [[nodiscard]] std::uint16_t port() const;
  [[nodiscard]] std::vector<double> position() const;
  [[nodiscard]] int moves() const;
  /// Looks at or changes the machine at mock time `time_s`.
  void with(const std::function<void(GcodeController& machine, double time_s)>& change);
  /// Closes every client's connection.
  void hang_up();

 private:
  class Loop;
  std::unique_ptr<Loop> loop_;
};

}  // namespace sixdial::mock_devices
