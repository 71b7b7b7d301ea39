#include "acquisition/dial_bank.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <filesystem>

#include "acquisition/connection.h"
#include "acquisition/modbus_bus.h"
#include "acquisition/serial_bus.h"
#include "session/reason.h"

namespace sixdial::acquisition {
namespace {

using std::chrono::milliseconds;
using std::chrono::steady_clock;

// The slowest rig: six silent dials behind one multiplexer, each with its quiet time after.
constexpr milliseconds kSlowestScan{12'000};
constexpr milliseconds kSlowestScanOnWall{3000};

struct SerialGroup {
  std::string device;
  const DialProtocol* protocol = nullptr;
  std::vector<SerialDial> dials;
};

struct ModbusGroup {
  ModbusConnection connection;
  std::vector<ModbusBox> boxes;
};

// One bus a cable, however its device is called.
std::string same_device(const std::string& device) {
  std::error_code error;
  const std::string resolved = std::filesystem::canonical(device, error).string();
  return error ? device : resolved;
}

class Groups {
 public:
  void add(const DialLimits& limits, const SerialConnection& connection) {
    const auto found =
        std::find_if(serial_.begin(), serial_.end(), [&](const SerialGroup& group) {
          return same_device(group.device) == same_device(connection.device);
        });
    SerialGroup& group =
        found != serial_.end()
            ? *found
            : serial_.emplace_back(SerialGroup{connection.device, connection.protocol, {}});
    if (group.protocol != connection.protocol) {
      fail(
          limits.id,
          fmt::format(
              "{} is already used with dialect {}", connection.device, group.protocol->name));
      return;
    }
    if (!group.dials.empty() && connection.protocol->channels == 0) {
      fail(
          limits.id, fmt::format(
                         "{} is already the cable of dial {}", connection.device,
                         group.dials.front().limits.id));
      return;
    }
    for (const SerialDial& other : group.dials) {
      if (other.channel == connection.channel) {
        fail(
            limits.id,
            fmt::format("channel {} is already dial {}", other.channel, other.limits.id));
        return;
      }
    }
    group.dials.push_back({limits, connection.channel, connection.timeout});
  }

  void add(const DialLimits& limits, const ModbusConnection& connection) {
    const auto found =
        std::find_if(modbus_.begin(), modbus_.end(), [&](const ModbusGroup& group) {
          return group.connection.endpoint == connection.endpoint;
        });
    ModbusGroup& group =
        found != modbus_.end() ? *found : modbus_.emplace_back(ModbusGroup{connection, {}});
    group.connection.timeout = std::max(group.connection.timeout, connection.timeout);
    group.connection.quiet = std::max(group.connection.quiet, connection.quiet);
    const auto same = std::find_if(
        group.boxes.begin(), group.boxes.end(),
        [&](const ModbusBox& box) { return box.map == connection.map; });
    ModbusBox& box = same != group.boxes.end()
                         ? *same
                         : group.boxes.emplace_back(ModbusBox{connection.map, {}});
    const int index = connection.index.value_or(static_cast<int>(box.dials.size()));
    for (const ModbusDial& other : box.dials) {
      if (other.index == index) {
        fail(limits.id, fmt::format("index {} is already dial {}", index, other.limits.id));
        return;
      }
    }
    if (connection.map.count > 0 && index >= connection.map.count) {
      fail(
          limits.id,
          fmt::format("index {} is not below count {}", index, connection.map.count));
      return;
    }
    box.dials.push_back({limits, index});
  }

  void fail(const std::string& dial, const std::string& why) {
    errors_.push_back(fmt::format("dial {}: {}", dial, why));
  }
  [[nodiscard]] const std::vector<std::string>& errors() const { return errors_; }

  std::vector<std::unique_ptr<Bus>> buses(Clock& clock, ReadingBoard& board) {
    std::vector<std::unique_ptr<Bus>> result;
    for (SerialGroup& group : serial_) {
      result.push_back(std::make_unique<SerialBus>(
          group.device, *group.protocol, std::move(group.dials), clock, board));
    }
    for (ModbusGroup& group : modbus_) {
      for (ModbusBox& box : group.boxes) {
        for (const ModbusDial& dial : box.dials) {
          box.map.count = std::max(box.map.count, dial.index + 1);
        }
      }
      result.push_back(
          std::make_unique<ModbusBus>(group.connection, std::move(group.boxes), clock, board));
    }
    return result;
  }

 private:
  std::vector<SerialGroup> serial_;
  std::vector<ModbusGroup> modbus_;
  std::vector<std::string> errors_;
};

}  // namespace

Reading without_end_stop(Reading reading) {
  if (reading.value_mm && std::abs(*reading.value_mm) < kNoContact_mm) {
    reading.value_mm.reset();
    if (reading.reason.empty()) reading.reason = session::reason::kNoContact;
  }
  return reading;
}

DialBank::DialBank(std::size_t dials, Clock& clock)
    : size_(dials), clock_(clock), board_(dials) {}

DialBank::~DialBank() {
  for (std::jthread& worker : workers_) worker.request_stop();
}

tl::expected<std::unique_ptr<DialBank>, std::string> DialBank::open(
    const geometry::Rig& rig, Clock& clock) {
  Groups groups;
  for (std::size_t i = 0; i < rig.dials.size(); ++i) {
    const geometry::Dial& dial = rig.dials[i];
    const auto connection = parse_dial_connection(dial.connection);
    if (!connection) {
      groups.fail(dial.id, connection.error());
      continue;
    }
    const DialLimits limits{
        .dial = i,
        .id = dial.id,
        .resolution_mm = dial.resolution_mm,
        .travel_mm = dial.geometry.travel_mm};
    std::visit([&](const auto& each) { groups.add(limits, each); }, *connection);
  }
  if (!groups.errors().empty()) {
    return tl::unexpected(fmt::format("{}", fmt::join(groups.errors(), "; ")));
  }
  std::unique_ptr<DialBank> bank(new DialBank(rig.dials.size(), clock));
  bank->buses_ = groups.buses(clock, bank->board_);
  for (const auto& bus : bank->buses_) {
    bank->workers_.emplace_back(
        [&each = *bus](const std::stop_token& stop) { each.run(stop); });
  }
  return bank;
}

std::vector<Reading> DialBank::read_since(DeviceTime not_before, const std::stop_token& stop) {
  const auto deadline =
      steady_clock::now() + clock_.wall_timeout(kSlowestScan, kSlowestScanOnWall);
  const bool complete = board_.wait_for_all(not_before, deadline, stop);
  std::vector<Reading> readings = board_.newest();
  for (Reading& reading : readings) {
    if (!complete && (reading.sequence == 0 || reading.requested < not_before)) {
      const std::uint64_t sequence = reading.sequence;
      reading = bad_reading(
          Fault{FaultKind::kTimeout, "the bus gave no answer in time"}, clock_.monotonic(),
          clock_.now_utc());
      reading.sequence = sequence;
    }
    reading = without_end_stop(std::move(reading));
  }
  return readings;
}

std::vector<Reading> DialBank::scan(const std::stop_token& stop) {
  return read_since(clock_.monotonic(), stop);
}

std::vector<Reading> DialBank::latest() const {
  const DeviceTime now = clock_.monotonic();
  const DeviceTime oldest = at_least_on_wall(clock_, kOldestReading, milliseconds{500});
  std::vector<Reading> readings = board_.newest();
  for (Reading& reading : readings) {
    if (reading.value_mm && now - reading.requested > oldest) {
      reading.value_mm.reset();
      reading.quality = session::Quality::kBad;
      reading.reason = std::string(reason(FaultKind::kStale));
    }
    reading = without_end_stop(std::move(reading));
  }
  return readings;
}

std::vector<BusStatus> DialBank::buses() const {
  std::vector<BusStatus> result;
  for (const auto& bus : buses_) result.push_back(bus->status());
  return result;
}

}  // namespace sixdial::acquisition
