// Multiplexers of the DMX kind: "C1\r\n" -> "1 MW +001.378 mm\r\n", the blank after MW may be
// missing. The type field comes first: "3 TO 999999.99 mm" is no reading but a missing dial.
#include <fmt/format.h>

#include "acquisition/dials/decimal.h"

namespace sixdial::acquisition {
namespace {

tl::expected<DialFrame, FaultKind> parse(std::string_view frame, int channel) noexcept {
  const auto bad = tl::unexpected(FaultKind::kBadFrame);
  if (frame.size() < 8 || frame.size() > 32 || !frame.ends_with("\r\n")) return bad;
  frame.remove_suffix(2);
  if (frame[0] < '1' || frame[0] > '8' || frame[1] != ' ') return bad;
  const int answered = frame[0] - '0';
  const std::string_view type = frame.substr(2, 2);
  frame.remove_prefix(4);
  if (!frame.empty() && frame.front() == ' ') frame.remove_prefix(1);
  Unit unit = Unit::kUnsaid;
  if (frame.ends_with(" mm")) {
    unit = Unit::kMillimetre;
    frame.remove_suffix(3);
  } else if (frame.ends_with(" inch")) {
    unit = Unit::kInch;
    frame.remove_suffix(5);
  } else if (frame.ends_with(" in")) {
    unit = Unit::kInch;
    frame.remove_suffix(3);
  } else {
    return bad;
  }
  if (frame.empty()) return bad;
  if (type == "TO") {
    if (!parse_decimal(frame, '+', unit)) return bad;
    return tl::unexpected(answered == channel ? FaultKind::kNoDial : FaultKind::kWrongChannel);
  }
  if (type != "MW" || (frame.front() != '+' && frame.front() != '-')) return bad;
  const auto result = parse_decimal(frame.substr(1), frame.front(), unit);
  if (result && answered != channel) return tl::unexpected(FaultKind::kWrongChannel);
  return result;
}

std::string_view says(std::string_view frame) noexcept {
  return frame.size() > 4 && frame.substr(1, 3) == " TO"
             ? "the box had no answer from the dial in its time: it moves fast, is off, or is "
               "unplugged"
             : "";
}

bool unasked(std::string_view) noexcept { return false; }

std::string request(int channel) { return fmt::format("C{}\r\n", channel); }

}  // namespace

extern constinit const DialProtocol mw{
    .name = "mw",
    .line = {.baud = 9600, .data_bits = 8, .parity = Parity::kNone, .stop_bits = 1},
    .frame_end = "\r\n",
    .channels = 8,
    .identity_request = "",
    .request = request,
    .parse = parse,
    .says = says,
    .unasked = unasked,
    .maker = "DMX-8/2 and kin",
    .wiring = "Digimatic dials behind a box of eight",
    .advice = "channel is the socket at the box, 1 to 8; two are free here.",
    .example_port = "DMX-8",
    .example_serial = 4001};

}  // namespace sixdial::acquisition
