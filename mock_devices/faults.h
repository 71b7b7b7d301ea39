// Faults on order: which dial is to misbehave how, for how many replies or how long.
// Thread-safe.
#pragma once

#include <chrono>
#include <mutex>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace sixdial::mock_devices {

enum class Fault {
  kSilent,           // no reply
  kLate,             // the reply comes `amount` wall seconds late
  kTruncated,        // the reply's last bytes are missing
  kStrayLf,          // a line feed after the reply that nobody asked for
  kErrorLine,        // the dialect's error reply; `amount` chooses the number
  kBusy,             // the dialect's busy reply
  kWrongChannel,     // the next dial's reading under its own name
  kInch,             // the display was switched to inches
  kFrozen,           // the display holds its value
  kUnsolicitedLine,  // the key is pressed: a line without a question, and the display holds
  kPowerOnLine,      // the dial is switched off and on: its greeting
  kLowBattery,
  kZeroPressed,  // the present value becomes zero, until the faults are cleared
  kHangUp,       // the line goes away for `amount` wall seconds, then comes back
  kNoiseByte,    // one byte of the reply is another
  kCrcError,     // Modbus RTU: wrong CRC; TCP: wrong transaction number
  kWrongUnitId,  // Modbus: the reply names another unit
  kException,    // Modbus: exception `amount`, 4 if not given
};
struct FaultName {
  Fault fault;
  std::string_view name;  // "stray_lf"
};
[[nodiscard]] std::span<const FaultName> fault_names();
[[nodiscard]] std::string_view to_string(Fault fault);
[[nodiscard]] std::optional<Fault> fault_from(std::string_view name);

struct FaultOrder {
  Fault fault = Fault::kSilent;
  int count = 1;            // replies; 0: as long as `duration_s` says, which 0 makes for ever
  double duration_s = 0.0;  // wall seconds
  std::optional<double> amount{};
  std::string connection{};  // "modbus-tcp", "mux10", "sylvac", ...; empty: whichever asks next
};

class FaultBook {
 public:
  using Clock = std::chrono::steady_clock;

  void order(std::size_t dial, const FaultOrder& order);
  /// The order in force for a dial on a connection, counting one reply off it.
  [[nodiscard]] std::optional<FaultOrder> take(
      std::size_t dial, Fault fault, std::string_view connection);
  /// The same without counting.
  [[nodiscard]] std::optional<FaultOrder> peek(
      std::size_t dial, Fault fault, std::string_view connection) const;
  void clear();

 private:
  struct Entry {
    std::size_t dial;
    FaultOrder order;
    Clock::time_point until;
    bool timed;
  };
  [[nodiscard]] std::vector<Entry>::iterator find(
      std::size_t dial, Fault fault, std::string_view connection) const;
  mutable std::mutex mutex_;
  mutable std::vector<Entry> entries_;
};

}  // namespace sixdial::mock_devices
