#include "acquisition/robots/exec_robot.h"

#include <fmt/format.h>

#include <algorithm>

#include "acquisition/bus.h"
#include "acquisition/child_process.h"
#include "acquisition/connection_text.h"
#include "acquisition/robot_driver.h"
#include "acquisition/robots/exec_command.h"
#include "acquisition/robots/open_robot.h"

namespace sixdial::acquisition {
namespace {

using std::chrono::milliseconds;

constexpr milliseconds kGrace{2000};  // between SIGTERM and SIGKILL

/// The last line that says anything.
std::string last_line(std::string_view text) {
  while (!text.empty() && (text.back() == '\n' || text.back() == '\r' || text.back() == ' ')) {
    text.remove_suffix(1);
  }
  const std::size_t before = text.rfind('\n');
  return text.empty()
             ? std::string("it printed no error")
             : printable(before == std::string_view::npos ? text : text.substr(before + 1));
}

RobotFault fault_of(const ProcessResult& ran, const std::string& program) {
  switch (ran.end) {
    case ProcessEnd::kNotStarted:
      return {
          RobotFaultKind::kController,
          fmt::format(
              "{} cannot be started: {}; give its whole path, and make it executable", program,
              ran.err)};
    case ProcessEnd::kTimeout:
      return {RobotFaultKind::kNotThere, program + " did not end in its time and was killed"};
    case ProcessEnd::kStopped:
      return {RobotFaultKind::kCancelled, program + " was killed"};
    case ProcessEnd::kSignal:
      return {
          RobotFaultKind::kHalted,
          fmt::format("{} was ended by signal {}: {}", program, ran.code, last_line(ran.err))};
    case ProcessEnd::kExited:
      break;
  }
  return {
      ran.code == kUnreachableExit ? RobotFaultKind::kUnreachable : RobotFaultKind::kController,
      fmt::format("{} ended with {}: {}", program, ran.code, last_line(ran.err))};
}

}  // namespace

ExecRobot::ExecRobot(
    std::vector<std::string> words, Clock& clock, std::span<const RobotJoint> joints)
    : words_(std::move(words)),
      joints_(joints.begin(), joints.end()),
      knows_speed_(says_speed(words_)),
      clock_(clock) {}

tl::expected<RobotState, RobotFault> ExecRobot::state(const std::stop_token&) {
  const std::lock_guard lock(mutex_);
  return state_;
}

tl::expected<RobotState, RobotFault> ExecRobot::move_to(
    const Eigen::VectorXd& q, milliseconds timeout, const std::stop_token& stop) {
  if (q.size() != std::ssize(joints_) || !q.allFinite()) {
    return tl::unexpected(RobotFault{
        RobotFaultKind::kUnreachable,
        fmt::format("{} joint values, or one that is no number", q.size())});
  }
  std::stop_source kill;
  std::vector<std::string> words;
  {
    const std::lock_guard lock(mutex_);
    if (running_) {
      return tl::unexpected(
          RobotFault{RobotFaultKind::kController, "another move's command still runs"});
    }
    running_ = kill;
    words = filled_in(words_, joints_, q, percent_);
  }
  const std::stop_callback relay(stop, [&] { kill.request_stop(); });
  const ProcessResult ran = run_program(
      words, clock_.wall_timeout(timeout, std::min(timeout, milliseconds{2000})), kGrace,
      kill.get_token());
  const std::lock_guard lock(mutex_);
  running_.reset();
  if (ran.end != ProcessEnd::kExited || ran.code != 0) {
    RobotFault fault = fault_of(ran, words_.front());
    // By halt(), and not by whoever waits for the move.
    if (ran.end == ProcessEnd::kStopped && !stop.stop_requested()) {
      fault.kind = RobotFaultKind::kHalted;
    }
    // A target that was refused leaves the robot where it was, all others leave it anywhere.
    if (fault.kind != RobotFaultKind::kUnreachable) {
      state_.q.resize(0);
      state_.motion = Motion::kFault;
      state_.fault_code = 2;
    }
    return tl::unexpected(std::move(fault));
  }
  auto answer = parse_exec_output(ran.out, joints_);
  if (!answer) {
    return tl::unexpected(RobotFault{
        RobotFaultKind::kController, fmt::format("{}: {}", words_.front(), answer.error())});
  }
  ++state_.moves;
  ++state_.cycle;
  state_.motion = Motion::kInPosition;
  state_.fault_code = 0;
  state_.q = answer->q ? *std::move(answer->q) : q;
  state_.temperature_c = answer->temperature_c;
  return state_;
}

tl::expected<void, RobotFault> ExecRobot::halt(const std::stop_token&) {
  const std::lock_guard lock(mutex_);
  if (!running_) {
    return tl::unexpected(RobotFault{
        RobotFaultKind::kController,
        "no command runs that could be ended: nothing else stops "
        "this robot from here"});
  }
  running_->request_stop();
  return {};
}

tl::expected<std::optional<int>, RobotFault> ExecRobot::speed(const std::stop_token&) {
  if (!knows_speed_) return std::optional<int>();
  const std::lock_guard lock(mutex_);
  return std::optional<int>(percent_);
}

tl::expected<void, RobotFault> ExecRobot::set_speed(int percent, const std::stop_token&) {
  if (!knows_speed_) {
    return tl::unexpected(RobotFault{
        RobotFaultKind::kController,
        "the command of the rig file does not say {speed_percent}"});
  }
  const std::lock_guard lock(mutex_);
  percent_ = std::clamp(percent, 1, 100);
  return {};
}

namespace {

OpenRobot parse(std::string_view rest, std::span<const RobotJoint> joints) {
  auto words = exec_words(rest, joints);
  if (!words) refuse("{}", words.error());
  return opens<ExecRobot>(joints, *std::move(words));
}

}  // namespace

extern constinit const RobotDriver exec_robot{
    .scheme = "exec",
    .form = "exec:PROGRAM {q1_deg} {q2_deg}",
    .in_words = "a program of your own that moves the robot there and ends",
    .options = "`{q1_deg}`, `{q1_rad}` or `{q1_mm}` of each joint, `{speed_percent}`",
    .runs_programs = true,
    .parse = parse};

}  // namespace sixdial::acquisition
