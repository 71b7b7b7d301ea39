#include "acquisition/modbus_frame.h"

#include <fmt/format.h>

#include <bit>
#include <cmath>
#include <limits>

namespace sixdial::acquisition {
namespace {

constexpr int kWriteFunction = 16;
constexpr std::uint8_t kExceptionBit = 0x80;
constexpr int kIllegalAddress = 2;

std::uint8_t high_byte(int word) { return static_cast<std::uint8_t>((word >> 8) & 0xff); }
std::uint8_t low_byte(int word) { return static_cast<std::uint8_t>(word & 0xff); }
int word_at(std::span<const std::uint8_t> bytes, std::size_t i) {
  return bytes[i] << 8 | bytes[i + 1];
}

std::string exception_text(int code) {
  switch (code) {
    case 1:
      return "exception 1, illegal function";
    case kIllegalAddress:
      return "exception 2, illegal data address";
    case 3:
      return "exception 3, illegal data value";
    case 4:
      return "exception 4, device failure";
    case 5:
      return "exception 5, acknowledged and still at it";
    case 6:
      return "exception 6, device busy";
    case 10:
      return "exception 10, gateway has no path";
    case 11:
      return "exception 11, the device behind the gateway does not answer";
    default:
      return fmt::format("exception {}", code);
  }
}

// The head that every reply shares.
tl::expected<void, Fault> check_head(
    std::span<const std::uint8_t> reply, int unit, int function) {
  if (reply.size() < 3) {
    return tl::unexpected(
        Fault{FaultKind::kBadFrame, fmt::format("a reply of {} bytes", reply.size())});
  }
  if (reply[0] != unit) {
    return tl::unexpected(Fault{
        FaultKind::kWrongChannel, fmt::format("unit {} answers for unit {}", reply[0], unit)});
  }
  if (reply[1] == (function | kExceptionBit)) {
    return tl::unexpected(Fault{FaultKind::kDevice, exception_text(reply[2]), reply[2]});
  }
  if (reply[1] != function) {
    return tl::unexpected(Fault{
        FaultKind::kBadFrame,
        fmt::format("function {} answered, {} was asked", reply[1], function)});
  }
  return {};
}

}  // namespace

Bytes read_request(int unit, int function, int address, int count) {
  return {low_byte(unit),    low_byte(function), high_byte(address),
          low_byte(address), high_byte(count),   low_byte(count)};
}

Bytes write_request(int unit, int address, std::span<const std::uint16_t> values) {
  const int count = static_cast<int>(values.size());
  Bytes request{low_byte(unit),     low_byte(kWriteFunction), high_byte(address),
                low_byte(address),  high_byte(count),         low_byte(count),
                low_byte(2 * count)};
  for (const std::uint16_t value : values) {
    request.push_back(high_byte(value));
    request.push_back(low_byte(value));
  }
  return request;
}

tl::expected<Words, Fault> parse_read_reply(
    std::span<const std::uint8_t> reply, int unit, int function, int count) {
  if (const auto head = check_head(reply, unit, function); !head) {
    return tl::unexpected(head.error());
  }
  const auto expected = 2 * static_cast<std::size_t>(count);
  if (reply[2] != expected || reply.size() != 3 + expected) {
    return tl::unexpected(Fault{
        FaultKind::kBadFrame,
        fmt::format(
            "{} bytes of registers answered, {} were asked for", reply.size() - 3, expected)});
  }
  Words words;
  words.reserve(static_cast<std::size_t>(count));
  for (std::size_t i = 3; i < reply.size(); i += 2) {
    words.push_back(static_cast<std::uint16_t>(word_at(reply, i)));
  }
  return words;
}

tl::expected<void, Fault> parse_write_reply(
    std::span<const std::uint8_t> reply, int unit, int address, int count) {
  if (const auto head = check_head(reply, unit, kWriteFunction); !head) return head;
  if (reply.size() != 6 || word_at(reply, 2) != address || word_at(reply, 4) != count) {
    return tl::unexpected(
        Fault{FaultKind::kBadFrame, "the reply to a write does not repeat the request"});
  }
  return {};
}

bool is_illegal_address(const Fault& fault) {
  return fault.kind == FaultKind::kDevice && fault.device_code == kIllegalAddress;
}

std::int32_t int32_of(std::uint16_t high, std::uint16_t low) {
  return std::bit_cast<std::int32_t>(
      static_cast<std::uint32_t>(high) << 16 | static_cast<std::uint32_t>(low));
}

void append_int32(Words& words, std::int32_t value) {
  const auto bits = std::bit_cast<std::uint32_t>(value);
  words.push_back(static_cast<std::uint16_t>(bits >> 16));
  words.push_back(static_cast<std::uint16_t>(bits & 0xffff));
}

int words_per_value(RegisterFormat format) { return format == RegisterFormat::kInt16 ? 1 : 2; }

tl::expected<double, FaultKind> value_mm(
    std::span<const std::uint16_t> words, const ModbusMap& map) {
  const auto invalid = tl::unexpected(FaultKind::kDevice);
  if (words.size() < static_cast<std::size_t>(words_per_value(map.format))) return invalid;
  if (map.format == RegisterFormat::kInt16) {
    const auto counts = std::bit_cast<std::int16_t>(words[0]);
    if (counts == std::numeric_limits<std::int16_t>::min()) return invalid;
    return counts * map.scale;
  }
  const bool high_first = map.word_order == WordOrder::kHighFirst;
  const std::int32_t bits = int32_of(words[high_first ? 0 : 1], words[high_first ? 1 : 0]);
  if (map.format == RegisterFormat::kFloat32) {
    const auto value = static_cast<double>(std::bit_cast<float>(bits));
    if (!std::isfinite(value)) return invalid;
    return value * map.scale;
  }
  if (bits == std::numeric_limits<std::int32_t>::min()) return invalid;
  return bits * map.scale;
}

}  // namespace sixdial::acquisition
