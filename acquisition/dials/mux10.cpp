// Mitutoyo Digimatic behind a six-channel multiplexer: "3\r" -> "03A+0012.345\r", 13 bytes:
// '0', channel, 'A', sign, eight characters with the point. "91c\r" is an error: 1 no data, 2
// format, 8 busy, 9 system. No unit: inch shows as four or five decimals.
#include <fmt/format.h>

#include "acquisition/dials/decimal.h"

namespace sixdial::acquisition {
namespace {

constexpr int kInchDecimals = 4;  // and five

tl::expected<DialFrame, FaultKind> parse(std::string_view frame, int channel) noexcept {
  const auto bad = tl::unexpected(FaultKind::kBadFrame);
  if (frame.empty() || frame.back() != '\r') return bad;
  if (frame.size() == 4 && frame.starts_with("91")) {
    switch (frame[2]) {
      case '1':
        return tl::unexpected(FaultKind::kNoDial);
      case '8':
        return tl::unexpected(FaultKind::kBusy);
      case '2':
      case '9':
        return tl::unexpected(FaultKind::kDevice);
      default:
        return bad;
    }
  }
  if (frame.size() != 13 || frame[0] != '0' || frame[2] != 'A') return bad;
  if (frame[1] < '1' || frame[1] > '6') return bad;
  const char sign = frame[3];
  if (sign != '+' && sign != '-') return bad;
  auto result = parse_decimal(frame.substr(4, 8), sign, Unit::kMillimetre);
  if (!result) return result;
  if (frame[1] - '0' != channel) return tl::unexpected(FaultKind::kWrongChannel);
  if (result->decimals >= kInchDecimals) result->unit = Unit::kInch;
  return result;
}

std::string_view says(std::string_view frame) noexcept {
  if (frame == "911\r") return "no data: the dial moves fast, is off, or is unplugged";
  if (frame == "912\r") return "the multiplexer does not understand the question";
  if (frame == "918\r") return "the multiplexer is busy";
  if (frame == "919\r") return "the multiplexer reports an error of its own";
  return "";
}

bool unasked(std::string_view) noexcept { return false; }

std::string request(int channel) { return fmt::format("{}\r", channel); }

}  // namespace

extern constinit const DialProtocol mux10{
    .name = "mux10",
    .line = {.baud = 9600, .data_bits = 8, .parity = Parity::kNone, .stop_bits = 1},
    .frame_end = "\r",
    .channels = 6,
    .identity_request = "",
    .request = request,
    .parse = parse,
    .says = says,
    .unasked = unasked,
    .maker = "Mitutoyo MUX-10 and kin",
    .wiring = "Digimatic dials behind one multiplexer",
    .advice =
        "One port for all: channel is the socket at the multiplexer. A scan of six takes 0.4 "
        "to 1 s, each reading\n"
        "keeps its own time; the robot must stand still meanwhile, which collecting waits for.",
    .example_port = "Mitutoyo_MUX-10",
    .example_serial = 3001};

}  // namespace sixdial::acquisition
