#include "acquisition/dial_protocol.h"

#include <array>
#include <cmath>
#include <mutex>
#include <stdexcept>

namespace sixdial::acquisition {

extern const DialProtocol sylvac;
extern const DialProtocol mahr;
extern const DialProtocol mux10;
extern const DialProtocol mw;

namespace {

constexpr std::array kProtocols{&sylvac, &mahr, &mux10, &mw};

struct Added {
  std::mutex mutex;
  std::vector<const DialProtocol*> rows;
};
Added& added() {
  static Added all;
  return all;
}
// A zero set a little off, or the end stop's rubber: still a reading.
constexpr double kBeyondTravel_mm = 0.5;

int decimals_of(double resolution_mm) {
  int decimals = 0;
  for (double step = 1.0; step > resolution_mm * 1.000001 && decimals < 6; step /= 10.0) {
    ++decimals;
  }
  return decimals;
}

}  // namespace

std::vector<const DialProtocol*> dial_protocols() {
  std::vector<const DialProtocol*> all(kProtocols.begin(), kProtocols.end());
  const std::lock_guard lock(added().mutex);
  all.insert(all.end(), added().rows.begin(), added().rows.end());
  return all;
}

const DialProtocol* find_dial_protocol(std::string_view name) {
  for (const DialProtocol* protocol : dial_protocols()) {
    if (protocol->name == name) return protocol;
  }
  return nullptr;
}

void add_dial_protocol(const DialProtocol& protocol) {
  const std::string name(protocol.name);
  if (name.empty()) throw std::invalid_argument("a dial protocol has no name");
  if (find_dial_protocol(name) != nullptr) {
    throw std::invalid_argument("there is a dial protocol '" + name + "' already");
  }
  if (protocol.request == nullptr || protocol.parse == nullptr || protocol.unasked == nullptr ||
      protocol.frame_end.empty()) {
    throw std::invalid_argument(
        "the dial protocol '" + name + "' lacks its request, its parser or its end of a frame");
  }
  const std::lock_guard lock(added().mutex);
  added().rows.push_back(&protocol);
}

bool within_travel(double value_mm, double travel_mm) noexcept {
  return std::isfinite(value_mm) && value_mm >= -kBeyondTravel_mm &&
         value_mm <= travel_mm + kBeyondTravel_mm;
}

tl::expected<double, FaultKind> displacement_mm(
    const DialFrame& frame, double resolution_mm, double travel_mm) noexcept {
  if (frame.unit == Unit::kInch) return tl::unexpected(FaultKind::kUnit);
  if (frame.unit == Unit::kUnsaid && frame.decimals > decimals_of(resolution_mm)) {
    return tl::unexpected(FaultKind::kUnit);
  }
  if (!within_travel(frame.value, travel_mm)) return tl::unexpected(FaultKind::kRange);
  return frame.value;
}

}  // namespace sixdial::acquisition
