// Mahr MarConnect: "?\r" -> "+012.345 mm\r" or "+0.48602 inch\r"; ERR2 syntax, ERR3 cannot
// execute, ERR4 locked. The dial starts a new command after a gap of 20 ms: send it in one
// write.
#include "acquisition/dials/decimal.h"

namespace sixdial::acquisition {
namespace {

tl::expected<DialFrame, FaultKind> parse(std::string_view frame, int) noexcept {
  const auto bad = tl::unexpected(FaultKind::kBadFrame);
  if (frame.size() < 2 || frame.size() > 20 || frame.back() != '\r') return bad;
  frame.remove_suffix(1);
  if (frame == "ERR2" || frame == "ERR3" || frame == "ERR4") {
    return tl::unexpected(FaultKind::kDevice);
  }
  Unit unit = Unit::kUnsaid;
  if (frame.ends_with(" mm")) {
    unit = Unit::kMillimetre;
    frame.remove_suffix(3);
  } else if (frame.ends_with(" inch")) {
    unit = Unit::kInch;
    frame.remove_suffix(5);
  } else {
    return bad;
  }
  if (frame.empty() || (frame.front() != '+' && frame.front() != '-')) return bad;
  return parse_decimal(frame.substr(1), frame.front(), unit);
}

std::string_view says(std::string_view frame) noexcept {
  if (frame == "ERR2\r") return "the dial does not understand the question";
  if (frame == "ERR3\r") return "no value just now, as while the plunger moves fast";
  if (frame == "ERR4\r") return "the dial is locked: unlock it at its keys";
  return "";
}

bool unasked(std::string_view) noexcept { return false; }

std::string request(int) { return "?\r"; }

}  // namespace

extern constinit const DialProtocol mahr{
    .name = "mahr",
    .line =
        {.baud = 9600,
         .data_bits = 7,
         .parity = Parity::kEven,
         .stop_bits = 2,
         .dtr = true,
         .rts = false},
    .frame_end = "\r",
    .identity_request = "ID?\r",
    .request = request,
    .parse = parse,
    .says = says,
    .unasked = unasked,
    .maker = "Mahr",
    .wiring = "dials with a MarConnect RS232 cable each",
    .advice =
        "The dials go to sleep after 8 minutes unless told otherwise; inch is refused, as its "
        "steps are too coarse.",
    .example_port = "MarConnect",
    .example_serial = 2001};

}  // namespace sixdial::acquisition
