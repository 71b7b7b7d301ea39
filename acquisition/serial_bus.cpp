#include "acquisition/serial_bus.h"

#include <fmt/format.h>

#include "session/reason.h"
#include "session/reason_words.h"

namespace sixdial::acquisition {
namespace {

using std::chrono::milliseconds;
using std::chrono::steady_clock;

constexpr milliseconds kBusyPause{50};
constexpr int kBusyTries = 4;
constexpr milliseconds kWriteTimeout{200};
// A battery dies in days; its question costs a scan.
constexpr std::chrono::seconds kBatteryPeriod{30};

// A frame that belongs to nobody's answer may still be followed by the answer.
bool worth_listening_on(FaultKind kind) {
  return kind == FaultKind::kBadFrame || kind == FaultKind::kWrongChannel;
}

// The true answer to what was asked may still be under way.
bool answer_may_still_come(FaultKind kind) {
  return worth_listening_on(kind) || kind == FaultKind::kTimeout;
}

// "\n" after the frame before; some cables add it.
std::string_view without_stray_line_feed(std::string_view frame) {
  if (frame.starts_with('\n')) frame.remove_prefix(1);
  return frame;
}

/// "no data: the dial moves fast, ... (C answered '911\r')".
std::string answered_in_words(
    const DialProtocol& protocol, const std::string& id, std::string_view line,
    FaultKind kind) {
  std::string_view words = protocol.says == nullptr ? "" : protocol.says(line);
  if (words.empty()) words = session::reason_words(reason(kind));
  return fmt::format("{} ({} answered {})", words, id, printable(line));
}

}  // namespace

SerialBus::SerialBus(
    std::string device, const DialProtocol& protocol, std::vector<SerialDial> dials,
    Clock& clock, ReadingBoard& board)
    : device_(std::move(device)),
      protocol_(protocol),
      dials_(std::move(dials)),
      clock_(clock),
      board_(board) {
  change_status([&](BusStatus& status) { status.name = device_; });
}

void SerialBus::run(const std::stop_token& stop) {
  while (!stop.stop_requested()) {
    const DeviceTime start = clock_.monotonic();
    if (!port_) {
      if (start >= health_.next_try()) connect(stop);
      if (!port_) {
        publish_fault_for_all(down_);
        clock_.sleep_for(at_least_on_wall(clock_, kDownPeriod, milliseconds{20}), stop);
        continue;
      }
    }
    scan(stop);
    clock_.sleep_until(start + at_least_on_wall(clock_, kScanPeriod, kLeastScanPeriod), stop);
  }
  port_.reset();
}

void SerialBus::connect(const std::stop_token& stop) {
  auto opened = SerialPort::open(device_, protocol_.line);
  if (!opened) {
    note_fault(opened.error());
    return;
  }
  port_ = std::move(*opened);
  identity_checked_ = protocol_.identity_request.empty();
  asks_battery_ = !protocol_.battery_request.empty();
  battery_low_ = false;
  battery_next_ = clock_.monotonic() + kBatteryPeriod;
  // What the dial says at power-on is no answer.
  if (const auto dropped = port_->drain_until(steady_clock::now(), stop); !dropped) {
    note_fault(dropped.error());
    return;
  }
  if (opened_before_) change_status([](BusStatus& status) { ++status.reconnections; });
  opened_before_ = true;
}

void SerialBus::scan(const std::stop_token& stop) {
  if (!identity_checked_ && !check_identity(stop)) return;
  if (asks_battery_ && clock_.monotonic() >= battery_next_) ask_battery(stop);
  if (!port_) return;
  for (const SerialDial& dial : dials_) {
    if (stop.stop_requested()) return;
    const DeviceTime requested = clock_.monotonic();
    const auto answer = ask(dial, stop);
    if (stop.stop_requested() && !answer) return;
    if (answer) {
      health_.good();
      Reading reading = good_reading(answer->value_mm, answer->requested, answer->time_utc);
      if (battery_low_) {
        reading.quality = session::Quality::kUncertain;
        reading.reason = session::reason::kLowBattery;
      }
      board_.publish(dial.limits.dial, std::move(reading));
      continue;
    }
    const Fault& fault = answer.error();
    publish_fault(dial, fault, requested);
    note_fault(fault);
    if (!port_) {
      publish_fault_for_all(fault);
      return;
    }
    if (answer_may_still_come(fault.kind)) stay_quiet(stop);
    if (!port_) return;
  }
  change_status([&](BusStatus& status) {
    ++status.scans;
    status.state = health_.state();
  });
}

// Who answers: remembered the first time, compared after each reconnection. A dial that does
// not know the question is taken as it is.
bool SerialBus::check_identity(const std::stop_token& stop) {
  const SerialDial& dial = dials_.front();
  const DeviceTime requested = clock_.monotonic();
  const auto fail = [&](const Fault& fault) {
    publish_fault(dial, fault, requested);
    note_fault(fault);
    if (port_ && answer_may_still_come(fault.kind)) stay_quiet(stop);
    return false;
  };
  if (const auto sent = port_->write(protocol_.identity_request, kWriteTimeout); !sent) {
    return fail(sent.error());
  }
  const auto deadline = steady_clock::now() + clock_.wall_timeout(dial.timeout);
  for (;;) {
    const auto frame = port_->read_frame(protocol_.frame_end, deadline, stop);
    if (stop.stop_requested()) return false;
    if (!frame) {
      if (frame.error().kind == FaultKind::kDisconnected) return fail(frame.error());
      if (!identity_.empty()) return fail(frame.error());
      identity_checked_ = true;
      return fail(frame.error());
    }
    const std::string_view line = without_stray_line_feed(*frame);
    if (protocol_.parse(line, dial.channel)) continue;  // a value: the key was pressed
    if (line.starts_with("ERR")) {
      identity_checked_ = true;
      return true;
    }
    if (identity_.empty()) identity_ = std::string(line);
    if (identity_ != line) {
      return fail(Fault{
          FaultKind::kWrongDial, fmt::format(
                                     "{} answers on {}, before it was {}", printable(line),
                                     device_, printable(identity_))});
    }
    identity_checked_ = true;
    return true;
  }
}

// An answer that does not come changes nothing: whether the dial is there, its readings tell.
void SerialBus::ask_battery(const std::stop_token& stop) {
  battery_next_ = clock_.monotonic() + kBatteryPeriod;
  if (const auto dropped = port_->drain_until(steady_clock::now(), stop); !dropped) {
    return note_fault(dropped.error());
  }
  if (const auto sent = port_->write(protocol_.battery_request, kWriteTimeout); !sent) {
    return note_fault(sent.error());
  }
  const SerialDial& dial = dials_.front();
  const auto deadline = steady_clock::now() + clock_.wall_timeout(dial.timeout);
  for (;;) {
    const auto frame = port_->read_frame(protocol_.frame_end, deadline, stop);
    if (!frame) {
      if (frame.error().kind == FaultKind::kDisconnected) return note_fault(frame.error());
      return stay_quiet(stop);  // the answer may still be under way
    }
    const std::string_view line = without_stray_line_feed(*frame);
    if (protocol_.unasked(line) || protocol_.parse(line, dial.channel)) continue;
    if (line.starts_with("ERR1")) asks_battery_ = false;  // it does not know the question
    if (!line.starts_with("ERR")) battery_low_ = line == protocol_.low_battery;
    return;
  }
}

tl::expected<SerialBus::Answer, Fault> SerialBus::ask(
    const SerialDial& dial, const std::stop_token& stop) {
  for (int attempt = 1;; ++attempt) {
    // Lines that nobody asked for (a pressed key) must not be taken for the answer.
    if (const auto dropped = port_->drain_until(steady_clock::now(), stop); !dropped) {
      return tl::unexpected(dropped.error());
    }
    Answer answer;
    answer.requested = clock_.monotonic();
    if (const auto sent = port_->write(protocol_.request(dial.channel), kWriteTimeout); !sent) {
      return tl::unexpected(sent.error());
    }
    const auto value = listen(dial, stop);
    answer.time_utc = clock_.now_utc();
    if (value) {
      answer.value_mm = *value;
      return answer;
    }
    if (value.error().kind != FaultKind::kBusy || attempt == kBusyTries) {
      return tl::unexpected(value.error());
    }
    if (!clock_.sleep_for(kBusyPause, stop)) return tl::unexpected(value.error());
  }
}

tl::expected<double, Fault> SerialBus::listen(
    const SerialDial& dial, const std::stop_token& stop) {
  const auto deadline = steady_clock::now() + clock_.wall_timeout(dial.timeout);
  std::optional<Fault> noted;
  for (;;) {
    const auto frame = port_->read_frame(protocol_.frame_end, deadline, stop);
    if (!frame) {
      const bool gone = frame.error().kind == FaultKind::kDisconnected;
      return tl::unexpected(noted && !gone ? *noted : frame.error());
    }
    const std::string_view line = without_stray_line_feed(*frame);
    if (protocol_.unasked(line)) continue;
    const auto parsed = protocol_.parse(line, dial.channel);
    const auto value =
        parsed ? displacement_mm(*parsed, dial.limits.resolution_mm, dial.limits.travel_mm)
               : tl::expected<double, FaultKind>(tl::unexpected(parsed.error()));
    if (value) return *value;
    Fault fault{
        value.error(), answered_in_words(protocol_, dial.limits.id, line, value.error())};
    if (!worth_listening_on(fault.kind)) return tl::unexpected(fault);
    if (!noted) noted = fault;
  }
}

void SerialBus::stay_quiet(const std::stop_token& stop) {
  const auto until = steady_clock::now() + clock_.wall_timeout(kQuiet);
  if (const auto dropped = port_->drain_until(until, stop); !dropped) {
    note_fault(dropped.error());
    publish_fault_for_all(dropped.error());
  }
}

void SerialBus::publish_fault(
    const SerialDial& dial, const Fault& fault, DeviceTime requested) {
  board_.publish(dial.limits.dial, bad_reading(fault, requested, clock_.now_utc()));
}

void SerialBus::publish_fault_for_all(const Fault& fault) {
  const DeviceTime now = clock_.monotonic();
  for (const SerialDial& dial : dials_) publish_fault(dial, fault, now);
}

void SerialBus::note_fault(const Fault& fault) {
  const DeviceTime now = clock_.monotonic();
  if (fault.kind == FaultKind::kDisconnected) {
    port_.reset();
    down_ = fault;
    health_.lost(now);
  } else {
    health_.bad(now);
  }
  change_status([&](BusStatus& status) {
    ++status.faults;
    status.state = health_.state();
    status.last_fault = fmt::format("{}: {}", reason(fault.kind), fault.detail);
  });
}

}  // namespace sixdial::acquisition
