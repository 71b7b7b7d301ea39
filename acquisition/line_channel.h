// Lines of text to and from a device, over a serial port, TCP, or a socket of this machine.
#pragma once

#include <chrono>
#include <memory>
#include <stop_token>
#include <string>
#include <string_view>
#include <tl/expected.hpp>

#include "acquisition/connection.h"
#include "acquisition/dial_protocol.h"
#include "acquisition/fault.h"

namespace sixdial::acquisition {

/// Times are on the wall. One thread reads; write() may be called by another meanwhile.
class LineChannel {
 public:
  virtual ~LineChannel() = default;
  /// kDisconnected: the line is gone; kTimeout: it takes no bytes.
  [[nodiscard]] virtual tl::expected<void, Fault> write(
      std::string_view bytes, std::chrono::nanoseconds timeout) = 0;
  /// The next line without its end, carriage returns and blanks behind it cut. kTimeout: none
  /// came whole, or stopped: what came of it is kept; kBadFrame: too long for one.
  [[nodiscard]] virtual tl::expected<std::string, Fault> read_line(
      std::chrono::steady_clock::time_point deadline, const std::stop_token& stop) = 0;
};

/// No line is longer.
inline constexpr std::size_t kLongestLine = 1024;

/// Waits at most `timeout` for the connection.
[[nodiscard]] tl::expected<std::unique_ptr<LineChannel>, Fault> open_tcp_lines(
    const ModbusTcpEndpoint& endpoint, std::chrono::nanoseconds timeout);
/// A Unix socket of another program on this machine; each of its messages ends with `end` and
/// is no longer than `longest` bytes.
[[nodiscard]] tl::expected<std::unique_ptr<LineChannel>, Fault> open_unix_messages(
    const std::string& path, char end, std::size_t longest, std::chrono::nanoseconds timeout);
[[nodiscard]] tl::expected<std::unique_ptr<LineChannel>, Fault> open_serial_lines(
    const std::string& device, const LineSettings& line);

}  // namespace sixdial::acquisition
