#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "acquisition/bus.h"
#include "acquisition/longest_silence.h"
#include "acquisition/robot.h"

namespace sixdial::acquisition {
namespace {

using std::chrono::milliseconds;

constexpr int kHolding = 3;
constexpr int kInput = 4;
constexpr int kTarget = 0;   // holding 0..3
constexpr int kCommand = 4;  // holding
constexpr int kSpeed = 5;    // holding
constexpr int kStateWords = 9;
constexpr int kJoints = 2;  // whose registers the map has
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

RobotState state_of(const Words& words) {
  RobotState state;
  state.q.resize(kJoints);
  for (int joint = 0; joint < kJoints; ++joint) {
    const auto at = static_cast<std::size_t>(2 * joint);
    state.q[joint] = int32_of(words[at], words[at + 1]) * kRadPerCount;
  }
  state.motion = words[4] <= 3 ? static_cast<Motion>(words[4]) : Motion::kFault;
  state.moves = words[5];
  state.temperature_c = static_cast<std::int16_t>(words[6]) * kDegCPerCount;
  state.fault_code = words[7];
  state.cycle = words[8];
  return state;
}

bool fits(double q_rad) {
  const double counts = q_rad / kRadPerCount;
  return std::isfinite(counts) && std::abs(counts) < std::numeric_limits<std::int32_t>::max();
}

}  // namespace

std::string_view describe(RobotFaultKind kind) {
  switch (kind) {
    case RobotFaultKind::kLink:
      return "the robot controller does not answer";
    case RobotFaultKind::kUnreachable:
      return "the robot cannot reach the target";
    case RobotFaultKind::kHalted:
      return "the robot was stopped";
    case RobotFaultKind::kNotThere:
      return "the robot did not arrive in time";
    case RobotFaultKind::kController:
      return "the robot controller reports a fault";
    case RobotFaultKind::kCancelled:
      return "the move was cancelled";
  }
  return "unknown robot fault";
}

ModbusRobot::ModbusRobot(const ModbusConnection& connection, Clock& clock)
    : unit_(connection.map.unit),
      clock_(clock),
      link_(connection.endpoint, connection.timeout, connection.quiet, clock) {}

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
      note_answer(words || words.error().kind == FaultKind::kDevice, asked);
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
  note_answer(written || written.error().kind == FaultKind::kDevice, asked);
  return written;
}

void ModbusRobot::note_answer(bool came, DeviceTime asked) {
  if (came) {
    silent_since_ = 0;
  } else if (silent_since_ == 0) {
    silent_since_ = std::max<DeviceTime::rep>(1, asked.count());
  }
}

milliseconds ModbusRobot::silent_for() const {
  const DeviceTime::rep since = silent_since_;
  if (since == 0) return milliseconds(0);
  return std::chrono::duration_cast<milliseconds>(clock_.monotonic() - DeviceTime(since));
}

tl::expected<std::optional<int>, RobotFault> ModbusRobot::speed(const std::stop_token& stop) {
  const auto words = read(kHolding, kSpeed, 1, stop);
  if (!words) return tl::unexpected(link_fault(words.error()));
  return std::optional<int>(words->front());
}

tl::expected<RobotState, RobotFault> ModbusRobot::state(const std::stop_token& stop) {
  const auto words = read(kInput, 0, kStateWords, stop);
  if (!words) {
    if (stop.stop_requested())
      return tl::unexpected(RobotFault{RobotFaultKind::kCancelled, ""});
    return tl::unexpected(link_fault(words.error()));
  }
  return state_of(*words);
}

tl::expected<void, RobotFault> ModbusRobot::set_speed(
    int percent, const std::stop_token& stop) {
  const auto speed = static_cast<std::uint16_t>(std::clamp(percent, 1, 100));
  const auto written = write(kSpeed, {speed}, stop);
  if (!written) return tl::unexpected(link_fault(written.error()));
  return {};
}

tl::expected<void, RobotFault> ModbusRobot::halt(const std::stop_token& stop) {
  const auto written = write(kCommand, {kStop}, stop);
  if (!written) return tl::unexpected(link_fault(written.error()));
  return {};
}

// Target and command in one write. A lost answer leaves open whether the move began: the count
// of moves says so before it is sent again.
tl::expected<void, RobotFault> ModbusRobot::start(
    const Eigen::VectorXd& q, std::uint16_t moves_before, const std::stop_token& stop) {
  Words words;
  for (const double q_rad : q) {
    append_int32(words, static_cast<std::int32_t>(std::lround(q_rad / kRadPerCount)));
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
    const auto command = read(kHolding, kCommand, 1, stop);
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
          fmt::format("still at {:.6f} rad", fmt::join(now->q, ", "))});
    }
    clock_.sleep_for(at_least_on_wall(clock_, kPoll, kLeastPollOnWall), stop);
  }
}

tl::expected<RobotState, RobotFault> ModbusRobot::move_to(
    const Eigen::VectorXd& q, milliseconds timeout, const std::stop_token& stop) {
  if (q.size() != kJoints || !std::all_of(q.begin(), q.end(), fits)) {
    return tl::unexpected(RobotFault{
        RobotFaultKind::kUnreachable,
        fmt::format("{} rad does not fit the controller's registers", fmt::join(q, ", "))});
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

}  // namespace sixdial::acquisition
