#include "acquisition/modbus_bus.h"

#include <fmt/format.h>

#include <algorithm>

#include "session/reason.h"

namespace sixdial::acquisition {
namespace {

using std::chrono::milliseconds;

// A box that goes on answering with one and the same scan for longer than this no longer
// measures.
constexpr milliseconds kOldestScan{1000};

}  // namespace

std::optional<Fault> fault_of_status(std::uint16_t status) {
  switch (status) {
    case 0:
    case kStatusNoContact:
    case kStatusLowBattery:
      return std::nullopt;
    case 18:
      return Fault{FaultKind::kRange, "the plunger is below the probe's range (status 18)"};
    case 19:
      return Fault{FaultKind::kRange, "the plunger is beyond the probe's range (status 19)"};
    case 246:
      return Fault{
          FaultKind::kWrongDial,
          "another probe is plugged in than the box expects (status 246)"};
    case 247:
      return Fault{FaultKind::kNoDial, "no probe is plugged in there (status 247)"};
    default:
      return Fault{
          FaultKind::kDevice,
          fmt::format("the box reports status {}, which its manual explains", status)};
  }
}

ModbusBus::ModbusBus(
    const ModbusConnection& connection, std::vector<ModbusBox> boxes, Clock& clock,
    ReadingBoard& board)
    : link_(connection.endpoint, connection.timeout, connection.quiet, clock),
      clock_(clock),
      board_(board) {
  for (ModbusBox& box : boxes) {
    boxes_.emplace_back();
    boxes_.back().is = std::move(box);
    forget(boxes_.back());
  }
  change_status([&](BusStatus& status) { status.name = name_of(connection.endpoint); });
}

void ModbusBus::forget(Box& box) const {
  box.has_status = box.is.map.status >= 0;
  box.has_counter = box.is.map.counter >= 0;
  box.counts = false;
  box.counter.reset();
  box.status.assign(static_cast<std::size_t>(box.is.map.count), 0);
}

void ModbusBus::run(const std::stop_token& stop) {
  while (!stop.stop_requested()) {
    const DeviceTime start = clock_.monotonic();
    bool complete = true;
    for (Box& box : boxes_) {
      if (stop.stop_requested()) break;
      complete = scan(box, stop) && complete;
    }
    change_status([&](BusStatus& status) {
      status.state = link_.state();
      status.reconnections = link_.connections() > 1 ? link_.connections() - 1 : 0;
      if (complete) ++status.scans;
    });
    const bool waiting = clock_.monotonic() < link_.next_try();
    clock_.sleep_until(
        start + (waiting ? at_least_on_wall(clock_, kDownPeriod, milliseconds{20})
                         : at_least_on_wall(clock_, kScanPeriod, kLeastScanPeriod)),
        stop);
  }
  link_.close();
}

bool ModbusBus::scan(Box& box, const std::stop_token& stop) {
  const DeviceTime requested = clock_.monotonic();
  const auto failed = [&](const Fault& fault) {
    if (!stop.stop_requested()) fail(box, fault, requested);
    return false;
  };
  if (known_connection_ != link_.connections()) {
    known_connection_ = link_.connections();
    for (Box& each : boxes_) forget(each);
  }
  // Counter and status before the values: a counter that moved then stands for values at least
  // as new.
  const std::optional<std::uint16_t> counter_before = box.counter;
  if (const auto extras = read_extras(box, stop); !extras) return failed(extras.error());
  if (box.counter != counter_before) {
    box.counts = box.counts || (counter_before && box.counter);
    box.new_at = requested;
  } else if (box.counts) {
    // The scan that was handed out already. Not again; and if it stays, say so.
    if (requested - box.new_at < at_least_on_wall(clock_, kOldestScan, milliseconds{50})) {
      return false;
    }
    return failed(
        Fault{FaultKind::kStale, fmt::format("scan counter stands at {}", *box.counter)});
  }
  const ModbusMap& map = box.is.map;
  const auto words = link_.read(
      map.unit, map.function, map.base, map.count * words_per_value(map.format), stop);
  if (!words) return failed(words.error());
  publish_values(box, *words, requested);
  return true;
}

// Status and counter in one request where they lie together; a box without them is taken as it
// is.
tl::expected<void, Fault> ModbusBus::read_extras(Box& box, const std::stop_token& stop) {
  const ModbusMap& map = box.is.map;
  Words words;
  if (box.has_status && box.has_counter && map.counter == map.status + map.count) {
    bool both = true;
    const auto read = read_extra(box, both, map.status, map.count + 1, words, stop);
    if (!read) return read;
    if (both) {
      box.counter = words.back();
      words.pop_back();
      box.status = words;
      return {};
    }
  }
  if (box.has_status) {
    const auto read = read_extra(box, box.has_status, map.status, map.count, words, stop);
    if (!read) return read;
    if (box.has_status) box.status = words;
  }
  if (box.has_counter) {
    const auto read = read_extra(box, box.has_counter, map.counter, 1, words, stop);
    if (!read) return read;
    if (box.has_counter) box.counter = words.front();
  }
  return {};
}

tl::expected<void, Fault> ModbusBus::read_extra(
    Box& box, bool& has, int address, int count, Words& words, const std::stop_token& stop) {
  auto read = link_.read(box.is.map.unit, box.is.map.function, address, count, stop);
  if (read) {
    words = std::move(*read);
    return {};
  }
  if (!is_illegal_address(read.error())) return tl::unexpected(read.error());
  has = false;
  return {};
}

void ModbusBus::publish_values(const Box& box, const Words& words, DeviceTime requested) {
  const session::TimePoint now = clock_.now_utc();
  const auto width = static_cast<std::size_t>(words_per_value(box.is.map.format));
  const std::span<const std::uint16_t> all(words);
  for (const ModbusDial& dial : box.is.dials) {
    const auto index = static_cast<std::size_t>(dial.index);
    const std::uint16_t status = box.status.at(index);
    const auto publish = [&](Reading reading) {
      board_.publish(dial.limits.dial, std::move(reading));
    };
    const auto refuse = [&](const Fault& fault) {
      change_status([&](BusStatus& each) {
        ++each.faults;
        each.last_fault =
            fmt::format("{} {}: {}", dial.limits.id, reason(fault.kind), fault.detail);
      });
      publish(bad_reading(fault, requested, now));
    };
    if (const auto fault = fault_of_status(status)) {
      refuse(*fault);
      continue;
    }
    if (status == kStatusNoContact) {
      Reading reading = good_reading(0.0, requested, now);
      reading.value_mm.reset();
      reading.reason = session::reason::kNoContact;
      publish(std::move(reading));
      continue;
    }
    const auto value = value_mm(all.subspan(index * width, width), box.is.map);
    if (!value) {
      refuse(Fault{value.error(), "the box marks the value as invalid"});
    } else if (!within_travel(*value, dial.limits.travel_mm)) {
      refuse(Fault{
          FaultKind::kRange, fmt::format(
                                 "{:.3f} mm is outside 0 .. {:.1f} mm; is word_order right?",
                                 *value, dial.limits.travel_mm)});
    } else {
      Reading reading = good_reading(*value, requested, now);
      if (status == kStatusLowBattery) {
        reading.quality = session::Quality::kUncertain;
        reading.reason = session::reason::kLowBattery;
      }
      publish(std::move(reading));
    }
  }
}

void ModbusBus::fail(const Box& box, const Fault& fault, DeviceTime requested) {
  const session::TimePoint now = clock_.now_utc();
  for (const ModbusDial& dial : box.is.dials) {
    board_.publish(dial.limits.dial, bad_reading(fault, requested, now));
  }
  change_status([&](BusStatus& status) {
    ++status.faults;
    status.last_fault = fmt::format("{}: {}", reason(fault.kind), fault.detail);
  });
}

}  // namespace sixdial::acquisition
