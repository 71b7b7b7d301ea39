// Sylvac and kin on an Opto-RS232 cable: "?\r" -> "+012.345\r". Sign + - or blank, digits vary,
// a tolerance sign < = > may follow; "ERR0".."ERR3". No unit is sent: inch shows by its
// decimals.
#include "acquisition/dials/decimal.h"

namespace sixdial::acquisition {
namespace {

tl::expected<DialFrame, FaultKind> parse(std::string_view frame, int) noexcept {
  const auto bad = tl::unexpected(FaultKind::kBadFrame);
  if (frame.size() < 2 || frame.size() > 16 || frame.back() != '\r') return bad;
  frame.remove_suffix(1);
  if (frame.starts_with("ERR")) {
    if (frame == "ERR3") return tl::unexpected(FaultKind::kRange);
    if (frame == "ERR0" || frame == "ERR1" || frame == "ERR2") {
      return tl::unexpected(FaultKind::kDevice);
    }
    return bad;
  }
  const char sign = frame.front();
  if (sign != '+' && sign != '-' && sign != ' ') return bad;
  frame.remove_prefix(1);
  if (!frame.empty() && std::string_view("<=>").find(frame.back()) != std::string_view::npos) {
    frame.remove_suffix(1);
  }
  return parse_decimal(frame, sign, Unit::kUnsaid);
}

std::string_view says(std::string_view frame) noexcept {
  if (frame == "ERR0\r") return "no value just now, as while the plunger moves fast";
  if (frame == "ERR1\r") return "the dial does not know the question";
  if (frame == "ERR2\r") return "the dial reports an error of its own";
  if (frame == "ERR3\r") return "the plunger is beyond the dial's range";
  return "";
}

bool unasked(std::string_view frame) noexcept { return frame.starts_with("SY"); }

std::string request(int) { return "?\r"; }

}  // namespace

// A duplex Opto-RS232 cable is fed by the modem lines: DTR high, RTS low.
extern constinit const DialProtocol sylvac{
    .name = "sylvac",
    .line =
        {.baud = 4800,
         .data_bits = 7,
         .parity = Parity::kEven,
         .stop_bits = 2,
         .dtr = true,
         .rts = false},
    .frame_end = "\r",
    .identity_request = "ID?\r",
    .battery_request = "BAT?\r",
    .low_battery = "BAT0\r",
    .request = request,
    .parse = parse,
    .says = says,
    .unasked = unasked,
    .maker = "Sylvac and kin",
    .wiring = "dials with an Opto-RS232 cable each",
    .advice =
        "`sixdial rig scan` lists the stable names of the cables and the value each shows now: "
        "push a spindle to see\n"
        "which is which. Switch the dials to mm and their auto-off off.",
    .example_port = "Sylvac_Opto_RS232",
    .example_serial = 1001};

}  // namespace sixdial::acquisition
