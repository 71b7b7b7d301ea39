// Any bytes as a frame of every dialect: no crash, and what is read is finite and within
// travel.
#include <cmath>
#include <cstdint>
#include <cstdlib>
#include <string_view>

#include "acquisition/dial_protocol.h"

using namespace sixdial::acquisition;

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  if (size == 0) return 0;
  const std::string_view frame(reinterpret_cast<const char*>(data) + 1, size - 1);
  for (const DialProtocol* protocol : dial_protocols()) {
    const int channel = protocol->channels > 0 ? 1 + data[0] % protocol->channels : 0;
    (void)protocol->unasked(frame);
    const auto parsed = protocol->parse(frame, channel);
    if (!parsed) continue;
    if (!frame.ends_with(protocol->frame_end)) std::abort();
    if (!std::isfinite(parsed->value)) std::abort();
    const auto value_mm = displacement_mm(*parsed, 0.001, 50.8);
    if (value_mm && !within_travel(*value_mm, 50.8)) std::abort();
  }
  return 0;
}
