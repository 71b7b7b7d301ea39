// "?<CR>" -> "+012.345<CR>" at 4800 7E2, a duplex cable for each dial.
#include <fmt/format.h>

#include "mock_devices/dials/dialect.h"

namespace sixdial::mock_devices {
namespace {

std::string value_text(const ShownDial& shown) {
  return shown.inch ? signed_number(shown.value, 7, 5) : signed_number(shown.value, 7, 3);
}

std::string reply_to(std::string_view request, std::size_t dial, Panel& panel) {
  if (const auto error = panel.take(dial, Fault::kErrorLine)) {
    return fmt::format("ERR{}", static_cast<int>(error->amount.value_or(2.0)));
  }
  if (panel.take(dial, Fault::kBusy)) return "ERR0";
  const std::string command = plain_command(request);
  if (command == "?" || command == "PRI" || command == "PRI?") {
    const ShownDial shown = panel.show(dial);
    if (shown.moving_fast) return "ERR0";
    if (shown.at_travel_end) return "ERR3";
    return value_text(shown);
  }
  if (command == "SET?") {
    const ShownDial shown = panel.show(dial);
    return fmt::format("{} RES2 B{}", shown.inch ? "IN" : "MM", shown.low_battery ? 0 : 1);
  }
  if (command == "BAT?") return panel.show(dial).low_battery ? "BAT0" : "BAT1";
  if (command == "ID?") return fmt::format("SY280{}", dial + 1);
  if (command == "UNI?") return panel.show(dial).inch ? "IN" : "MM";
  if (command == "MM" || command == "IN") {
    panel.set_inch(dial, command == "IN");
    return command;
  }
  if (command == "STO0" || command == "STO1") {
    panel.set_hold(dial, command == "STO1");
    return command;
  }
  return "ERR1";
}

Reply answer(std::string_view request, std::size_t own_dial, Panel& panel) {
  return {reply_to(request, own_dial, panel) + "\r", own_dial};
}

std::string key_pressed(std::size_t dial, Panel& panel) {
  return value_text(panel.show(dial)) + "\r";
}

std::string power_on(std::size_t dial) { return fmt::format("SY280{}\r", dial + 1); }

}  // namespace

const Dialect kSylvac{
    .name = "sylvac",
    .line = {4800, 7, 'E', 2},
    .latency_s = 0.060,
    .shared = false,
    .longest_gap_s = 0.0,
    .take_request = take_line,
    .answer = answer,
    .key_pressed = key_pressed,
    .power_on = power_on};

}  // namespace sixdial::mock_devices
