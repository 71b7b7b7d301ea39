// Every fault of a device on every cable that can show it, and what must be stored.
#pragma once

#include <optional>
#include <set>
#include <string>
#include <vector>

#include "mock_devices/faults.h"
#include "session/session.h"

namespace sixdial::acquisition {

struct Case {
  mock_devices::Fault fault;
  const char* connection;
  session::Quality stored;
  std::set<std::string> reasons;      // any of them; "" is good
  double amount = 0.0;                // of the order; 0: the fault's own
  bool felt = true;                   // a single reading shows it; else only a moved robot does
  std::optional<std::size_t> dial{};  // else each in its turn
};

inline constexpr session::Quality kGood = session::Quality::kGood;
inline constexpr session::Quality kUncertain = session::Quality::kUncertain;
inline constexpr session::Quality kBad = session::Quality::kBad;
using Reasons = std::set<std::string>;

inline const Reasons kMoved{"implausible", "no contact", "range"};
inline const Reasons kDamaged{"parse", "range", "unit", "channel", "unsettled", "implausible"};

// What must be stored for the dial at a point while the fault lasts: every fault on every cable
// that can show it. In order of the faults; what is not here, the cable has no way to show.
inline const std::vector<Case> kCases{
    {mock_devices::Fault::kSilent, "sylvac", kBad, {"timeout"}},
    {mock_devices::Fault::kSilent, "mahr", kBad, {"timeout"}},
    {mock_devices::Fault::kSilent, "mux10", kBad, {"timeout"}},
    {mock_devices::Fault::kSilent, "mw", kBad, {"timeout"}},
    {mock_devices::Fault::kSilent, "modbus_rtu", kBad, {"timeout"}},
    {mock_devices::Fault::kSilent, "modbus-tcp", kBad, {"timeout"}},
    {mock_devices::Fault::kLate, "sylvac", kBad, {"timeout"}, 0.4},
    {mock_devices::Fault::kLate, "mahr", kBad, {"timeout"}, 0.4},
    {mock_devices::Fault::kLate, "mux10", kBad, {"timeout"}, 0.4},
    {mock_devices::Fault::kLate, "mw", kBad, {"timeout"}, 0.4},
    {mock_devices::Fault::kLate, "modbus_rtu", kBad, {"timeout"}, 0.4},
    {mock_devices::Fault::kLate, "modbus-tcp", kBad, {"timeout"}, 0.4},
    {mock_devices::Fault::kTruncated, "sylvac", kBad, {"parse"}},
    {mock_devices::Fault::kTruncated, "mahr", kBad, {"parse"}},
    {mock_devices::Fault::kTruncated, "mux10", kBad, {"parse"}},
    {mock_devices::Fault::kTruncated, "mw", kBad, {"parse"}},
    {mock_devices::Fault::kTruncated, "modbus_rtu", kBad, {"parse", "timeout"}},
    {mock_devices::Fault::kTruncated, "modbus-tcp", kBad, {"parse", "timeout"}},
    // A line feed more is passed over, between lines and between frames.
    {mock_devices::Fault::kStrayLf, "sylvac", kGood, {""}, 0, false},
    {mock_devices::Fault::kStrayLf, "mahr", kGood, {""}, 0, false},
    {mock_devices::Fault::kStrayLf, "mux10", kGood, {""}, 0, false},
    {mock_devices::Fault::kStrayLf, "mw", kGood, {""}, 0, false},
    {mock_devices::Fault::kStrayLf, "modbus_rtu", kGood, {""}, 0, false},
    // On TCP it shifts every later byte of the stream.
    {mock_devices::Fault::kStrayLf, "modbus-tcp", kBad, {"parse", "timeout"}},
    {mock_devices::Fault::kErrorLine, "sylvac", kBad, {"device", "range"}},
    {mock_devices::Fault::kErrorLine, "mahr", kBad, {"device"}},
    {mock_devices::Fault::kErrorLine, "mux10", kBad, {"device", "no dial"}},
    {mock_devices::Fault::kErrorLine, "mw", kBad, {"no dial"}},
    {mock_devices::Fault::kErrorLine,
     "modbus_rtu",
     kBad,
     {"identity"}},  // status 246, wrong probe
    {mock_devices::Fault::kErrorLine, "modbus-tcp", kBad, {"identity"}},
    {mock_devices::Fault::kBusy, "sylvac", kBad, {"device"}},  // as while the spindle moves
    {mock_devices::Fault::kBusy, "mahr", kBad, {"device"}},
    {mock_devices::Fault::kBusy, "mux10", kBad, {"busy"}},
    {mock_devices::Fault::kBusy, "mw", kBad, {"no dial"}},
    {mock_devices::Fault::kBusy, "modbus_rtu", kBad, {"busy", "device"}},
    {mock_devices::Fault::kBusy, "modbus-tcp", kBad, {"busy", "device"}},
    {mock_devices::Fault::kWrongChannel, "mux10", kBad, {"channel"}},
    {mock_devices::Fault::kWrongChannel, "mw", kBad, {"channel"}},
    // A cable or a plug of the box in the wrong place: no byte tells, the value does, unless
    // both dials stand side by side on one face (C and D, E and F) and read nearly the same.
    {mock_devices::Fault::kWrongChannel, "sylvac", kUncertain, kMoved, 0, false, 1},
    {mock_devices::Fault::kWrongChannel, "mahr", kUncertain, kMoved, 0, false, 3},
    {mock_devices::Fault::kWrongChannel, "modbus_rtu", kUncertain, kMoved, 0, false, 0},
    {mock_devices::Fault::kWrongChannel, "modbus-tcp", kUncertain, kMoved, 0, false, 5},
    {mock_devices::Fault::kInch, "sylvac", kBad, {"unit"}},
    {mock_devices::Fault::kInch, "mahr", kBad, {"unit"}},
    {mock_devices::Fault::kInch, "mux10", kBad, {"unit"}},
    {mock_devices::Fault::kInch, "mw", kBad, {"unit"}},
    // The box counts steps of the display: 0.01 mil instead of 1 um, a value 39 times as
    // large.
    {mock_devices::Fault::kInch, "modbus_rtu", kUncertain, kMoved, 0, false},
    {mock_devices::Fault::kInch, "modbus-tcp", kUncertain, kMoved, 0, false},
    {mock_devices::Fault::kFrozen, "sylvac", kBad, {"frozen"}, 0, false},
    {mock_devices::Fault::kFrozen, "mahr", kBad, {"frozen"}, 0, false},
    {mock_devices::Fault::kFrozen, "mux10", kBad, {"frozen"}, 0, false},
    {mock_devices::Fault::kFrozen, "mw", kBad, {"frozen"}, 0, false},
    {mock_devices::Fault::kFrozen, "modbus_rtu", kBad, {"frozen"}, 0, false},
    {mock_devices::Fault::kFrozen, "modbus-tcp", kBad, {"frozen"}, 0, false},
    // The key also freezes the display. A box has no key to its dials.
    {mock_devices::Fault::kUnsolicitedLine, "sylvac", kBad, {"frozen"}, 0, false},
    {mock_devices::Fault::kUnsolicitedLine, "mahr", kBad, {"frozen"}, 0, false},
    {mock_devices::Fault::kUnsolicitedLine, "mux10", kBad, {"frozen"}, 0, false},
    {mock_devices::Fault::kUnsolicitedLine, "mw", kBad, {"frozen"}, 0, false},
    {mock_devices::Fault::kPowerOnLine, "sylvac", kGood, {""}, 0, false},
    // sylvac has a test of its own below; mahr, mux10 and mw do not tell.
    {mock_devices::Fault::kLowBattery, "modbus_rtu", kUncertain, {"low battery"}},
    {mock_devices::Fault::kLowBattery, "modbus-tcp", kUncertain, {"low battery"}},
    {mock_devices::Fault::kZeroPressed, "sylvac", kUncertain, kMoved, 0, false},
    {mock_devices::Fault::kZeroPressed, "mahr", kUncertain, kMoved, 0, false},
    {mock_devices::Fault::kZeroPressed, "mux10", kUncertain, kMoved, 0, false},
    {mock_devices::Fault::kZeroPressed, "mw", kUncertain, kMoved, 0, false},
    {mock_devices::Fault::kZeroPressed, "modbus_rtu", kUncertain, kMoved, 0, false},
    {mock_devices::Fault::kZeroPressed, "modbus-tcp", kUncertain, kMoved, 0, false},
    {mock_devices::Fault::kHangUp, "sylvac", kBad, {"disconnected"}, 8.0},
    {mock_devices::Fault::kHangUp, "mahr", kBad, {"disconnected"}, 8.0},
    {mock_devices::Fault::kHangUp, "mux10", kBad, {"disconnected"}, 8.0},
    {mock_devices::Fault::kHangUp, "mw", kBad, {"disconnected"}, 8.0},
    {mock_devices::Fault::kHangUp, "modbus_rtu", kBad, {"disconnected"}, 8.0},
    {mock_devices::Fault::kHangUp, "modbus-tcp", kBad, {"disconnected", "timeout"}, 8.0},
    {mock_devices::Fault::kNoiseByte, "sylvac", kBad, kDamaged},
    {mock_devices::Fault::kNoiseByte, "mahr", kBad, kDamaged},
    {mock_devices::Fault::kNoiseByte, "mux10", kBad, kDamaged},
    {mock_devices::Fault::kNoiseByte, "mw", kBad, kDamaged},
    {mock_devices::Fault::kNoiseByte, "modbus_rtu", kBad, {"parse", "timeout", "channel"}},
    {mock_devices::Fault::kCrcError, "modbus_rtu", kBad, {"parse", "timeout"}},
    {mock_devices::Fault::kCrcError,
     "modbus-tcp",
     kBad,
     {"parse", "timeout"}},  // another transaction
    {mock_devices::Fault::kWrongUnitId, "modbus_rtu", kBad, {"channel", "timeout"}},
    {mock_devices::Fault::kWrongUnitId, "modbus-tcp", kBad, {"channel"}},
    {mock_devices::Fault::kException, "modbus_rtu", kBad, {"device"}},
    {mock_devices::Fault::kException, "modbus-tcp", kBad, {"device"}}};

}  // namespace sixdial::acquisition
