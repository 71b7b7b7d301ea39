// Connection strings of a rig file: where a dial is plugged in, and how to talk to it.
//
//   serial:/dev/serial/by-id/...?dialect=sylvac
//   serial:/dev/ttyUSB0?dialect=mux10&channel=3
//   modbus-tcp://host:port?unit=1&index=0&base=0&count=6&scale=0.001&word_order=high
//                         &function=4&format=int32&status=100&counter=106
//   modbus-rtu:/dev/ttyUSB1?baud=19200&parity=N&unit=1&...
//
// The robot's: acquisition/robot_driver.h. Everywhere: timeout_ms (device time, 20..300) and,
// on Modbus, quiet_ms (how long the slowest device may be late).
#pragma once

#include <chrono>
#include <optional>
#include <string>
#include <string_view>
#include <tl/expected.hpp>
#include <variant>

#include "acquisition/dial_protocol.h"

namespace sixdial::acquisition {

struct ModbusTcpEndpoint {
  std::string host;
  int port = 502;
  friend bool operator==(const ModbusTcpEndpoint&, const ModbusTcpEndpoint&) = default;
};

struct ModbusRtuEndpoint {
  std::string device;
  int baud = 19200;
  Parity parity = Parity::kNone;
  int stop_bits = 1;
  friend bool operator==(const ModbusRtuEndpoint&, const ModbusRtuEndpoint&) = default;
};

using ModbusEndpoint = std::variant<ModbusTcpEndpoint, ModbusRtuEndpoint>;

enum class WordOrder { kHighFirst, kLowFirst };
enum class RegisterFormat { kInt32, kFloat32, kInt16 };

/// Where the values are in a gauge box.
struct ModbusMap {
  int unit = 1;
  int function = 4;  // 3 holding, 4 input registers
  int base = 0;
  int count = 0;         // values read in one request; 0: as many as the rig has dials there
  double scale = 0.001;  // mm per count
  WordOrder word_order = WordOrder::kHighFirst;
  RegisterFormat format = RegisterFormat::kInt32;
  int status = 100;   // one word a dial; -1: none
  int counter = 106;  // counts scans; -1: none
  friend bool operator==(const ModbusMap&, const ModbusMap&) = default;
};

struct SerialConnection {
  std::string device;  // as written; may be a link
  const DialProtocol* protocol = nullptr;
  int channel = 0;
  std::chrono::milliseconds timeout{300};
};

struct ModbusConnection {
  ModbusEndpoint endpoint;
  ModbusMap map;
  std::optional<int> index;  // place of this dial in the map; default: by the rig's order
  std::chrono::milliseconds timeout{300};
  std::chrono::milliseconds quiet{1000};  // after an error: longer than the slowest device
};

using DialConnection = std::variant<SerialConnection, ModbusConnection>;

/// The error is one sentence that names what is wrong and the nearest thing that would be
/// right.
[[nodiscard]] tl::expected<DialConnection, std::string> parse_dial_connection(
    std::string_view text);

/// "127.0.0.1:1502", "/dev/ttyUSB0".
[[nodiscard]] std::string name_of(const ModbusEndpoint& endpoint);

}  // namespace sixdial::acquisition
