// Modbus requests and replies as bytes, without the transport's head and checksum; and
// registers as a gauge box means them. Pure, so that any bytes can be thrown at it.
#pragma once

#include <cstdint>
#include <span>
#include <tl/expected.hpp>
#include <vector>

#include "acquisition/connection.h"
#include "acquisition/fault.h"

namespace sixdial::acquisition {

using Words = std::vector<std::uint16_t>;
using Bytes = std::vector<std::uint8_t>;

/// unit, function, address, count; 1 <= count <= 125.
[[nodiscard]] Bytes read_request(int unit, int function, int address, int count);
/// Function 16; 1 to 123 values.
[[nodiscard]] Bytes write_request(int unit, int address, std::span<const std::uint16_t> values);

/// The registers of a reply from `unit` on; an exception reply is kDevice, another unit's
/// answer is kWrongChannel, anything else that does not match the request is kBadFrame.
[[nodiscard]] tl::expected<Words, Fault> parse_read_reply(
    std::span<const std::uint8_t> reply, int unit, int function, int count);
[[nodiscard]] tl::expected<void, Fault> parse_write_reply(
    std::span<const std::uint8_t> reply, int unit, int address, int count);

/// Exception 2: the reply of a device that does not have these registers.
[[nodiscard]] bool is_illegal_address(const Fault& fault);

[[nodiscard]] std::int32_t int32_of(std::uint16_t high, std::uint16_t low);
/// High word first.
void append_int32(Words& words, std::int32_t value);

/// Registers that one value takes.
[[nodiscard]] int words_per_value(RegisterFormat format);
/// mm. kDevice for 0x80000000, 0x8000 and NaN: the gauge says invalid.
[[nodiscard]] tl::expected<double, FaultKind> value_mm(
    std::span<const std::uint16_t> words, const ModbusMap& map);

}  // namespace sixdial::acquisition
