// Why a device's answer is no reading: routine on a workshop floor, counted and stored.
#pragma once

#include <string>
#include <string_view>

namespace sixdial::acquisition {

enum class FaultKind {
  kTimeout,       // nothing came in time; the line itself is there
  kDisconnected,  // no port, cable out, connection closed
  kBadFrame,      // bytes that the dialect does not know, or half a frame
  kWrongChannel,  // an answer, but of another dial or unit
  kRange,         // outside the dial's travel, or the dial says so
  kUnit,          // inch
  kDevice,        // the device reports an error of its own
  kNoDial,        // nothing plugged in on that channel
  kBusy,
  kWrongDial,  // after replugging, another dial answers than before
  kStale,      // the device goes on answering with one old scan
};

struct Fault {
  FaultKind kind = FaultKind::kTimeout;
  std::string detail;   // the evidence, for people: "'+012.3' has no end of line"
  int device_code = 0;  // kDevice: the number that the device gave, a Modbus exception; 0: none
};

/// As stored in session::ChannelValue::reason (session/reason.h): "timeout", "parse", ...
[[nodiscard]] std::string_view reason(FaultKind kind);
/// What to do about it.
[[nodiscard]] std::string_view advice(FaultKind kind);
/// Bytes as a person can read them: "+012.3\r" with the control character spelt out.
[[nodiscard]] std::string printable(std::string_view bytes);

}  // namespace sixdial::acquisition
