// The answering side of Modbus, from the protocol's own pages: MBAP frames on TCP, CRC frames
// on a serial line, functions 3, 4, 6 and 16, exceptions. Pure: bytes in, bytes out.
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <vector>

namespace sixdial::mock_devices {

using Bytes = std::vector<std::uint8_t>;

enum class ModbusException : std::uint8_t {
  kIllegalFunction = 1,
  kIllegalAddress = 2,
  kIllegalValue = 3,
  kDeviceFailure = 4,
  kBusy = 6,
  kGatewayNoTarget = 11,
};

enum class RegisterTable { kHolding, kInput };

/// What the registers of a device hold.
class RegisterMap {
 public:
  RegisterMap() = default;
  RegisterMap(const RegisterMap&) = delete;
  RegisterMap& operator=(const RegisterMap&) = delete;
  virtual ~RegisterMap() = default;
  /// All registers of one request at one instant; empty: some address does not exist.
  [[nodiscard]] virtual std::optional<std::vector<std::uint16_t>> read(
      RegisterTable table, std::uint16_t address, std::uint16_t count) = 0;
  /// Empty: taken.
  [[nodiscard]] virtual std::optional<ModbusException> write(
      std::uint16_t address, std::span<const std::uint16_t> values) = 0;
};

/// Function code and data -> the reply's function code and data.
[[nodiscard]] Bytes answer_pdu(std::span<const std::uint8_t> pdu, RegisterMap& registers);
[[nodiscard]] Bytes exception_pdu(std::uint8_t function, std::uint8_t code);

/// A request: whom it asks, and what.
struct ModbusRequest {
  std::uint16_t transaction = 0;  // TCP only
  std::uint8_t unit = 0;
  Bytes pdu;
  /// Registers it reads; count 0 if it does not read.
  [[nodiscard]] std::uint16_t address() const;
  [[nodiscard]] std::uint16_t count() const;
};

enum class Framing { kNeedMore, kRequest, kBroken };
/// Takes one request off the front of what came in. kBroken: the stream cannot be trusted.
[[nodiscard]] Framing take_tcp_request(Bytes& buffer, ModbusRequest& request);
[[nodiscard]] Framing take_rtu_request(Bytes& buffer, ModbusRequest& request);
[[nodiscard]] Bytes tcp_frame(
    std::uint16_t transaction, std::uint8_t unit, std::span<const std::uint8_t> pdu);
[[nodiscard]] Bytes rtu_frame(std::uint8_t unit, std::span<const std::uint8_t> pdu);
[[nodiscard]] std::uint16_t crc16(std::span<const std::uint8_t> bytes);

}  // namespace sixdial::mock_devices
