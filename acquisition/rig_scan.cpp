#include "acquisition/rig_scan.h"

#include <fmt/format.h>
#include <libserialport.h>

#include <algorithm>
#include <array>
#include <set>

#include "acquisition/connection.h"
#include "acquisition/dial_bank.h"
#include "acquisition/plausibility.h"
#include "acquisition/port_rights.h"
#include "acquisition/robot_driver.h"
#include "acquisition/serial_port.h"
#include "session/reason.h"

namespace sixdial::acquisition {
namespace {

using std::chrono::milliseconds;
using std::chrono::steady_clock;

constexpr milliseconds kWrite{200};
constexpr milliseconds kAnswer{350};
constexpr int kMostLines = 4;  // greetings and pressed keys before the answer
constexpr int kTries = 3;
constexpr double kImplausible_mm = 5.0;
constexpr int kBoxDials = 6;

constexpr std::array kKinds{
    FaultKind::kTimeout,      FaultKind::kDisconnected, FaultKind::kBadFrame,
    FaultKind::kWrongChannel, FaultKind::kRange,        FaultKind::kUnit,
    FaultKind::kDevice,       FaultKind::kNoDial,       FaultKind::kBusy,
    FaultKind::kWrongDial,    FaultKind::kStale};

// A line that only this dialect can have sent, even if it is no value.
bool speaks(const tl::expected<DialFrame, FaultKind>& parsed) {
  return parsed || (parsed.error() != FaultKind::kBadFrame);
}

struct Heard {
  bool anything = false;    // some bytes came
  bool understood = false;  // in this dialect
  std::optional<FoundDial> dial;
};

Heard ask(
    SerialPort& port, const DialProtocol& protocol, int channel, const std::string& name,
    Clock& clock, const std::stop_token& stop) {
  Heard heard;
  if (!port.drain_until(steady_clock::now(), stop)) return heard;
  const DeviceTime requested = clock.monotonic();
  if (!port.write(protocol.request(channel), kWrite)) return heard;
  const auto deadline = steady_clock::now() + kAnswer;
  for (int line = 0; line < kMostLines; ++line) {
    const auto frame = port.read_frame(protocol.frame_end, deadline, stop);
    if (!frame) {
      heard.anything = heard.anything || frame.error().kind == FaultKind::kBadFrame;
      return heard;
    }
    heard.anything = true;
    std::string_view text = *frame;
    if (protocol.frame_end == "\r" && text.starts_with('\n')) text.remove_prefix(1);
    if (protocol.unasked(text)) {
      heard.understood = true;
      continue;
    }
    const auto parsed = protocol.parse(text, channel);
    if (!speaks(parsed)) continue;
    heard.understood = true;
    if (!parsed && parsed.error() == FaultKind::kNoDial) return heard;
    FoundDial dial;
    dial.connection = fmt::format("serial:{}?dialect={}", name, protocol.name);
    if (protocol.channels > 0) dial.connection += fmt::format("&channel={}", channel);
    dial.answer = printable(text);
    // The travel is the rig file's to know: here any length a dial can have.
    constexpr double kAnyTravel_mm = 1000.0;
    const auto value = parsed ? displacement_mm(*parsed, 0.001, kAnyTravel_mm)
                              : tl::expected<double, FaultKind>(tl::unexpected(parsed.error()));
    dial.reading =
        value ? without_end_stop(good_reading(*value, requested, clock.now_utc()))
              : bad_reading(Fault{value.error(), dial.answer}, requested, clock.now_utc());
    heard.dial = std::move(dial);
    return heard;
  }
  return heard;
}

// All dials of a rig whose connection strings are `text` with index 0, 1, ...
std::vector<FoundDial> box_dials(
    const std::string& text, int attempts, Clock& clock, const std::stop_token& stop,
    std::string& trouble) {
  geometry::Rig rig;
  for (int i = 0; i < kBoxDials; ++i) {
    geometry::Dial dial;
    dial.id = std::to_string(i);
    dial.geometry.travel_mm = 1000.0;
    dial.connection = fmt::format("{}&index={}&quiet_ms=0", text, i);
    rig.dials.push_back(dial);
  }
  const auto bank = DialBank::open(rig, clock);
  if (!bank) {
    trouble = bank.error();
    return {};
  }
  std::vector<Reading> readings;
  for (int attempt = 0; attempt < attempts; ++attempt) {
    readings = (*bank)->scan(stop);
    if (std::ranges::any_of(
            readings, [](const Reading& r) { return r.reason != session::reason::kTimeout; })) {
      break;
    }
  }
  std::vector<FoundDial> found;
  for (std::size_t i = 0; i < readings.size(); ++i) {
    const Reading& reading = readings[i];
    const bool there = reading.value_mm || reading.quality != session::Quality::kBad ||
                       reading.reason == reason(FaultKind::kRange) ||
                       reading.reason == reason(FaultKind::kUnit);
    if (there) {
      found.push_back(
          {fmt::format("{}&index={}", text, i), fmt::format("register {}", 2 * i), reading});
    } else {
      trouble = fmt::format("{}, {}", reading.reason, reading.detail);
    }
  }
  return found;
}

bool same_place(const std::string& a, const std::string& b) {
  return a.substr(0, a.find('&')) == b.substr(0, b.find('&'));
}

// Where a silent dial may be: a dial that answers and that nobody in the rig file has.
std::string perhaps_at(
    const CheckedRig& checked, std::span<const ScannedPlace> found,
    std::set<std::string>& given) {
  for (const ScannedPlace& place : found) {
    for (const FoundDial& dial : place.dials) {
      const bool taken = std::ranges::any_of(checked.dials, [&](const CheckedDial& each) {
        return each.good && (each.connection == dial.connection ||
                             (each.connection.starts_with("modbus") &&
                              same_place(each.connection, dial.connection)));
      });
      if (!taken && given.insert(dial.connection).second) return dial.connection;
    }
  }
  return {};
}

void check_robot(
    const geometry::Rig& rig, CheckedRig& checked, Clock& clock, const std::stop_token& stop) {
  const auto connection = robot_connection_of(rig);
  if (!connection) {
    checked.robot_trouble = connection.error();
    checked.robot_fix = "correct `connection` of [robot] in the rig file";
    return;
  }
  if (connection->driver->by_hand) return;  // nobody to ask
  const auto robot = connection->open({.clock = clock});
  const auto state = robot->state(stop);
  if (state) {
    if (state->q.size() > 0) checked.robot = *state;  // else it knows nothing before it moves
    if (state->motion == Motion::kFault) {
      checked.robot_trouble = fmt::format("the controller reports fault {}", state->fault_code);
      checked.robot_fix = "clear it at the controller; the next good move does so, too";
    }
    return;
  }
  checked.robot_trouble =
      fmt::format("{}: {}", describe(state.error().kind), state.error().detail);
  checked.robot_fix =
      "is the controller switched on, and are host and port in the rig file the right ones?";
}

}  // namespace

std::string advice_for(const std::string& why) {
  for (const FaultKind kind : kKinds) {
    if (reason(kind) == why) return std::string(advice(kind));
  }
  if (why == session::reason::kImplausible)
    return "compare the rig file with how the dials are mounted";
  if (why == session::reason::kLowBattery) return "change the dial's battery";
  if (why == session::reason::kFrozen)
    return "press the dial's hold key; move the spindle by hand and look";
  if (why == session::reason::kNoContact)
    return "the spindle rests at its end stop: does it reach the cuboid?";
  return "look at the dial and its cable";
}

std::vector<PortName> serial_ports(const std::filesystem::path& by_id) {
  std::vector<PortName> ports;
  std::set<std::string> seen;
  std::error_code error;
  for (const auto& entry : std::filesystem::directory_iterator(by_id, error)) {
    std::error_code broken;
    const std::string device = std::filesystem::canonical(entry.path(), broken).string();
    if (broken || !seen.insert(device).second) continue;
    ports.push_back({entry.path().string(), device, entry.path().filename().string()});
  }
  std::ranges::sort(ports, {}, &PortName::name);
  sp_port** listed = nullptr;
  if (sp_list_ports(&listed) == SP_OK) {
    for (sp_port** each = listed; *each != nullptr; ++each) {
      const char* device = sp_get_port_name(*each);
      const char* about = sp_get_port_description(*each);
      if (device == nullptr || !seen.insert(device).second) continue;
      ports.push_back({device, device, about == nullptr ? "" : about});
    }
    sp_free_port_list(listed);
  }
  return ports;
}

namespace {

std::string fix_of(PortTrouble trouble, const std::string& device) {
  switch (trouble) {
    case PortTrouble::kInUse:
      return "end what uses it (a collection that is running shows its dials live)";
    case PortTrouble::kNoRights:
      return rights_advice(device);
    case PortTrouble::kOther:
      break;
  }
  return "plug the adapter in again, or correct the name";
}

}  // namespace

ScannedPlace scan_serial(const std::string& device, Clock& clock, const std::stop_token& stop) {
  ScannedPlace place{.name = device, .dials = {}, .trouble = {}, .fix = {}};
  bool anything = false;
  for (const DialProtocol* protocol : dial_protocols()) {
    if (stop.stop_requested()) return place;
    auto port = SerialPort::open(device, protocol->line);
    if (!port) {
      place.trouble = port.error().detail;
      place.fix = fix_of(port.error().trouble, device);
      return place;
    }
    bool understood = false;
    for (int channel = protocol->channels > 0 ? 1 : 0;
         channel <= protocol->channels && !stop.stop_requested(); ++channel) {
      Heard heard = ask(*port, *protocol, channel, device, clock, stop);
      anything = anything || heard.anything;
      understood = understood || heard.understood;
      if (heard.dial) place.dials.push_back(std::move(*heard.dial));
      if (!heard.understood && !understood) break;
    }
    if (!place.dials.empty()) return place;
    if (understood) {
      place.trouble = fmt::format("a {} answers, but no dial is on it", protocol->name);
      place.fix = std::string(advice(FaultKind::kNoDial));
      return place;
    }
  }
  std::string trouble;
  for (const int baud : {19200, 9600}) {
    if (stop.stop_requested()) return place;
    place.dials = box_dials(
        fmt::format("modbus-rtu:{}?baud={}&parity=N&unit=1", device, baud), 1, clock, stop,
        trouble);
    if (!place.dials.empty()) return place;
  }
  place.trouble = anything ? "something answers, but in no dialect that is known" : "silent";
  place.fix = std::string(advice(anything ? FaultKind::kBadFrame : FaultKind::kTimeout));
  return place;
}

ScannedPlace scan_gauge_box(
    const std::string& host_and_port, Clock& clock, const std::stop_token& stop) {
  ScannedPlace place{.name = host_and_port, .dials = {}, .trouble = {}, .fix = {}};
  place.dials = box_dials(
      fmt::format("modbus-tcp://{}?unit=1", host_and_port), 2, clock, stop, place.trouble);
  if (!place.dials.empty()) {
    place.trouble.clear();
  } else {
    place.fix = "is the gauge box switched on, and are address, port and unit the right ones?";
  }
  return place;
}

bool CheckedRig::good() const {
  return trouble.empty() && robot_trouble.empty() &&
         std::ranges::all_of(dials, [](const CheckedDial& dial) { return dial.good; });
}

CheckedRig check_rig(
    const geometry::Rig& rig, std::span<const ScannedPlace> found, Clock& clock,
    const std::stop_token& stop) {
  CheckedRig checked;
  const auto bank = DialBank::open(rig, clock);
  if (!bank) {
    checked.trouble = bank.error();
    return checked;
  }
  check_robot(rig, checked, clock, stop);
  std::vector<Reading> readings;
  for (int attempt = 0; attempt < kTries && !stop.stop_requested(); ++attempt) {
    readings = (*bank)->scan(stop);
    if (std::ranges::none_of(
            readings, [](const Reading& r) { return r.quality == session::Quality::kBad; })) {
      break;
    }
  }
  if (checked.robot) {
    const Plausibility plausibility(rig, kImplausible_mm);
    plausibility.judge(readings, plausibility.expected_at(checked.robot->q));
  }
  for (std::size_t i = 0; i < readings.size(); ++i) {
    CheckedDial dial{
        .id = rig.dials[i].id,
        .connection = rig.dials[i].connection,
        .reading = readings[i],
        .trouble = {},
        .fix = {}};
    dial.good = readings[i].quality == session::Quality::kGood;
    if (!dial.good) {
      dial.trouble = readings[i].reason;
      if (!readings[i].detail.empty()) dial.trouble += ": " + readings[i].detail;
      dial.fix = advice_for(readings[i].reason);
    }
    checked.dials.push_back(std::move(dial));
  }
  std::set<std::string> given;
  for (CheckedDial& dial : checked.dials) {
    if (dial.good || dial.reading.quality != session::Quality::kBad) continue;
    const std::string other = perhaps_at(checked, found, given);
    if (other.empty()) continue;
    dial.fix += fmt::format(
        "; a dial that no line of the rig file has answers at {}: if it is {}, write "
        "connection = \"{}\"",
        other, dial.id, other);
  }
  return checked;
}

}  // namespace sixdial::acquisition
