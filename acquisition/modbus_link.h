// A Modbus client on libmodbus, TCP or RTU, with its own recovery.
//
// Seen on the bench (libmodbus 3.1.6): one late RTU reply hands every later answer to the wrong
// request; its own recovery can block for ever; TCP replies of another unit pass unnoticed; a
// connect that times out shows as EINPROGRESS; no unit id on RTU, or a descriptor above 1023,
// aborts the process. So: recovery off, one request at a time, every reply checked here
// (transaction, unit, function, length); after an error TCP is closed and opened anew, RTU is
// left alone for longer than its slowest device, then flushed.
#pragma once

#include <chrono>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <stop_token>
#include <string>

#include "acquisition/clock.h"
#include "acquisition/connection.h"
#include "acquisition/link_health.h"
#include "acquisition/modbus_frame.h"

struct _modbus;

namespace sixdial::acquisition {

/// One thread at a time. Connects when first asked, and again when it is worth trying.
class ModbusLink {
 public:
  /// `timeout`, `quiet`: device time.
  ModbusLink(
      ModbusEndpoint endpoint, std::chrono::milliseconds timeout,
      std::chrono::milliseconds quiet, Clock& clock);
  ~ModbusLink();

  /// While backing off: kDisconnected at once, without touching the line.
  [[nodiscard]] tl::expected<Words, Fault> read(
      int unit, int function, int address, int count, const std::stop_token& stop);
  [[nodiscard]] tl::expected<void, Fault> write(
      int unit, int address, std::span<const std::uint16_t> values,
      const std::stop_token& stop);
  void close();

  [[nodiscard]] LinkState state() const { return health_.state(); }
  [[nodiscard]] DeviceTime next_try() const { return health_.next_try(); }
  /// How often it was connected; more than 1: there were reconnections.
  [[nodiscard]] std::uint64_t connections() const { return connections_; }

 private:
  struct Close {
    void operator()(_modbus* context) const;
  };
  tl::expected<Bytes, Fault> exchange(const Bytes& request);
  tl::expected<Bytes, Fault> exchange_tcp(const Bytes& request);
  tl::expected<Bytes, Fault> exchange_rtu(const Bytes& request);
  tl::expected<void, Fault> ready(int unit, const std::stop_token& stop);
  tl::expected<void, Fault> connect(int unit);
  void note(const Fault& fault);
  [[nodiscard]] bool is_tcp() const {
    return std::holds_alternative<ModbusTcpEndpoint>(endpoint_);
  }

  ModbusEndpoint endpoint_;
  std::chrono::milliseconds timeout_;
  std::chrono::milliseconds quiet_;
  Clock& clock_;
  LinkHealth health_;
  std::unique_ptr<_modbus, Close> context_;
  std::optional<std::chrono::steady_clock::time_point> quiet_until_;
  Fault down_{FaultKind::kDisconnected, "not connected yet"};
  std::uint16_t transaction_ = 0;
  std::uint64_t connections_ = 0;
};

}  // namespace sixdial::acquisition
