// The example's twin: what such a dial sends.
#include "mock_devices/dials/dialect.h"

namespace sixdial::mock_devices {
namespace {

Reply answer(std::string_view request, std::size_t own_dial, Panel& panel) {
  if (plain_command(request) != "?") return {"", own_dial};
  return {signed_number(panel.show(own_dial).value, 7, 3) + "\r", own_dial};
}

std::string key_pressed(std::size_t /*dial*/, Panel& /*panel*/) { return {}; }
std::string power_on(std::size_t /*dial*/) { return {}; }

}  // namespace

const Dialect kPlain{
    .name = "plain",
    .line = {9600, 8, 'N', 1},
    .latency_s = 0.050,
    .shared = false,
    .longest_gap_s = 0.0,
    .take_request = take_line,
    .answer = answer,
    .key_pressed = key_pressed,
    .power_on = power_on};

}  // namespace sixdial::mock_devices
