// "C1<CR><LF>" -> "1 MW +001.378 mm<CR><LF>" at 9600 8N1: DMX-8/2 and kin, six dials a port.
#include <fmt/format.h>

#include "mock_devices/dials/dialect.h"

namespace sixdial::mock_devices {
namespace {

Reply answer(std::string_view request, std::size_t /*own_dial*/, Panel& panel) {
  const std::string command = plain_command(request);
  if (command.size() != 2 || command[0] != 'C' || command[1] < '1' || command[1] > '8') {
    return {"", 0};
  }
  const auto dial = static_cast<std::size_t>(command[1] - '1');
  const std::string none = fmt::format("{} TO 999999.99 mm\r\n", dial + 1);
  if (dial >= panel.dial_count()) return {none, 0};
  if (panel.take(dial, Fault::kErrorLine) || panel.take(dial, Fault::kBusy)) {
    return {none, dial};
  }
  const bool astray = panel.take(dial, Fault::kWrongChannel).has_value();
  const std::size_t read = astray ? (dial + 1) % panel.dial_count() : dial;
  const ShownDial shown = panel.show(read);
  if (shown.moving_fast) return {"", dial};
  return {
      shown.inch ? fmt::format("{} MW {} in\r\n", read + 1, signed_number(shown.value, 7, 5))
                 : fmt::format("{} MW {} mm\r\n", read + 1, signed_number(shown.value, 7, 3)),
      dial};
}

std::string key_pressed(std::size_t dial, Panel& panel) {
  return answer(fmt::format("C{}", dial + 1), 0, panel).bytes;
}

std::string power_on(std::size_t /*dial*/) { return {}; }

}  // namespace

const Dialect kMw{
    .name = "mw",
    .line = {9600, 8, 'N', 1},
    .latency_s = 0.080,
    .shared = true,
    .longest_gap_s = 0.0,
    .take_request = take_line,
    .answer = answer,
    .key_pressed = key_pressed,
    .power_on = power_on};

}  // namespace sixdial::mock_devices
