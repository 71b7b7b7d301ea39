// Why a reading is doubtful or absent, as ChannelValue::reason keeps it in files and in the
// database. A file from elsewhere may say anything; what this program writes, and asks for
// again, stands here.
//
//   if (value.reason == reason::kNoContact) ...  // the plunger hangs free: no fault
#pragma once

#include <string_view>

namespace sixdial::session::reason {

// Of a device that did not answer well: acquisition/fault.h.
inline constexpr std::string_view kTimeout = "timeout";
inline constexpr std::string_view kDisconnected = "disconnected";
inline constexpr std::string_view kBadFrame = "parse";
inline constexpr std::string_view kWrongChannel = "channel";
inline constexpr std::string_view kRange = "range";
inline constexpr std::string_view kUnit = "unit";
inline constexpr std::string_view kDevice = "device";
inline constexpr std::string_view kNoDial = "no dial";
inline constexpr std::string_view kBusy = "busy";
inline constexpr std::string_view kWrongDial = "identity";
inline constexpr std::string_view kStale = "stale";

// Of a reading that came, but cannot be believed or used as it is.
inline constexpr std::string_view kNoContact = "no contact";     // the plunger hangs free
inline constexpr std::string_view kUnsettled = "unsettled";      // it did not come to rest
inline constexpr std::string_view kLowBattery = "low battery";   // the dial says so
inline constexpr std::string_view kImplausible = "implausible";  // far from the nominal robot's
inline constexpr std::string_view kFrozen = "frozen";  // as at another pose, to the last digit

}  // namespace sixdial::session::reason
