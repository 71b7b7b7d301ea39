// The dialect a dial speaks on a serial line: what to ask, how the line is set, and a pure
// parser from the bytes of one answer to a value with its unit. One file a dialect in dials/; a
// new one is such a file and a row in dial_protocol.cpp, or a row that is made at run time:
//
//   static const DialProtocol mine{.name = "mine", .frame_end = "\r", .request = ask, ...};
//   add_dial_protocol(mine);  // connection = "serial:/dev/...?dialect=mine" works from now on
//
// Example:
//   const DialProtocol& mahr = *find_dial_protocol("mahr");
//   mahr.request(0);  // -> "?\r"
//   mahr.parse("+012.345 mm\r", 0)->value;  // -> 12.345
//   mahr.parse("+012.3", 0).error();  // -> FaultKind::kBadFrame
#pragma once

#include <chrono>
#include <string>
#include <string_view>
#include <tl/expected.hpp>
#include <vector>

#include "acquisition/fault.h"

namespace sixdial::acquisition {

enum class Parity { kNone, kEven, kOdd };

struct LineSettings {
  int baud = 9600;
  int data_bits = 8;
  Parity parity = Parity::kNone;
  int stop_bits = 1;
  bool dtr = true;
  bool rts = true;
};

enum class Unit { kMillimetre, kInch, kUnsaid };

struct DialFrame {
  double value = 0.0;  // in `unit`
  Unit unit = Unit::kUnsaid;
  int decimals = 0;  // digits after the point: the only hint where the unit is unsaid
};

struct DialProtocol {
  std::string_view name;  // dialect=...
  LineSettings line;
  std::string_view frame_end;
  int channels = 0;  // of a multiplexer; 0: one dial a cable
  /// How long to wait for an answer [device time].
  std::chrono::milliseconds timeout{300};
  /// Asks the dial who it is; empty where the dialect has no such question.
  std::string_view identity_request;
  /// Asks for the battery; empty where the dialect has no such question. `low_battery` is its
  /// whole answer when it needs a new one.
  std::string_view battery_request{};
  std::string_view low_battery{};
  std::string (*request)(int channel) = nullptr;
  /// Whole-line match of one frame, its end included. `channel` is the one that was asked.
  tl::expected<DialFrame, FaultKind> (*parse)(std::string_view frame, int channel) noexcept =
      nullptr;
  /// What a code means that comes instead of a value, such as "911"; empty: it is none. Null:
  /// this dialect has no codes.
  std::string_view (*says)(std::string_view frame) noexcept = nullptr;
  /// A line that a dial sends by itself (power-on) and that answers no question.
  bool (*unasked)(std::string_view frame) noexcept = nullptr;

  // For people: the example rig file and the table of doc/devices.md (dial_examples.h).
  std::string_view maker{};   // "Mahr"
  std::string_view wiring{};  // six of what: "dials with a MarConnect RS232 cable each"
  std::string_view advice{};  // what to set at the dial or to know of it; lines
  /// The cable's name by udev and the first one's serial number.
  std::string_view example_port{};
  int example_serial = 1;
};

/// All dialects: those of dials/, then those that were added.
[[nodiscard]] std::vector<const DialProtocol*> dial_protocols();
/// Adds a row that stays where it is as long as the program runs. Throws std::invalid_argument
/// if its name is taken or empty, or it cannot ask, read or end a line. Any thread.
void add_dial_protocol(const DialProtocol& protocol);
/// nullptr if there is none of that name.
[[nodiscard]] const DialProtocol* find_dial_protocol(std::string_view name);

/// Value in mm. Inch is refused (its steps are coarser than the rig's accuracy), also where the
/// dialect does not say the unit but more decimals come than a dial of this resolution shows in
/// mm. Outside -0.5 .. travel + 0.5 mm is kRange.
[[nodiscard]] tl::expected<double, FaultKind> displacement_mm(
    const DialFrame& frame, double resolution_mm, double travel_mm) noexcept;
/// The same range check for values that come in mm.
[[nodiscard]] bool within_travel(double value_mm, double travel_mm) noexcept;

}  // namespace sixdial::acquisition
