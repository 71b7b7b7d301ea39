#include "acquisition/modbus_link.h"

#include <fmt/format.h>
#include <modbus.h>
#include <sys/socket.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <filesystem>
#include <thread>

#include "acquisition/serial_port.h"

namespace sixdial::acquisition {
namespace {

using std::chrono::microseconds;
using std::chrono::steady_clock;

constexpr std::size_t kMbapHead = 6;  // transaction, protocol, length; then the unit
constexpr std::size_t kCrc = 2;

Fault disconnected(std::string detail) {
  return {.kind = FaultKind::kDisconnected, .detail = std::move(detail)};
}

Fault fault_of_errno(int error) {
  const std::string text = modbus_strerror(error);
  switch (error) {
    case ETIMEDOUT:
      return {FaultKind::kTimeout, "no answer"};
    case EMBBADCRC:
      return {FaultKind::kBadFrame, "wrong checksum"};
    case EMBBADDATA:
    case EMBBADEXC:
    case EMBUNKEXC:
    case EMBMDATA:
      return {FaultKind::kBadFrame, text};
    case EMBBADSLAVE:
      return {FaultKind::kWrongChannel, text};
    case EINPROGRESS:
      return disconnected("the connection was not answered in time");
    default:
      return disconnected(text);
  }
}

char parity_letter(Parity parity) {
  switch (parity) {
    case Parity::kEven:
      return 'E';
    case Parity::kOdd:
      return 'O';
    case Parity::kNone:
      break;
  }
  return 'N';
}

}  // namespace

void ModbusLink::Close::operator()(_modbus* context) const {
  modbus_close(context);
  modbus_free(context);
}

ModbusLink::ModbusLink(
    ModbusEndpoint endpoint, std::chrono::milliseconds timeout, std::chrono::milliseconds quiet,
    Clock& clock)
    : endpoint_(std::move(endpoint)), timeout_(timeout), quiet_(quiet), clock_(clock) {}

ModbusLink::~ModbusLink() = default;

void ModbusLink::close() { context_.reset(); }

tl::expected<void, Fault> ModbusLink::connect(int unit) {
  if (!descriptors_left()) {
    return tl::unexpected(disconnected("this process has too many files open"));
  }
  std::string place;
  if (const auto* tcp = std::get_if<ModbusTcpEndpoint>(&endpoint_)) {
    place = name_of(endpoint_);
    context_.reset(modbus_new_tcp_pi(tcp->host.c_str(), std::to_string(tcp->port).c_str()));
  } else {
    const auto& rtu = std::get<ModbusRtuEndpoint>(endpoint_);
    std::error_code error;
    place = std::filesystem::canonical(rtu.device, error).string();
    if (error) {
      return tl::unexpected(disconnected(fmt::format("{}: {}", rtu.device, error.message())));
    }
    context_.reset(
        modbus_new_rtu(place.c_str(), rtu.baud, parity_letter(rtu.parity), 8, rtu.stop_bits));
  }
  if (!context_) {
    return tl::unexpected(disconnected(fmt::format("{}: {}", place, modbus_strerror(errno))));
  }
  modbus_t* const context = context_.get();
  const auto timeout =
      std::chrono::duration_cast<microseconds>(clock_.wall_timeout(timeout_)).count();
  // The whole reply within the deadline: no second one from byte to byte.
  if (modbus_set_slave(context, unit) != 0 ||
      modbus_set_error_recovery(context, MODBUS_ERROR_RECOVERY_NONE) != 0 ||
      modbus_set_response_timeout(
          context, static_cast<std::uint32_t>(timeout / 1'000'000),
          static_cast<std::uint32_t>(timeout % 1'000'000)) != 0 ||
      modbus_set_byte_timeout(context, 0, 0) != 0) {
    context_.reset();
    return tl::unexpected(disconnected(fmt::format("{}: settings refused", place)));
  }
  if (modbus_connect(context) != 0) {
    const Fault fault = fault_of_errno(errno);
    context_.reset();
    return tl::unexpected(disconnected(fmt::format("{}: {}", place, fault.detail)));
  }
  if (!is_tcp()) {
    const auto locked = lock_device(modbus_get_socket(context), place);
    if (!locked) {
      context_.reset();
      return locked;
    }
    modbus_flush(context);
  }
  ++connections_;
  return {};
}

tl::expected<void, Fault> ModbusLink::ready(int unit, const std::stop_token& stop) {
  if (clock_.monotonic() < health_.next_try()) return tl::unexpected(down_);
  if (quiet_until_) {
    if (!sleep_on_wall(*quiet_until_, stop)) {
      return tl::unexpected(Fault{FaultKind::kTimeout, "stopped"});
    }
    quiet_until_.reset();
    if (context_) modbus_flush(context_.get());
  }
  if (context_) return {};
  const auto connected = connect(unit);
  if (!connected) note(connected.error());
  return connected;
}

// Own head: libmodbus numbers raw requests all the same and ignores who answers.
tl::expected<Bytes, Fault> ModbusLink::exchange_tcp(const Bytes& request) {
  ++transaction_;
  const auto length = static_cast<std::uint16_t>(request.size());
  Bytes frame{
      static_cast<std::uint8_t>(transaction_ >> 8),
      static_cast<std::uint8_t>(transaction_ & 0xff),
      0,
      0,
      static_cast<std::uint8_t>(length >> 8),
      static_cast<std::uint8_t>(length & 0xff)};
  frame.insert(frame.end(), request.begin(), request.end());
  const ssize_t sent =
      ::send(modbus_get_socket(context_.get()), frame.data(), frame.size(), MSG_NOSIGNAL);
  if (sent < 0) {
    const int error = errno;
    if (error == EAGAIN) return tl::unexpected(Fault{FaultKind::kTimeout, "takes no bytes"});
    return tl::unexpected(fault_of_errno(error));
  }
  if (static_cast<std::size_t>(sent) != frame.size()) {
    return tl::unexpected(Fault{FaultKind::kTimeout, "takes no bytes"});
  }
  std::array<std::uint8_t, MODBUS_TCP_MAX_ADU_LENGTH> reply{};
  const int got = modbus_receive_confirmation(context_.get(), reply.data());
  if (got < 0) return tl::unexpected(fault_of_errno(errno));
  const auto size = static_cast<std::size_t>(got);
  if (size <= kMbapHead || reply[2] != 0 || reply[3] != 0) {
    return tl::unexpected(Fault{FaultKind::kBadFrame, "no Modbus TCP head"});
  }
  if ((reply[0] << 8 | reply[1]) != transaction_) {
    return tl::unexpected(Fault{
        FaultKind::kBadFrame,
        fmt::format(
            "answer to request {}, the last was {}", reply[0] << 8 | reply[1], transaction_)});
  }
  return Bytes(reply.begin() + kMbapHead, reply.begin() + got);
}

tl::expected<Bytes, Fault> ModbusLink::exchange_rtu(const Bytes& request) {
  // The line is silent for 3.5 characters between two frames; what came after the last one, a
  // noise byte, is in by then and would shift the reply.
  const int baud = std::get<ModbusRtuEndpoint>(endpoint_).baud;
  std::this_thread::sleep_for(clock_.wall(std::max<DeviceTime>(
      std::chrono::microseconds{1750}, std::chrono::microseconds{38'500'000 / baud})));
  modbus_flush(context_.get());
  Bytes frame = request;
  if (modbus_send_raw_request(context_.get(), frame.data(), static_cast<int>(frame.size())) <
      0) {
    return tl::unexpected(fault_of_errno(errno));
  }
  std::array<std::uint8_t, MODBUS_RTU_MAX_ADU_LENGTH> reply{};
  const int got = modbus_receive_confirmation(context_.get(), reply.data());
  if (got < 0) return tl::unexpected(fault_of_errno(errno));
  // libmodbus gives a reply of another unit as one of no length.
  if (got == 0) {
    return tl::unexpected(Fault{
        FaultKind::kWrongChannel, fmt::format("not unit {} but another answers", request[0])});
  }
  const auto size = static_cast<std::size_t>(got);
  if (size <= kCrc) return tl::unexpected(Fault{FaultKind::kBadFrame, "a short reply"});
  return Bytes(reply.begin(), reply.begin() + static_cast<std::ptrdiff_t>(size - kCrc));
}

tl::expected<Bytes, Fault> ModbusLink::exchange(const Bytes& request) {
  if (modbus_set_slave(context_.get(), request[0]) != 0) {
    return tl::unexpected(Fault{FaultKind::kDevice, fmt::format("no unit {}", request[0])});
  }
  return is_tcp() ? exchange_tcp(request) : exchange_rtu(request);
}

tl::expected<Words, Fault> ModbusLink::read(
    int unit, int function, int address, int count, const std::stop_token& stop) {
  if (const auto usable = ready(unit, stop); !usable) return tl::unexpected(usable.error());
  const auto words =
      exchange(read_request(unit, function, address, count)).and_then([&](const Bytes& reply) {
        return parse_read_reply(reply, unit, function, count);
      });
  if (words) {
    health_.good();
  } else {
    note(words.error());
  }
  return words;
}

tl::expected<void, Fault> ModbusLink::write(
    int unit, int address, std::span<const std::uint16_t> values, const std::stop_token& stop) {
  if (const auto usable = ready(unit, stop); !usable) return usable;
  const auto written =
      exchange(write_request(unit, address, values)).and_then([&](const Bytes& reply) {
        return parse_write_reply(reply, unit, address, static_cast<int>(values.size()));
      });
  if (written) {
    health_.good();
  } else {
    note(written.error());
  }
  return written;
}

void ModbusLink::note(const Fault& fault) {
  // The device said no: the line is well.
  if (fault.kind == FaultKind::kDevice) return;
  const DeviceTime now = clock_.monotonic();
  if (fault.kind == FaultKind::kDisconnected) {
    context_.reset();
    down_ = fault;
    health_.lost(now);
    return;
  }
  health_.bad(now);
  if (health_.state() == LinkState::kDown) down_ = fault;
  if (is_tcp()) {
    context_.reset();  // a late reply goes down with its connection
  } else {
    quiet_until_ = steady_clock::now() + clock_.wall_timeout(quiet_);
  }
}

}  // namespace sixdial::acquisition
