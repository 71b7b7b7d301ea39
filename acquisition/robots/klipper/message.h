// What is said on Klipper's API socket: JSON objects, each ended by the byte 0x03. Pure.
//
//   {"id": 7, "method": "gcode/script", "params": {"script": "G1 X200"}}<0x03>
//   {"id": 7, "error": {"error": "WebRequestError", "message": "Must home axis first"}}<0x03>
//
//   parse_klipper("{\"id\":7,\"result\":{}}")->id;  // 7
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace sixdial::acquisition {

inline constexpr char kKlipperEnd = '\x03';
/// Answers to what is asked here have less than 2 kB.
inline constexpr std::size_t kLongestKlipperMessage = std::size_t{64} * 1024;
/// Positions that it tells begin with these.
inline constexpr std::string_view kKlipperAxes = "XYZ";

/// Requests, with their end.
[[nodiscard]] std::string klipper_info_request(std::int64_t id);
[[nodiscard]] std::string klipper_status_request(std::int64_t id);
[[nodiscard]] std::string klipper_script_request(std::int64_t id, std::string_view script);

/// Where the machine stands, in deg or mm. All lists begin with X, Y, Z.
struct KlipperStatus {
  std::string state{};    // "ready", "startup", "shutdown", "error"; empty: not told
  std::string message{};  // for people, first line
  std::string homed{};    // "xyz": axes that were homed
  std::vector<double> low{}, high{};  // travel, in the machine's coordinates
  std::vector<double> live{};         // in the machine's coordinates
  double velocity = 0.0;              // per second
  std::string print{};                // "printing": it runs a file; empty: it cannot
  std::vector<double> planned{};      // where the moves end, in the machine's coordinates
  std::vector<double> commanded{};    // ... in those of commands
};

struct KlipperMessage {
  std::optional<std::int64_t> id{};    // empty: nobody asked
  std::optional<std::string> error{};  // in Klipper's words, on one line
  KlipperStatus status{};
};

/// One message without its end. Empty: no message of Klipper's, or with figures that are none.
[[nodiscard]] std::optional<KlipperMessage> parse_klipper(std::string_view text);

}  // namespace sixdial::acquisition
