#include "acquisition/fault.h"

#include <fmt/format.h>

namespace sixdial::acquisition {

std::string_view reason(FaultKind kind) {
  switch (kind) {
    case FaultKind::kTimeout:
      return "timeout";
    case FaultKind::kDisconnected:
      return "disconnected";
    case FaultKind::kBadFrame:
      return "parse";
    case FaultKind::kWrongChannel:
      return "channel";
    case FaultKind::kRange:
      return "range";
    case FaultKind::kUnit:
      return "unit";
    case FaultKind::kDevice:
      return "device";
    case FaultKind::kNoDial:
      return "no dial";
    case FaultKind::kBusy:
      return "busy";
    case FaultKind::kWrongDial:
      return "identity";
    case FaultKind::kStale:
      return "stale";
  }
  return "unknown";
}

std::string_view advice(FaultKind kind) {
  switch (kind) {
    case FaultKind::kTimeout:
      return "is the dial switched on, and is its cable the right one?";
    case FaultKind::kDisconnected:
      return "plug the adapter or the network cable in again; it is taken up by itself";
    case FaultKind::kBadFrame:
      return "check dialect, baud rate and parity of the connection string";
    case FaultKind::kWrongChannel:
      return "check channel, index or unit of the connection string, and the cables' order";
    case FaultKind::kRange:
      return "check travel in the rig file, the dial's preset, and word_order on Modbus";
    case FaultKind::kUnit:
      return "switch the dial to mm";
    case FaultKind::kDevice:
      return "read the dial's display; its battery may be low";
    case FaultKind::kNoDial:
      return "plug the dial into its channel";
    case FaultKind::kBusy:
      return "wait; if it stays, slow the scan down";
    case FaultKind::kWrongDial:
      return "put the dial back on its cable, or start again with the new one";
    case FaultKind::kStale:
      return "the gauge box answers but no longer measures: switch it off and on";
  }
  return "";
}

std::string printable(std::string_view bytes) {
  std::string text = "'";
  for (const char c : bytes) {
    const auto code = static_cast<unsigned char>(c);
    if (c == '\r') {
      text += "\\r";
    } else if (c == '\n') {
      text += "\\n";
    } else if (code < 0x20 || code > 0x7e) {
      text += fmt::format("\\x{:02x}", code);
    } else {
      text += c;
    }
    if (text.size() > 80) {
      text += "...";
      break;
    }
  }
  return text + "'";
}

}  // namespace sixdial::acquisition
