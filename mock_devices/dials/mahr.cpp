// "?<CR>" -> "+012.345 mm<CR>" at 9600 7E2, a cable for each dial (MarConnect).
#include <fmt/format.h>

#include "mock_devices/dials/dialect.h"

namespace sixdial::mock_devices {
namespace {

std::string value_text(const ShownDial& shown) {
  return shown.inch ? signed_number(shown.value, 7, 5) + " inch"
                    : signed_number(shown.value, 7, 3) + " mm";
}

std::string reply_to(std::string_view request, std::size_t dial, Panel& panel) {
  if (const auto error = panel.take(dial, Fault::kErrorLine)) {
    return fmt::format("ERR{}", static_cast<int>(error->amount.value_or(2.0)));
  }
  if (panel.take(dial, Fault::kBusy)) return "ERR3";
  const std::string command = plain_command(request);
  if (command == "?") {
    const ShownDial shown = panel.show(dial);
    return shown.moving_fast || shown.at_travel_end ? "ERR3" : value_text(shown);
  }
  if (command == "ID?") return fmt::format("T 4337665 S {:08}", 22050001 + dial);
  if (command == "UN?") return panel.show(dial).inch ? "INCH" : "MM";
  if (command == "MM" || command == "IN") {
    panel.set_inch(dial, command == "IN");
    return command;
  }
  return "ERR2";
}

Reply answer(std::string_view request, std::size_t own_dial, Panel& panel) {
  return {reply_to(request, own_dial, panel) + "\r", own_dial};
}

std::string key_pressed(std::size_t dial, Panel& panel) {
  return value_text(panel.show(dial)) + "\r";
}

std::string power_on(std::size_t /*dial*/) { return {}; }

}  // namespace

const Dialect kMahr{
    .name = "mahr",
    .line = {9600, 7, 'E', 2},
    .latency_s = 0.050,
    .shared = false,
    .longest_gap_s = 0.020,
    .take_request = take_line,
    .answer = answer,
    .key_pressed = key_pressed,
    .power_on = power_on};

}  // namespace sixdial::mock_devices
