#include "acquisition/fault.h"

#include <fmt/format.h>

#include "session/reason.h"

namespace sixdial::acquisition {

std::string_view reason(FaultKind kind) {
  switch (kind) {
    case FaultKind::kTimeout:
      return session::reason::kTimeout;
    case FaultKind::kDisconnected:
      return session::reason::kDisconnected;
    case FaultKind::kBadFrame:
      return session::reason::kBadFrame;
    case FaultKind::kWrongChannel:
      return session::reason::kWrongChannel;
    case FaultKind::kRange:
      return session::reason::kRange;
    case FaultKind::kUnit:
      return session::reason::kUnit;
    case FaultKind::kDevice:
      return session::reason::kDevice;
    case FaultKind::kNoDial:
      return session::reason::kNoDial;
    case FaultKind::kBusy:
      return session::reason::kBusy;
    case FaultKind::kWrongDial:
      return session::reason::kWrongDial;
    case FaultKind::kStale:
      return session::reason::kStale;
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
