// Any bytes as a Modbus reply, and its registers as values of every format.
#include <cmath>
#include <cstdint>
#include <cstdlib>
#include <span>

#include "acquisition/modbus_frame.h"

using namespace sixdial::acquisition;

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  if (size == 0) return 0;
  const int count = 1 + data[0] % 125;
  const std::span<const std::uint8_t> reply(data + 1, size - 1);
  (void)parse_write_reply(reply, 1, 0, count);
  const auto words = parse_read_reply(reply, 1, 4, count);
  if (!words) return 0;
  if (words->size() != static_cast<std::size_t>(count)) std::abort();
  for (const auto format :
       {RegisterFormat::kInt32, RegisterFormat::kFloat32, RegisterFormat::kInt16}) {
    ModbusMap map;
    map.format = format;
    const auto value = value_mm(*words, map);
    if (value && !std::isfinite(*value)) std::abort();
  }
  return 0;
}
