// The example of CONTRIBUTING.md: "?\r" -> "+012.345\r", sign, three digits, point, three
// digits.
#include "acquisition/dials/decimal.h"

namespace sixdial::acquisition {
namespace {

tl::expected<DialFrame, FaultKind> parse(std::string_view frame, int) noexcept {
  const auto bad = tl::unexpected(FaultKind::kBadFrame);
  if (frame.size() != 9 || frame.back() != '\r') return bad;
  if (frame.front() != '+' && frame.front() != '-') return bad;
  return parse_decimal(frame.substr(1, 7), frame.front(), Unit::kMillimetre);
}

bool unasked(std::string_view) noexcept { return false; }

std::string request(int) { return "?\r"; }

}  // namespace

extern constinit const DialProtocol plain{
    .name = "plain",
    .line = {.baud = 9600, .data_bits = 8, .parity = Parity::kNone, .stop_bits = 1},
    .frame_end = "\r",
    .identity_request = "",
    .request = request,
    .parse = parse,
    .unasked = unasked,
    .maker = "a maker",
    .wiring = "dials with a plain cable each",
    .example_port = "Plain_Cable"};

}  // namespace sixdial::acquisition
