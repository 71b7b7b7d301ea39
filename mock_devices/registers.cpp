#include "mock_devices/registers.h"

#include <bit>
#include <cmath>

namespace sixdial::mock_devices {
namespace {

constexpr double kRadPerCount = 1e-8;
constexpr std::uint32_t kInvalid = 0x80000000U;
constexpr std::uint16_t kStatus = 100;
constexpr std::uint16_t kFloats = 8000;
constexpr std::uint16_t kJointCount = 200;

std::uint16_t high(std::uint32_t value) { return static_cast<std::uint16_t>(value >> 16); }
std::uint16_t low(std::uint32_t value) { return static_cast<std::uint16_t>(value & 0xFFFFU); }

std::uint16_t half(std::uint32_t value, std::size_t index) {
  return index % 2 == 0 ? high(value) : low(value);
}

std::uint32_t counts_of(double q_rad) {
  return static_cast<std::uint32_t>(
      static_cast<std::int32_t>(std::lround(q_rad / kRadPerCount)));
}

double rad_of(std::uint16_t high_word, std::uint16_t low_word) {
  const std::uint32_t bits = static_cast<std::uint32_t>(high_word) << 16 | low_word;
  return static_cast<double>(static_cast<std::int32_t>(bits)) * kRadPerCount;
}

}  // namespace

std::optional<std::vector<std::uint16_t>> DialRegisterMap::read(
    RegisterTable /*table*/, std::uint16_t address, std::uint16_t count) {
  const DialScan scan = scan_();
  const std::size_t n = scan.dials.size();
  std::vector<std::uint16_t> values;
  for (std::size_t at = address; at < static_cast<std::size_t>(address) + count; ++at) {
    if (at < 2 * n) {
      const DialRegisters& dial = scan.dials[at / 2];
      const auto bits = static_cast<std::uint32_t>(dial.counts);
      values.push_back(half(dial.valid ? bits : kInvalid, at));
    } else if (at >= kStatus && at < kStatus + n) {
      values.push_back(scan.dials[at - kStatus].status);
    } else if (at == kStatus + n) {
      values.push_back(scan.scan);
    } else if (at >= kFloats && at < kFloats + 2 * n) {
      const DialRegisters& dial = scan.dials[(at - kFloats) / 2];
      const float shown = dial.valid ? dial.shown : std::nanf("");
      values.push_back(half(std::bit_cast<std::uint32_t>(shown), at));
    } else {
      return std::nullopt;
    }
  }
  return values;
}

std::optional<ModbusException> DialRegisterMap::write(
    std::uint16_t /*address*/, std::span<const std::uint16_t> /*values*/) {
  return ModbusException::kIllegalAddress;
}

std::optional<std::vector<std::uint16_t>> RobotRegisterMap::read(
    RegisterTable table, std::uint16_t address, std::uint16_t count) {
  const std::size_t end = static_cast<std::size_t>(address) + count;
  if (table == RegisterTable::kHolding) {
    if (end > holding_.size()) return std::nullopt;
    return std::vector<std::uint16_t>(
        holding_.begin() + address, holding_.begin() + static_cast<std::ptrdiff_t>(end));
  }
  if (port_.joints != 2 && address == kJointCount && count == 1) {
    return std::vector{static_cast<std::uint16_t>(port_.joints)};
  }
  const RobotReport report = port_.report();
  std::vector<std::uint16_t> input;
  for (const double q_rad : report.q_rad) {
    const std::uint32_t counts = counts_of(q_rad);
    input.insert(input.end(), {high(counts), low(counts)});
  }
  const auto temperature = static_cast<std::int16_t>(std::lround(report.temperature_c * 100.0));
  input.insert(
      input.end(), {static_cast<std::uint16_t>(report.state), report.moves_started,
                    static_cast<std::uint16_t>(temperature),
                    static_cast<std::uint16_t>(report.fault), report.cycles});
  if (end > input.size()) return std::nullopt;
  return std::vector<std::uint16_t>(
      input.begin() + address, input.begin() + static_cast<std::ptrdiff_t>(end));
}

std::optional<ModbusException> RobotRegisterMap::write(
    std::uint16_t address, std::span<const std::uint16_t> values) {
  const std::size_t at_command = 2 * port_.joints;
  const std::size_t at_speed = at_command + 1;
  if (address + values.size() > holding_.size()) return ModbusException::kIllegalAddress;
  // All or nothing: a bad value leaves every register as it was.
  auto changed = holding_;
  std::copy(values.begin(), values.end(), changed.begin() + address);
  const std::uint16_t command = changed[at_command];
  if (command > 2 || changed[at_speed] < 1 || changed[at_speed] > 100) {
    return ModbusException::kIllegalValue;
  }
  changed[at_command] = 0;  // taken
  holding_ = changed;
  if (command == 1) {
    Eigen::VectorXd q_rad(static_cast<Eigen::Index>(port_.joints));
    for (std::size_t j = 0; j < port_.joints; ++j) {
      q_rad[static_cast<Eigen::Index>(j)] = rad_of(holding_[2 * j], holding_[2 * j + 1]);
    }
    port_.start(q_rad, holding_[at_speed]);
  } else if (command == 2) {
    port_.stop();
  }
  return std::nullopt;
}

}  // namespace sixdial::mock_devices
