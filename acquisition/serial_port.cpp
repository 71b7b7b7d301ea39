#include "acquisition/serial_port.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <libserialport.h>
#include <poll.h>
#include <sys/file.h>
#include <sys/ioctl.h>
#include <sys/select.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstring>
#include <filesystem>

namespace sixdial::acquisition {
namespace {

using std::chrono::milliseconds;
using std::chrono::nanoseconds;
using std::chrono::steady_clock;

// A stop is seen within this; an unplugged adapter at once.
constexpr milliseconds kSlice{50};
constexpr std::size_t kLongestFrame = 256;
constexpr int kSpareDescriptors = 8;

struct FreeConfig {
  void operator()(sp_port_config* config) const { sp_free_config(config); }
};

std::string last_error() {
  char* text = sp_last_error_message();
  std::string result = text == nullptr ? "" : text;
  sp_free_error_message(text);
  return result;
}

Fault disconnected(std::string detail) {
  return {.kind = FaultKind::kDisconnected, .detail = std::move(detail)};
}

sp_parity parity_of(Parity parity) {
  switch (parity) {
    case Parity::kEven:
      return SP_PARITY_EVEN;
    case Parity::kOdd:
      return SP_PARITY_ODD;
    case Parity::kNone:
      break;
  }
  return SP_PARITY_NONE;
}

bool configure(sp_port* port, const LineSettings& line) {
  sp_port_config* raw = nullptr;
  if (sp_new_config(&raw) != SP_OK) return false;
  const std::unique_ptr<sp_port_config, FreeConfig> config(raw);
  return sp_set_config_baudrate(raw, line.baud) == SP_OK &&
         sp_set_config_bits(raw, line.data_bits) == SP_OK &&
         sp_set_config_parity(raw, parity_of(line.parity)) == SP_OK &&
         sp_set_config_stopbits(raw, line.stop_bits) == SP_OK &&
         sp_set_config_flowcontrol(raw, SP_FLOWCONTROL_NONE) == SP_OK &&
         sp_set_config_rts(raw, line.rts ? SP_RTS_ON : SP_RTS_OFF) == SP_OK &&
         sp_set_config_dtr(raw, line.dtr ? SP_DTR_ON : SP_DTR_OFF) == SP_OK &&
         sp_set_config(port, raw) == SP_OK;
}

}  // namespace

bool descriptors_left() {
  const int lowest = ::open("/dev/null", O_RDONLY | O_CLOEXEC);
  if (lowest < 0) return false;
  ::close(lowest);
  return lowest < FD_SETSIZE - kSpareDescriptors;
}

tl::expected<void, Fault> lock_device(int handle, const std::string& device) {
  // TIOCEXCL does not stop root, flock does not stop strangers: both.
  if (::flock(handle, LOCK_EX | LOCK_NB) != 0) {
    return tl::unexpected(disconnected(fmt::format("{} is in use by another program", device)));
  }
  ::ioctl(handle, TIOCEXCL);
  return {};
}

void SerialPort::Close::operator()(sp_port* port) const {
  sp_close(port);
  sp_free_port(port);
}

SerialPort::SerialPort(std::unique_ptr<sp_port, Close> port, int handle, std::string resolved)
    : port_(std::move(port)), handle_(handle), resolved_(std::move(resolved)) {}
SerialPort::SerialPort(SerialPort&&) noexcept = default;
SerialPort& SerialPort::operator=(SerialPort&&) noexcept = default;
SerialPort::~SerialPort() = default;

tl::expected<SerialPort, PortFault> SerialPort::open(
    const std::string& device, const LineSettings& line) {
  if (!descriptors_left()) {
    return tl::unexpected(PortFault{disconnected("this process has too many files open")});
  }
  std::error_code error;
  const std::string resolved = std::filesystem::canonical(device, error).string();
  if (error) {
    return tl::unexpected(PortFault{
        disconnected(fmt::format("{}: {}", device, error.message())),
        error == std::errc::permission_denied ? PortTrouble::kNoRights : PortTrouble::kOther});
  }
  sp_port* raw = nullptr;
  if (sp_get_port_by_name(resolved.c_str(), &raw) != SP_OK) {
    return tl::unexpected(
        PortFault{disconnected(fmt::format("{} is no serial port", resolved))});
  }
  std::unique_ptr<sp_port, Close> port(raw);
  if (sp_open(raw, SP_MODE_READ_WRITE) != SP_OK) {
    const bool no_rights = sp_last_error_code() == EACCES;
    return tl::unexpected(PortFault{
        disconnected(fmt::format("{} cannot be opened: {}", resolved, last_error())),
        no_rights ? PortTrouble::kNoRights : PortTrouble::kOther});
  }
  int handle = -1;
  if (sp_get_port_handle(raw, &handle) != SP_OK) {
    return tl::unexpected(
        PortFault{disconnected(fmt::format("{} has no descriptor", resolved))});
  }
  if (const auto locked = lock_device(handle, resolved); !locked) {
    return tl::unexpected(PortFault{locked.error(), PortTrouble::kInUse});
  }
  if (!configure(raw, line)) {
    return tl::unexpected(PortFault{
        disconnected(fmt::format("{} refuses its line settings: {}", resolved, last_error()))});
  }
  sp_flush(raw, SP_BUF_BOTH);
  return SerialPort(std::move(port), handle, resolved);
}

tl::expected<void, Fault> SerialPort::write(std::string_view bytes, nanoseconds timeout) {
  const auto timeout_ms =
      std::max<std::int64_t>(1, std::chrono::duration_cast<milliseconds>(timeout).count());
  // A count comes back as an enum that has no such value: int, at once.
  const int sent = sp_blocking_write(
      port_.get(), bytes.data(), bytes.size(), static_cast<unsigned int>(timeout_ms));
  if (sent < 0) return tl::unexpected(disconnected(last_error()));
  if (static_cast<std::size_t>(sent) != bytes.size()) {
    if (sp_output_waiting(port_.get()) < 0) return tl::unexpected(disconnected(last_error()));
    return tl::unexpected(Fault{FaultKind::kTimeout, "the line takes no bytes"});
  }
  return {};
}

tl::expected<std::size_t, Fault> SerialPort::receive(
    char* bytes, std::size_t most, steady_clock::time_point deadline,
    const std::stop_token& stop) {
  for (;;) {
    const auto left = std::chrono::ceil<milliseconds>(deadline - steady_clock::now());
    const milliseconds wait = std::clamp(left, milliseconds{0}, milliseconds{kSlice});
    // poll() rather than libserialport's own wait: that one spins on a line that hung up.
    pollfd watched{.fd = handle_, .events = POLLIN, .revents = 0};
    const int ready = ::poll(&watched, 1, static_cast<int>(wait.count()));
    if (ready < 0 && errno != EINTR) {
      return tl::unexpected(disconnected(std::strerror(errno)));
    }
    if (ready > 0) {
      const int got = sp_nonblocking_read(port_.get(), bytes, most);
      if (got < 0) return tl::unexpected(disconnected(last_error()));
      if (got > 0) return static_cast<std::size_t>(got);
      if ((watched.revents & (POLLHUP | POLLERR | POLLNVAL)) != 0) {
        return tl::unexpected(disconnected("the line hung up"));
      }
    }
    // An empty read: a negative count of waiting bytes is an unplugged adapter.
    if (sp_input_waiting(port_.get()) < 0) return tl::unexpected(disconnected(last_error()));
    if (stop.stop_requested() || steady_clock::now() >= deadline) return std::size_t{0};
  }
}

tl::expected<std::string, Fault> SerialPort::read_frame(
    std::string_view end, steady_clock::time_point deadline, const std::stop_token& stop) {
  std::string got = std::exchange(pending_, {});
  for (;;) {
    if (const std::size_t place = got.find(end); place != std::string::npos) {
      pending_ = got.substr(place + end.size());
      got.resize(place + end.size());
      return got;
    }
    if (got.size() > kLongestFrame) {
      return tl::unexpected(Fault{
          FaultKind::kBadFrame, fmt::format("{} bytes without an end of line", got.size())});
    }
    std::array<char, 128> bytes{};
    const auto count = receive(bytes.data(), bytes.size(), deadline, stop);
    if (!count) return tl::unexpected(count.error());
    if (*count == 0) {
      if (got.empty()) return tl::unexpected(Fault{FaultKind::kTimeout, "no answer"});
      return tl::unexpected(
          Fault{FaultKind::kBadFrame, fmt::format("{} has no end of line", printable(got))});
    }
    got.append(bytes.data(), *count);
  }
}

tl::expected<std::string, Fault> SerialPort::read_some(
    steady_clock::time_point deadline, const std::stop_token& stop) {
  if (!pending_.empty()) return std::exchange(pending_, {});
  std::array<char, 256> bytes{};
  return receive(bytes.data(), bytes.size(), deadline, stop).map([&](std::size_t count) {
    return std::string(bytes.data(), count);
  });
}

tl::expected<std::string, Fault> SerialPort::drain_until(
    steady_clock::time_point deadline, const std::stop_token& stop) {
  std::string dropped = std::exchange(pending_, {});
  for (;;) {
    std::array<char, 128> bytes{};
    const auto count = receive(bytes.data(), bytes.size(), deadline, stop);
    if (!count) return tl::unexpected(count.error());
    if (*count == 0) return dropped;
    if (dropped.size() < kLongestFrame) dropped.append(bytes.data(), *count);
    // A line that never falls silent must not hold us here.
    if (stop.stop_requested() || steady_clock::now() >= deadline + kSlice) return dropped;
  }
}

}  // namespace sixdial::acquisition
