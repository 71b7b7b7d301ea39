// All cables of the mock rig, served by one thread: two Modbus TCP servers and dials on
// pseudo-terminals, each paced as its line would be, at mock speed.
#pragma once

#include <cstdint>
#include <filesystem>
#include <map>
#include <memory>
#include <string>
#include <vector>

#include "mock_devices/bench.h"

namespace sixdial::mock_devices {

struct WireOptions {
  std::string address = "127.0.0.1";
  std::uint16_t dial_port = 0;  // 0: any free one
  std::uint16_t robot_port = 0;
  std::uint8_t unit = 1;                // 255 is answered too
  std::filesystem::path pty_directory;  // empty: no serial lines
  std::vector<std::string> dialects{"mux10", "sylvac"};
  int rtu_baud = 19200;  // of the gauge box on modbus_rtu
  double speed = 1.0;    // of the mock clock
};

/// Name of the fault-order connection of the gauge box on TCP.
inline constexpr const char* kTcpConnection = "modbus-tcp";

class Wire {
 public:
  /// Opens every port and starts the thread; throws std::system_error naming the port that
  /// could not be opened. The bench must outlive the wire.
  Wire(Bench& bench, const WireOptions& options);
  ~Wire();
  Wire(const Wire&) = delete;
  Wire& operator=(const Wire&) = delete;

  [[nodiscard]] std::uint16_t dial_port() const;
  [[nodiscard]] std::uint16_t robot_port() const;
  /// Stable links to the pseudo-terminals: "mux10", "sylvac_A", ...
  [[nodiscard]] const std::map<std::string, std::filesystem::path>& serial() const;
  /// Lets the thread look at newly ordered faults.
  void wake();

 private:
  class Loop;
  std::unique_ptr<Loop> loop_;
};

}  // namespace sixdial::mock_devices
