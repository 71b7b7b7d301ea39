#include "mock_devices/faults.h"

#include <algorithm>
#include <array>

namespace sixdial::mock_devices {
namespace {

constexpr std::array kFaultNames{
    FaultName{Fault::kSilent, "silent"},
    FaultName{Fault::kLate, "late"},
    FaultName{Fault::kTruncated, "truncated"},
    FaultName{Fault::kStrayLf, "stray_lf"},
    FaultName{Fault::kErrorLine, "error_line"},
    FaultName{Fault::kBusy, "busy"},
    FaultName{Fault::kWrongChannel, "wrong_channel"},
    FaultName{Fault::kInch, "inch"},
    FaultName{Fault::kFrozen, "frozen"},
    FaultName{Fault::kUnsolicitedLine, "unsolicited_line"},
    FaultName{Fault::kPowerOnLine, "power_on_line"},
    FaultName{Fault::kLowBattery, "low_battery"},
    FaultName{Fault::kZeroPressed, "zero_pressed"},
    FaultName{Fault::kHangUp, "hang_up"},
    FaultName{Fault::kNoiseByte, "noise_byte"},
    FaultName{Fault::kCrcError, "crc_error"},
    FaultName{Fault::kWrongUnitId, "wrong_unit_id"},
    FaultName{Fault::kException, "exception"},
};

}  // namespace

std::span<const FaultName> fault_names() { return kFaultNames; }

std::string_view to_string(Fault fault) {
  const auto found = std::ranges::find(kFaultNames, fault, &FaultName::fault);
  return found != kFaultNames.end() ? found->name : "unknown fault";
}

std::optional<Fault> fault_from(std::string_view name) {
  const auto found = std::ranges::find(kFaultNames, name, &FaultName::name);
  if (found == kFaultNames.end()) return std::nullopt;
  return found->fault;
}

void FaultBook::order(std::size_t dial, const FaultOrder& order) {
  const std::lock_guard lock(mutex_);
  const auto length = std::chrono::duration_cast<Clock::duration>(
      std::chrono::duration<double>(order.duration_s));
  entries_.push_back({dial, order, Clock::now() + length, order.duration_s > 0.0});
}

std::vector<FaultBook::Entry>::iterator FaultBook::find(
    std::size_t dial, Fault fault, std::string_view connection) const {
  const Clock::time_point now = Clock::now();
  std::erase_if(entries_, [&](const Entry& e) { return e.timed && now >= e.until; });
  return std::ranges::find_if(entries_, [&](const Entry& e) {
    return e.dial == dial && e.order.fault == fault &&
           (e.order.connection.empty() || e.order.connection == connection);
  });
}

std::optional<FaultOrder> FaultBook::take(
    std::size_t dial, Fault fault, std::string_view connection) {
  const std::lock_guard lock(mutex_);
  const auto entry = find(dial, fault, connection);
  if (entry == entries_.end()) return std::nullopt;
  FaultOrder order = entry->order;
  if (entry->order.count > 0 && --entry->order.count == 0) entries_.erase(entry);
  return order;
}

std::optional<FaultOrder> FaultBook::peek(
    std::size_t dial, Fault fault, std::string_view connection) const {
  const std::lock_guard lock(mutex_);
  const auto entry = find(dial, fault, connection);
  if (entry == entries_.end()) return std::nullopt;
  return entry->order;
}

void FaultBook::clear() {
  const std::lock_guard lock(mutex_);
  entries_.clear();
}

}  // namespace sixdial::mock_devices
