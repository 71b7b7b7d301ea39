#include "acquisition/robots/linuxcnc/robot.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <utility>

namespace sixdial::acquisition {
namespace {

using std::chrono::milliseconds;
using std::chrono::steady_clock;

constexpr milliseconds kLook{50};     // on the wall, between two looks at a move
constexpr milliseconds kSettle{500};  // on the wall: an order was taken, and has begun by then
constexpr milliseconds kStops{3000};  // device time: it slows down for no longer
constexpr std::string_view kAbort = "set abort\n";
// Inches, steps, work offsets and inverse times of other programs do not count.
constexpr std::string_view kPlain = "G21 G90 G94 G53 ";

RobotFault told_error(const std::string& words) {
  const bool far = words.find("limit") != std::string::npos;
  return {
      far ? RobotFaultKind::kUnreachable : RobotFaultKind::kController,
      fmt::format("LinuxCNC says: {}", words)};
}

}  // namespace

LinuxCncRobot::LinuxCncRobot(
    AxisSettings settings, CncPasswords passwords, Open open, Clock& clock,
    std::span<const RobotJoint> joints)
    : AxisRobot(std::move(settings), std::move(open), clock, joints),
      passwords_(std::move(passwords)) {}

RobotState LinuxCncRobot::shown_by(const Look& seen) const {
  const bool held = halted_ || seen.program == Program::kPaused;
  const Motion rests = held ? Motion::kFault : Motion::kInPosition;
  return state_of(seen.stands, seen.program == Program::kRunning ? Motion::kMoving : rests);
}

tl::expected<RobotState, RobotFault> LinuxCncRobot::state_now(const std::stop_token& stop) {
  if (const auto good = ready(stop); !good) return tl::unexpected(good.error());
  const auto seen = look(stop);
  if (!seen) return tl::unexpected(seen.error());
  if (seen->locked) return tl::unexpected(*seen->locked);
  return shown_by(*seen);
}

/// After an abort.
tl::expected<void, RobotFault> LinuxCncRobot::wait_until_idle(const std::stop_token& stop) {
  const auto deadline = steady_clock::now() + clock_.wall_timeout(kStops, kStops);
  for (;;) {
    const auto seen = look(stop);
    if (!seen) return tl::unexpected(seen.error());
    if (seen->program == Program::kIdle) return {};
    if (steady_clock::now() >= deadline) {
      return tl::unexpected(RobotFault{
          RobotFaultKind::kController,
          "it was told to stop (set abort) and goes on: use the emergency stop"});
    }
    if (const auto told = tell(kAbort); !told) return told;
    if (!sleep_on_wall(steady_clock::now() + kLook, stop)) {
      return tl::unexpected(RobotFault{RobotFaultKind::kCancelled, ""});
    }
  }
}

tl::expected<void, RobotFault> LinuxCncRobot::ready_to_move(const std::stop_token& stop) {
  const auto seen = look(stop);  // an error from before is read and dropped
  if (!seen) return tl::unexpected(seen.error());
  if (seen->locked) return tl::unexpected(*seen->locked);
  if (seen->program != Program::kIdle) {
    if (!halted_) {
      return tl::unexpected(RobotFault{
          RobotFaultKind::kController,
          "another program runs on the controller: let it end, or stop it there"});
    }
    if (const auto idle = wait_until_idle(stop); !idle) return idle;
  }
  auto ready = set("mode", "mdi", stop);
  if (!ready && ready.error().kind == RobotFaultKind::kController) {
    close_channel();  // a new greeting takes control back
    ready.error().detail += ": has another client taken control? The next move takes it back";
  }
  return ready;
}

// An order is taken before it begins: IDLE counts only where the machine has arrived, or once
// it has been IDLE for a while.
tl::expected<LinuxCncRobot::Look, RobotFault> LinuxCncRobot::wait_for_end(
    const std::vector<double>& target, WallTime deadline, const std::stop_token& stop) {
  bool was_there = false;
  bool was_idle = false;
  WallTime idle_since = steady_clock::now();
  for (;;) {
    auto seen = look(stop);
    if (!seen) return seen;
    if (seen->locked) return tl::unexpected(*seen->locked);
    if (!seen->error.empty()) return tl::unexpected(told_error(seen->error));
    if (stop_asked_) {
      if (const auto idle = wait_until_idle(stop); !idle) return tl::unexpected(idle.error());
      return tl::unexpected(RobotFault{RobotFaultKind::kHalted, "the robot was stopped"});
    }
    if (seen->program == Program::kPaused) {
      return tl::unexpected(
          RobotFault{RobotFaultKind::kHalted, "the move was paused at the machine"});
    }
    const auto now = steady_clock::now();
    if (seen->program == Program::kRunning) {
      was_there = false;
      was_idle = false;
    } else {
      const bool there = !not_there(seen->stands, target);
      if (!std::exchange(was_idle, true)) idle_since = now;
      if ((there && was_there) || now - idle_since > kSettle) return seen;
      was_there = there;
    }
    if (now >= deadline) {
      return tl::unexpected(
          RobotFault{RobotFaultKind::kNotThere, "the move has not ended in its time"});
    }
    if (!sleep_on_wall(now + kLook, stop)) {
      return tl::unexpected(RobotFault{RobotFaultKind::kCancelled, ""});
    }
  }
}

tl::expected<RobotState, RobotFault> LinuxCncRobot::go_to(
    const std::vector<double>& target, milliseconds timeout, const std::stop_token& stop) {
  if (const auto good = ready(stop); !good) return tl::unexpected(good.error());
  if (const auto good = ready_to_move(stop); !good) return tl::unexpected(good.error());
  if (stop_asked_) {
    return tl::unexpected(RobotFault{RobotFaultKind::kHalted, "the robot was stopped"});
  }
  halted_ = false;
  const WallTime deadline = ends_by(timeout);
  ++moves_;
  const std::string words = std::string(kPlain) + move_words(target, feed());
  const auto ended =
      set("mdi", words, stop).and_then([&] { return wait_for_end(target, deadline, stop); });
  if (ended) {
    if (auto fault = not_there(ended->stands, target)) return tl::unexpected(*std::move(fault));
    return shown_by(*ended);
  }
  halted_ = true;
  const RobotFaultKind kind = ended.error().kind;
  // Not to be left running with nobody watching; where the link broke, over a new connection.
  // Best effort: the cause is reported anyway.
  const bool lost_sight = kind == RobotFaultKind::kCancelled ||
                          kind == RobotFaultKind::kNotThere ||
                          (kind == RobotFaultKind::kLink && ready({}));
  if (lost_sight) (void)tell(kAbort);
  return tl::unexpected(ended.error());
}

tl::expected<void, RobotFault> LinuxCncRobot::halt(const std::stop_token& stop) {
  // Whoever moves it looks whether it stands, and says it again otherwise.
  for (;;) {
    if (moving_) stop_asked_ = true;
    if (!moving_) {
      if (const auto turn = turn_of_halt()) {
        if (const auto good = ready(stop); !good) return good;
        const auto seen = look(stop);
        if (!seen) return tl::unexpected(seen.error());
        if (seen->locked) return {};  // nothing moves then
        if (const auto told = set("abort", "", stop); !told) return told;
        halted_ = halted_ || seen->program != Program::kIdle;
        return {};
      }
    }
    const auto told = tell_meanwhile(kAbort);
    if (!told) return tl::unexpected(told.error());
    if (*told) return {};
    std::this_thread::sleep_for(kTurn);  // whoever moves it has just lost the line
  }
}

}  // namespace sixdial::acquisition
