#include "mock_devices/modbus_slave.h"

#include <algorithm>
#include <iterator>

namespace sixdial::mock_devices {
namespace {

constexpr std::uint8_t kReadHolding = 3;
constexpr std::uint8_t kReadInput = 4;
constexpr std::uint8_t kWriteOne = 6;
constexpr std::uint8_t kWriteMany = 16;
constexpr std::uint8_t kExceptionBit = 0x80;
constexpr std::uint16_t kMostRead = 125;
constexpr std::uint16_t kMostWritten = 123;
constexpr std::size_t kHeader = 7;  // MBAP
constexpr std::size_t kMostPdu = 253;

std::uint16_t word(std::span<const std::uint8_t> bytes, std::size_t at) {
  return static_cast<std::uint16_t>(bytes[at] << 8 | bytes[at + 1]);
}

void append(Bytes& bytes, std::uint16_t value) {
  bytes.push_back(static_cast<std::uint8_t>(value >> 8));
  bytes.push_back(static_cast<std::uint8_t>(value & 0xFF));
}

Bytes refused(std::uint8_t function, ModbusException why) {
  return exception_pdu(function, static_cast<std::uint8_t>(why));
}

}  // namespace

Bytes exception_pdu(std::uint8_t function, std::uint8_t code) {
  return {static_cast<std::uint8_t>(function | kExceptionBit), code};
}

Bytes answer_pdu(std::span<const std::uint8_t> pdu, RegisterMap& registers) {
  if (pdu.empty()) return {};
  const std::uint8_t function = pdu[0];
  switch (function) {
    case kReadHolding:
    case kReadInput: {
      if (pdu.size() != 5) return refused(function, ModbusException::kIllegalValue);
      const std::uint16_t count = word(pdu, 3);
      if (count == 0 || count > kMostRead) {
        return refused(function, ModbusException::kIllegalValue);
      }
      const auto table =
          function == kReadHolding ? RegisterTable::kHolding : RegisterTable::kInput;
      const auto values = registers.read(table, word(pdu, 1), count);
      if (!values) return refused(function, ModbusException::kIllegalAddress);
      Bytes reply{function, static_cast<std::uint8_t>(2 * count)};
      for (const std::uint16_t value : *values) append(reply, value);
      return reply;
    }
    case kWriteOne: {
      if (pdu.size() != 5) return refused(function, ModbusException::kIllegalValue);
      const std::uint16_t value = word(pdu, 3);
      if (const auto why = registers.write(word(pdu, 1), {&value, 1})) {
        return refused(function, *why);
      }
      return {pdu.begin(), pdu.end()};
    }
    case kWriteMany: {
      if (pdu.size() < 6) return refused(function, ModbusException::kIllegalValue);
      const std::uint16_t count = word(pdu, 3);
      if (count == 0 || count > kMostWritten || pdu[5] != 2 * count ||
          pdu.size() != 6U + 2U * count) {
        return refused(function, ModbusException::kIllegalValue);
      }
      std::vector<std::uint16_t> values;
      for (std::size_t i = 0; i < count; ++i) values.push_back(word(pdu, 6 + 2 * i));
      if (const auto why = registers.write(word(pdu, 1), values)) {
        return refused(function, *why);
      }
      return {pdu.begin(), pdu.begin() + 5};
    }
    default:
      return refused(function, ModbusException::kIllegalFunction);
  }
}

std::uint16_t ModbusRequest::address() const { return pdu.size() >= 5 ? word(pdu, 1) : 0; }

std::uint16_t ModbusRequest::count() const {
  const bool reads = pdu.size() == 5 && (pdu[0] == kReadHolding || pdu[0] == kReadInput);
  return reads ? word(pdu, 3) : 0;
}

Framing take_tcp_request(Bytes& buffer, ModbusRequest& request) {
  if (buffer.size() < kHeader) return Framing::kNeedMore;
  const std::uint16_t protocol = word(buffer, 2);
  const std::uint16_t length = word(buffer, 4);
  if (protocol != 0 || length < 2 || length > kMostPdu + 1) return Framing::kBroken;
  const std::size_t whole = 6U + length;
  if (buffer.size() < whole) return Framing::kNeedMore;
  request.transaction = word(buffer, 0);
  request.unit = buffer[6];
  request.pdu.assign(
      buffer.begin() + kHeader, buffer.begin() + static_cast<std::ptrdiff_t>(whole));
  buffer.erase(buffer.begin(), buffer.begin() + static_cast<std::ptrdiff_t>(whole));
  return Framing::kRequest;
}

Framing take_rtu_request(Bytes& buffer, ModbusRequest& request) {
  if (buffer.size() < 8) return Framing::kNeedMore;
  std::size_t whole = 8;  // unit, function, address, count or value, CRC
  if (buffer[1] == kWriteMany) whole = 9U + buffer[6];
  if (buffer.size() < whole) return Framing::kNeedMore;
  const std::span<const std::uint8_t> frame(buffer.data(), whole);
  const std::uint16_t sent =
      static_cast<std::uint16_t>(frame[whole - 1] << 8 | frame[whole - 2]);
  if (crc16(frame.first(whole - 2)) != sent) return Framing::kBroken;
  request.unit = frame[0];
  request.pdu.assign(frame.begin() + 1, frame.end() - 2);
  buffer.erase(buffer.begin(), buffer.begin() + static_cast<std::ptrdiff_t>(whole));
  return Framing::kRequest;
}

Bytes tcp_frame(
    std::uint16_t transaction, std::uint8_t unit, std::span<const std::uint8_t> pdu) {
  Bytes frame;
  append(frame, transaction);
  append(frame, 0);
  append(frame, static_cast<std::uint16_t>(pdu.size() + 1));
  frame.push_back(unit);
  frame.insert(frame.end(), pdu.begin(), pdu.end());
  return frame;
}

Bytes rtu_frame(std::uint8_t unit, std::span<const std::uint8_t> pdu) {
  Bytes frame;
  frame.reserve(pdu.size() + 3);
  frame.push_back(unit);
  std::copy(pdu.begin(), pdu.end(), std::back_inserter(frame));
  const std::uint16_t crc = crc16(frame);
  frame.push_back(static_cast<std::uint8_t>(crc & 0xFF));  // low byte first
  frame.push_back(static_cast<std::uint8_t>(crc >> 8));
  return frame;
}

std::uint16_t crc16(std::span<const std::uint8_t> bytes) {
  unsigned crc = 0xFFFF;
  for (const std::uint8_t byte : bytes) {
    crc ^= byte;
    for (int bit = 0; bit < 8; ++bit) crc = (crc & 1U) != 0 ? crc >> 1 ^ 0xA001U : crc >> 1;
  }
  return static_cast<std::uint16_t>(crc);
}

}  // namespace sixdial::mock_devices
