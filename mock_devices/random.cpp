#include "mock_devices/random.h"

#include <Random123/philox.h>

#include <cmath>
#include <numbers>

namespace sixdial::mock_devices {
namespace {

r123::Philox4x32::ctr_type block(
    std::uint64_t seed, std::uint32_t stream, std::uint32_t place, std::uint64_t counter) {
  const r123::Philox4x32::ctr_type position{
      {static_cast<std::uint32_t>(counter), static_cast<std::uint32_t>(counter >> 32), stream,
       place}};
  const r123::Philox4x32::key_type key{
      {static_cast<std::uint32_t>(seed), static_cast<std::uint32_t>(seed >> 32)}};
  return r123::Philox4x32{}(position, key);
}

double open_unit(std::uint32_t high, std::uint32_t low) {
  const std::uint64_t bits = (static_cast<std::uint64_t>(high) << 32 | low) >> 12;
  return (static_cast<double>(bits) + 0.5) * 0x1.0p-52;
}

}  // namespace

double Random::uniform(std::uint64_t counter) const {
  const auto words = block(seed_, stream_, place_, counter);
  return open_unit(words[0], words[1]);
}

double Random::uniform(std::uint64_t counter, double low, double high) const {
  return low + (high - low) * uniform(counter);
}

double Random::normal(std::uint64_t counter) const {
  const auto words = block(seed_, stream_, place_, counter);
  const double radius = std::sqrt(-2.0 * std::log(open_unit(words[0], words[1])));
  return radius * std::cos(2.0 * std::numbers::pi * open_unit(words[2], words[3]));
}

}  // namespace sixdial::mock_devices
