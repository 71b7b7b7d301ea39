// A serial port by libserialport: opened by its stable name, locked, read line by line against
// one deadline. Tells an unplugged adapter from a silent dial.
//
// Seen on the bench (libserialport 0.1.1): it takes an unplugged adapter for a time-out and
// spins; it takes no lock; links under /dev/serial/by-id are not resolved; a time-out of 0 is
// for ever; a descriptor above 1023 aborts the process.
#pragma once

#include <chrono>
#include <memory>
#include <stop_token>
#include <string>
#include <string_view>
#include <tl/expected.hpp>

#include "acquisition/dial_protocol.h"
#include "acquisition/fault.h"

struct sp_port;

namespace sixdial::acquisition {

/// Why a port cannot be opened, as far as a person can do something about it.
enum class PortTrouble {
  kInUse,     // another program has it
  kNoRights,  // this user may not open it
  kOther,     // no such port, or it refuses its settings
};
struct PortFault : Fault {
  PortTrouble trouble = PortTrouble::kOther;
};

/// One thread at a time. Times are on the wall.
class SerialPort {
 public:
  [[nodiscard]] static tl::expected<SerialPort, PortFault> open(
      const std::string& device, const LineSettings& line);
  SerialPort(SerialPort&&) noexcept;
  SerialPort& operator=(SerialPort&&) noexcept;
  ~SerialPort();

  [[nodiscard]] tl::expected<void, Fault> write(
      std::string_view bytes, std::chrono::nanoseconds timeout);
  /// Bytes up to and with `end`. kTimeout also if stopped; kBadFrame if some bytes came but no
  /// end, or more than 256 bytes.
  [[nodiscard]] tl::expected<std::string, Fault> read_frame(
      std::string_view end, std::chrono::steady_clock::time_point deadline,
      const std::stop_token& stop);
  /// What comes next, of any length; empty: nothing came by the deadline, or stopped.
  [[nodiscard]] tl::expected<std::string, Fault> read_some(
      std::chrono::steady_clock::time_point deadline, const std::stop_token& stop);
  /// Reads and drops whatever comes until then; at least what is there now.
  [[nodiscard]] tl::expected<std::string, Fault> drain_until(
      std::chrono::steady_clock::time_point deadline, const std::stop_token& stop);

  /// The real device behind the link it was opened by.
  [[nodiscard]] const std::string& resolved() const { return resolved_; }

 private:
  struct Close {
    void operator()(sp_port* port) const;
  };
  explicit SerialPort(std::unique_ptr<sp_port, Close> port, int handle, std::string resolved);
  /// What is there, waiting at most until the deadline for the first byte; empty if nothing
  /// came.
  tl::expected<std::size_t, Fault> receive(
      char* bytes, std::size_t most, std::chrono::steady_clock::time_point deadline,
      const std::stop_token& stop);

  std::unique_ptr<sp_port, Close> port_;
  int handle_ = -1;
  std::string resolved_;
  std::string pending_;  // bytes after the last frame's end
};

/// False if the next descriptor would be one that select() cannot hold.
[[nodiscard]] bool descriptors_left();
/// Takes the device for this process alone (TIOCEXCL and flock); why not, if not.
[[nodiscard]] tl::expected<void, Fault> lock_device(int handle, const std::string& device);

}  // namespace sixdial::acquisition
