#include "acquisition/robots/modbus_robot.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "acquisition/bus.h"
#include "acquisition/connection_text.h"
#include "acquisition/longest_silence.h"
#include "acquisition/robot_driver.h"
#include "acquisition/robots/open_robot.h"

namespace sixdial::acquisition {
namespace {

using std::chrono::milliseconds;

constexpr int kHolding = 3;
constexpr int kInput = 4;
constexpr int kTarget = 0;        // holding; behind the targets come command and speed
constexpr int kAfterJoints = 5;   // input: status, moves, temperature, fault, cycle
constexpr int kJointCount = 200;  // input; controllers of two joints need not have it
constexpr std::uint16_t kStart = 1;
constexpr std::uint16_t kStop = 2;
constexpr double kDegCPerCount = 0.01;
constexpr milliseconds kPoll{20};
constexpr milliseconds kLeastPollOnWall{2};
// The controller takes a command within a control cycle or two.
constexpr milliseconds kTaken{2000};
// One lost answer, and one back-off after it, is no failed move.
constexpr int kLinkTries = 4;

RobotFault link_fault(const Fault& fault) {
  return {
      RobotFaultKind::kLink,
      fmt::format("robot controller, {}: {}", reason(fault.kind), fault.detail)};
}

RobotFault controller_fault(int code) {
  switch (code) {
    case 1:
      return {RobotFaultKind::kUnreachable, "the controller refuses the target: out of reach"};
    case 2:
      return {RobotFaultKind::kHalted, "the robot was stopped on its way"};
    default:
      return {
          RobotFaultKind::kController,
          fmt::format("fault {}, which its manual explains", code)};
  }
}

bool fits(double q, double per_count) {
  const double counts = q / per_count;
  return std::isfinite(counts) && std::abs(counts) < std::numeric_limits<std::int32_t>::max();
}

}  // namespace

std::vector<RobotJoint> two_turning_joints() { return {{"q1", true}, {"q2", true}}; }

ModbusRobot::ModbusRobot(
    const ModbusConnection& connection, Clock& clock, std::span<const RobotJoint> joints)
    : unit_word_(std::ranges::all_of(joints, &RobotJoint::turns) ? "rad" : "rad, mm"),
      joints_checked_(joints.size() == 2),
      unit_(connection.map.unit),
      clock_(clock),
      link_(connection.endpoint, connection.timeout, connection.quiet, clock) {
  for (const RobotJoint& joint : joints) {
    per_count_.push_back(joint.turns ? kRadPerCount : kMmPerCount);
  }
}

RobotState ModbusRobot::state_of(const Words& words) const {
  RobotState state;
  state.q.resize(joints());
  for (int joint = 0; joint < joints(); ++joint) {
    const auto at = static_cast<std::size_t>(2 * joint);
    state.q[joint] =
        int32_of(words[at], words[at + 1]) * per_count_[static_cast<std::size_t>(joint)];
  }
  const std::span<const std::uint16_t> more =
      std::span(words).subspan(static_cast<std::size_t>(2 * joints()));
  state.motion = more[0] <= 3 ? static_cast<Motion>(more[0]) : Motion::kFault;
  state.moves = more[1];
  state.temperature_c = static_cast<std::int16_t>(more[2]) * kDegCPerCount;
  state.fault_code = more[3];
  state.cycle = more[4];
  return state;
}

// With another number of joints every register behind them is another one: status would be read
// from a joint's value. A controller that cannot tell has two.
tl::expected<void, RobotFault> ModbusRobot::check_joints(const std::stop_token& stop) {
  if (joints_checked_) return {};
  const auto count = read(kInput, kJointCount, 1, stop);
  if (!count && !is_illegal_address(count.error())) {
    return tl::unexpected(link_fault(count.error()));
  }
  const int has = count ? count->front() : 2;
  if (has != joints()) {
    return tl::unexpected(RobotFault{
        RobotFaultKind::kController,
        fmt::format(
            "the controller has {} joints{}, the rig file has {}: look at its [[joint]] rows "
            "and at the controller's address",
            has,
            count ? "" : fmt::format(" (no input register {} says otherwise)", kJointCount),
            joints())});
  }
  joints_checked_ = true;
  return {};
}

LinkState ModbusRobot::link_state() const {
  const std::lock_guard lock(mutex_);
  return link_.state();
}

// Reading is repeatable: tried again through a reconnection.
tl::expected<Words, Fault> ModbusRobot::read(
    int function, int address, int count, const std::stop_token& stop) {
  for (int attempt = 1;; ++attempt) {
    DeviceTime next_try{0};
    {
      const std::lock_guard lock(mutex_);
      const DeviceTime asked = clock_.monotonic();
      const bool really = link_.next_try() <= asked;  // else it only backs off
      auto words = link_.read(unit_, function, address, count, stop);
      silence_.note(words || words.error().kind == FaultKind::kDevice, asked);
      // Nobody waits through long back-offs for a controller that is gone: a person is told.
      const bool given_up = really && silent_for() >= longest_silence(clock_);
      if (words || words.error().kind == FaultKind::kDevice || attempt == kLinkTries ||
          given_up) {
        return words;
      }
      next_try = link_.next_try();
    }
    if (!clock_.sleep_until(next_try, stop)) {
      return tl::unexpected(Fault{FaultKind::kTimeout, "stopped"});
    }
  }
}

tl::expected<void, Fault> ModbusRobot::write(
    int address, const Words& words, const std::stop_token& stop) {
  const std::lock_guard lock(mutex_);
  const DeviceTime asked = clock_.monotonic();
  auto written = link_.write(unit_, address, words, stop);
  silence_.note(written || written.error().kind == FaultKind::kDevice, asked);
  return written;
}

tl::expected<std::optional<int>, RobotFault> ModbusRobot::speed(const std::stop_token& stop) {
  if (const auto same = check_joints(stop); !same) return tl::unexpected(same.error());
  const auto words = read(kHolding, speed_register(), 1, stop);
  if (!words) return tl::unexpected(link_fault(words.error()));
  return std::optional<int>(words->front());
}

tl::expected<RobotState, RobotFault> ModbusRobot::state(const std::stop_token& stop) {
  if (const auto same = check_joints(stop); !same && !stop.stop_requested()) {
    return tl::unexpected(same.error());
  }
  const auto words = read(kInput, 0, 2 * joints() + kAfterJoints, stop);
  if (!words) {
    if (stop.stop_requested())
      return tl::unexpected(RobotFault{RobotFaultKind::kCancelled, ""});
    return tl::unexpected(link_fault(words.error()));
  }
  return state_of(*words);
}

tl::expected<void, RobotFault> ModbusRobot::set_speed(
    int percent, const std::stop_token& stop) {
  if (const auto same = check_joints(stop); !same) return tl::unexpected(same.error());
  const auto speed = static_cast<std::uint16_t>(std::clamp(percent, 1, 100));
  const auto written = write(speed_register(), {speed}, stop);
  if (!written) return tl::unexpected(link_fault(written.error()));
  return {};
}

tl::expected<void, RobotFault> ModbusRobot::halt(const std::stop_token& stop) {
  const auto written = write(command_register(), {kStop}, stop);
  if (!written) return tl::unexpected(link_fault(written.error()));
  return {};
}

// Target and command in one write. A lost answer leaves open whether the move began: the count
// of moves says so before it is sent again.
tl::expected<void, RobotFault> ModbusRobot::start(
    const Eigen::VectorXd& q, std::uint16_t moves_before, const std::stop_token& stop) {
  Words words;
  for (Eigen::Index j = 0; j < q.size(); ++j) {
    const double counts = q[j] / per_count_[static_cast<std::size_t>(j)];
    append_int32(words, static_cast<std::int32_t>(std::lround(counts)));
  }
  words.push_back(kStart);
  for (int attempt = 1;; ++attempt) {
    const auto written = write(kTarget, words, stop);
    if (written) return {};
    if (written.error().kind == FaultKind::kDevice || attempt == kLinkTries) {
      return tl::unexpected(link_fault(written.error()));
    }
    const auto now = state(stop);
    if (!now) return tl::unexpected(now.error());
    if (now->moves != moves_before) return {};
  }
}

tl::expected<RobotState, RobotFault> ModbusRobot::wait_in_position(
    std::uint16_t moves_before, DeviceTime deadline, const std::stop_token& stop) {
  const DeviceTime taken_by = clock_.monotonic() + at_least_on_wall(clock_, kTaken, kTaken);
  for (;;) {
    // The command before the state: once it reads 0, the state is that of after it.
    const auto command = read(kHolding, command_register(), 1, stop);
    if (stop.stop_requested())
      return tl::unexpected(RobotFault{RobotFaultKind::kCancelled, ""});
    if (!command) return tl::unexpected(link_fault(command.error()));
    const auto now = state(stop);
    if (!now) return now;
    const bool taken = command->front() == 0;
    const bool started = now->moves != moves_before;
    if (taken && now->motion == Motion::kFault) {
      return tl::unexpected(controller_fault(now->fault_code));
    }
    if (taken && started && now->motion == Motion::kInPosition) return now;
    if (!(taken && started) && clock_.monotonic() > taken_by) {
      return tl::unexpected(RobotFault{
          RobotFaultKind::kController, "the controller does not take the start command"});
    }
    if (clock_.monotonic() > deadline) {
      return tl::unexpected(RobotFault{
          RobotFaultKind::kNotThere,
          fmt::format("still at {:.6f} {}", fmt::join(now->q, ", "), unit_word_)});
    }
    clock_.sleep_for(at_least_on_wall(clock_, kPoll, kLeastPollOnWall), stop);
  }
}

tl::expected<RobotState, RobotFault> ModbusRobot::move_to(
    const Eigen::VectorXd& q, milliseconds timeout, const std::stop_token& stop) {
  bool good = q.size() == joints();
  for (Eigen::Index j = 0; good && j < q.size(); ++j) {
    good = fits(q[j], per_count_[static_cast<std::size_t>(j)]);
  }
  if (!good) {
    return tl::unexpected(RobotFault{
        RobotFaultKind::kUnreachable,
        fmt::format(
            "{} {} does not fit the controller's registers", fmt::join(q, ", "), unit_word_)});
  }
  const auto before = state(stop);
  if (!before) return before;
  if (const auto started = start(q, before->moves, stop); !started) {
    return tl::unexpected(started.error());
  }
  const DeviceTime deadline =
      clock_.monotonic() +
      at_least_on_wall(clock_, timeout, std::min(timeout, milliseconds{2000}));
  auto there = wait_in_position(before->moves, deadline, stop);
  if (!there && (there.error().kind == RobotFaultKind::kCancelled ||
                 there.error().kind == RobotFaultKind::kNotThere)) {
    // Not to be left running with nobody watching. Best effort: the cause is reported anyway.
    (void)halt(std::stop_token{});
  }
  return there;
}

namespace {

/// What follows "modbus-tcp:".
ModbusConnection connection_from(std::string_view rest) {
  static constexpr std::array<std::string_view, 3> kKeys{"unit", "timeout_ms", "quiet_ms"};
  if (!rest.starts_with("//")) refuse("write modbus-tcp://HOST:PORT");
  return tcp_connection(rest.substr(2), kKeys);
}

OpenRobot parse(std::string_view rest, std::span<const RobotJoint> joints) {
  if (joints.empty() || joints.size() > kMostModbusJoints) {
    refuse(
        "a Modbus controller has 1 to {} joints, this robot has {}", kMostModbusJoints,
        joints.size());
  }
  return opens<ModbusRobot>(joints, connection_from(rest));
}

}  // namespace

tl::expected<ModbusConnection, std::string> parse_modbus_robot(std::string_view text) {
  constexpr std::string_view kScheme = "modbus-tcp:";
  try {
    if (!text.starts_with(kScheme)) refuse("write modbus-tcp://HOST:PORT");
    return connection_from(text.substr(kScheme.size()));
  } catch (const Refused& refused) {
    return tl::unexpected(refused_connection(text, refused));
  }
}

extern constinit const RobotDriver modbus_tcp_robot{
    .scheme = "modbus-tcp",
    .form = "modbus-tcp://HOST:PORT",
    .in_words = "a controller with the registers below",
    .options = "`unit`, `timeout_ms`, `quiet_ms`",
    .parse = parse};

}  // namespace sixdial::acquisition
