#include "mock_devices/gcode_cable.h"

#include <utility>

namespace sixdial::mock_devices {

// Nobody there is as on a real line: lost.
void GcodeCable::say_what_is_due(double time_s) {
  const std::string said = machine_.due(time_s);
  for (auto& [client, out] : out_) out += said;
}

void GcodeCable::connected(int client, double time_s) {
  say_what_is_due(time_s);
  out_[client].clear();
}

void GcodeCable::receive(int, std::string_view bytes, double time_s) {
  machine_.receive(bytes, time_s);
}

std::string GcodeCable::due(int client, double time_s) {
  say_what_is_due(time_s);
  return std::exchange(out_[client], {});
}

void GcodeCable::gone(int client) { out_.erase(client); }

}  // namespace sixdial::mock_devices
