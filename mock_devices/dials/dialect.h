// What the makers' dials say on a serial line. One file a dialect, one row of data each; the
// twin of acquisition/dials/, written from the makers' formats alone (spec 5).
#pragma once

#include <cstddef>
#include <optional>
#include <span>
#include <string>
#include <string_view>

#include "mock_devices/faults.h"

namespace sixdial::mock_devices {

struct LineSettings {
  int baud;
  int data_bits;
  char parity;  // 'N', 'E', 'O'
  int stop_bits;
  /// Seconds that one character takes.
  [[nodiscard]] constexpr double character_s() const {
    return (1.0 + data_bits + (parity == 'N' ? 0 : 1) + stop_bits) / baud;
  }
};

/// What a dial's display shows, as its line may tell it.
struct ShownDial {
  double value = 0.0;  // in the unit below
  bool inch = false;
  bool in_contact = false;
  bool at_travel_end = false;
  bool moving_fast = false;  // no valid value just now
  bool low_battery = false;
};

/// The dials behind a port, as a dialect sees them.
class Panel {
 public:
  Panel() = default;
  Panel(const Panel&) = delete;
  Panel& operator=(const Panel&) = delete;
  virtual ~Panel() = default;
  [[nodiscard]] virtual std::size_t dial_count() const = 0;
  [[nodiscard]] virtual ShownDial show(std::size_t dial) = 0;
  /// A fault that was ordered for this reply.
  [[nodiscard]] virtual std::optional<FaultOrder> take(std::size_t dial, Fault fault) = 0;
  virtual void set_inch(std::size_t dial, bool inch) = 0;
  virtual void set_hold(std::size_t dial, bool hold) = 0;
  [[nodiscard]] virtual std::uint16_t scan() = 0;
};

struct Reply {
  std::string bytes;       // empty: none
  std::size_t dial = 0;    // whose faults apply
  bool all_dials = false;  // one reply for all: everybody's faults apply
};

struct Dialect {
  std::string_view name;
  LineSettings line;
  double latency_s;      // from the request's last character to the reply's first
  bool shared;           // one port for all dials, else a cable each
  double longest_gap_s;  // a longer pause inside a request drops what came before; 0: none
  /// Takes one whole request off the front of the buffer.
  std::optional<std::string> (*take_request)(std::string& buffer);
  Reply (*answer)(std::string_view request, std::size_t own_dial, Panel& panel);
  /// The line that comes when the dial's key is pressed; empty if it has none.
  std::string (*key_pressed)(std::size_t dial, Panel& panel);
  /// The line after switching on; empty if there is none.
  std::string (*power_on)(std::size_t dial);
};

extern const Dialect kSylvac;
extern const Dialect kMahr;
extern const Dialect kMux10;
extern const Dialect kMw;
extern const Dialect kModbusRtu;

/// All of them.
[[nodiscard]] std::span<const Dialect* const> dialects();
[[nodiscard]] const Dialect* find_dialect(std::string_view name);

/// Up to a carriage return or line feed, which is removed; empty lines are passed over.
[[nodiscard]] std::optional<std::string> take_line(std::string& buffer);
/// "+012.345": sign, `width` characters with the point, `decimals` of them behind it. Never
/// "-0".
[[nodiscard]] std::string signed_number(double value, int width, int decimals);
/// Upper case, blanks removed.
[[nodiscard]] std::string plain_command(std::string_view request);

}  // namespace sixdial::mock_devices
