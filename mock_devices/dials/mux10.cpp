// "1<CR>".."6<CR>" -> "01A+0012.345<CR>" at 9600 8N1: a Digimatic multiplexer, six dials a
// port.
#include <fmt/format.h>

#include "mock_devices/dials/dialect.h"

namespace sixdial::mock_devices {
namespace {

constexpr char kNoData = '1';
constexpr char kFormat = '2';
constexpr char kBusy = '8';

/// 91c: error c.
std::string error(char code) { return {'9', '1', code, '\r'}; }

Reply answer(std::string_view request, std::size_t /*own_dial*/, Panel& panel) {
  if (request.size() != 1 || request[0] < '1' || request[0] > '9') return {error(kFormat), 0};
  const auto dial = static_cast<std::size_t>(request[0] - '1');
  if (dial >= panel.dial_count()) return {error(kNoData), 0};
  if (const auto order = panel.take(dial, Fault::kErrorLine)) {
    return {
        error(static_cast<char>('0' + static_cast<int>(order->amount.value_or(2.0)))), dial};
  }
  if (panel.take(dial, Fault::kBusy)) return {error(kBusy), dial};
  // This multiplexer's own fault: it names the channel that it read by mistake.
  const bool astray = panel.take(dial, Fault::kWrongChannel).has_value();
  const std::size_t read = astray ? (dial + 1) % panel.dial_count() : dial;
  const ShownDial shown = panel.show(read);
  if (shown.moving_fast) return {error(kNoData), dial};
  return {
      fmt::format("0{}A{}\r", read + 1, signed_number(shown.value, 8, shown.inch ? 5 : 3)),
      dial};
}

std::string key_pressed(std::size_t dial, Panel& panel) {
  return answer(std::string(1, static_cast<char>('1' + dial)), 0, panel).bytes;
}

std::string power_on(std::size_t /*dial*/) { return {}; }

}  // namespace

const Dialect kMux10{
    .name = "mux10",
    .line = {9600, 8, 'N', 1},
    .latency_s = 0.090,
    .shared = true,
    .longest_gap_s = 0.0,
    .take_request = take_line,
    .answer = answer,
    .key_pressed = key_pressed,
    .power_on = power_on};

}  // namespace sixdial::mock_devices
