// What is said between the service and a controller that takes G-code, line by line: opening,
// greeting, commands and their answers, a halted move.
#include <fmt/format.h>

#include <algorithm>

#include "acquisition/bus.h"
#include "acquisition/robots/gcode_robot.h"

namespace sixdial::acquisition {
namespace {

using std::chrono::milliseconds;
using std::chrono::steady_clock;

constexpr milliseconds kLook{100};      // on the wall, until a halted machine stands
constexpr milliseconds kSettle{150};    // of a line: what was under way has come by then
constexpr milliseconds kGreeting{700};  // for one hello of several

}  // namespace

RobotFault GcodeRobot::link_fault(const Fault& fault) const {
  return {
      RobotFaultKind::kLink,
      fmt::format(
          "robot controller at {}, {}: {}", settings_.place, reason(fault.kind), fault.detail)};
}

void GcodeRobot::note_answer(bool came) {
  if (came) {
    silent_since_ = 0;
  } else if (silent_since_ == 0) {
    silent_since_ = std::max<DeviceTime::rep>(1, clock_.monotonic().count());
  }
}

milliseconds GcodeRobot::silent_for() const {
  const DeviceTime::rep since = silent_since_;
  if (since == 0) return milliseconds(0);
  return std::chrono::duration_cast<milliseconds>(clock_.monotonic() - DeviceTime(since));
}

GcodeRobot::WallTime GcodeRobot::answer_by() const {
  return steady_clock::now() + clock_.wall_timeout(settings_.timeout);
}

tl::expected<void, RobotFault> GcodeRobot::tell(std::string_view bytes) {
  const std::lock_guard lock(write_mutex_);
  const auto written = channel_->write(bytes, kGcodeWrite);
  if (written) return {};
  note_answer(false);
  in_step_ = false;
  if (written.error().kind == FaultKind::kDisconnected) channel_.reset();
  return tl::unexpected(link_fault(written.error()));
}

// Remarks are passed over. A controller that began anew in between has lost its place.
tl::expected<GcodeLine, RobotFault> GcodeRobot::next_line(
    WallTime deadline, const std::stop_token& stop) {
  for (;;) {
    auto text = channel_->read_line(deadline, stop);
    if (!text) {
      if (stop.stop_requested()) {
        in_step_ = false;
        return tl::unexpected(RobotFault{RobotFaultKind::kCancelled, ""});
      }
      note_answer(false);
      in_step_ = false;
      if (text.error().kind == FaultKind::kDisconnected) {
        const std::lock_guard lock(write_mutex_);
        channel_.reset();
      }
      return tl::unexpected(link_fault(text.error()));
    }
    auto line = settings_.dialect->parse(*text);
    if (!line) {
      note_answer(false);
      in_step_ = false;
      return tl::unexpected(link_fault(
          {FaultKind::kBadFrame, fmt::format(
                                     "{} is no line of {}: look at baud rate and dialect",
                                     printable(*text), settings_.dialect->in_words)}));
    }
    note_answer(true);
    if (line->kind != GcodeLineKind::kRemark) return *std::move(line);
  }
}

/// Reads and drops what is still under way.
void GcodeRobot::quiet_down(const std::stop_token& stop) {
  const auto longest = answer_by();
  while (steady_clock::now() < longest && !stop.stop_requested()) {
    const auto text = channel_->read_line(steady_clock::now() + kSettle, stop);
    if (!text && text.error().kind != FaultKind::kBadFrame) return;
  }
}

// A controller that begins anew when its port is opened hears nothing for a while, or prints
// its greeting in between: it is greeted until it answers.
tl::expected<void, RobotFault> GcodeRobot::greet(const std::stop_token& stop) {
  const auto last = steady_clock::now() + clock_.wall_timeout(settings_.boot, settings_.boot);
  for (;;) {
    if (const auto told = tell(fmt::format("{}\n", settings_.dialect->hello)); !told) {
      return told;
    }
    const auto until = std::min(last, steady_clock::now() + kGreeting);
    for (;;) {
      const auto line = next_line(until, stop);
      if (line && line->kind == GcodeLineKind::kOk) {
        quiet_down(stop);
        return {};
      }
      if (line && line->kind == GcodeLineKind::kError) {
        return tl::unexpected(RobotFault{RobotFaultKind::kController, line->words});
      }
      if (line) continue;
      const bool silent = line.error().kind == RobotFaultKind::kLink && channel_;
      if (!silent || steady_clock::now() >= last) return tl::unexpected(line.error());
      break;
    }
  }
}

tl::expected<void, RobotFault> GcodeRobot::ready(const std::stop_token& stop) {
  if (!channel_) {
    auto opened = open_();
    if (!opened) {
      note_answer(false);
      return tl::unexpected(link_fault(opened.error()));
    }
    const std::lock_guard lock(write_mutex_);
    channel_ = *std::move(opened);
    in_step_ = false;
    offset_.clear();
    commanded_.clear();
  }
  if (in_step_) return {};
  quiet_down(stop);
  if (halted_ && !settings_.dialect->drop.empty()) {
    if (const auto dropped = drop_halted_move(stop); !dropped) return dropped;
  }
  if (const auto greeted = greet(stop); !greeted) return greeted;
  in_step_ = true;
  for (const char* const each : {"G21", "G90"}) {  // mm, and targets, not steps
    if (const auto taken = command(each, answer_by(), stop); !taken) return taken;
  }
  return {};
}

// A feed hold keeps the rest of the move. Once the machine stands, a reset drops it and keeps
// the position.
tl::expected<void, RobotFault> GcodeRobot::drop_halted_move(const std::stop_token& stop) {
  const auto deadline = steady_clock::now() + clock_.wall_timeout(settings_.timeout) + kLook;
  for (;;) {
    if (const auto told = tell(settings_.dialect->ask); !told) return told;
    const auto line = next_line(deadline, stop);
    if (!line) return tl::unexpected(line.error());
    if (line->kind != GcodeLineKind::kReport) continue;
    if (line->motion != Motion::kMoving) break;
    clock_.sleep_for(at_least_on_wall(clock_, kLook, kLook), stop);
    if (stop.stop_requested()) {
      return tl::unexpected(RobotFault{RobotFaultKind::kCancelled, ""});
    }
  }
  return tell(settings_.dialect->drop);
}

tl::expected<void, RobotFault> GcodeRobot::command(
    std::string_view text, WallTime deadline, const std::stop_token& stop) {
  if (const auto told = tell(fmt::format("{}\n", text)); !told) return told;
  for (;;) {
    const auto line = next_line(deadline, stop);
    if (!line) return tl::unexpected(line.error());
    switch (line->kind) {
      case GcodeLineKind::kOk:
        return {};
      case GcodeLineKind::kError:
        return tl::unexpected(RobotFault{
            line->unreachable ? RobotFaultKind::kUnreachable : RobotFaultKind::kController,
            fmt::format("{} is answered with {}", text, line->words)});
      case GcodeLineKind::kAlarm:
        in_step_ = false;
        return tl::unexpected(RobotFault{RobotFaultKind::kController, line->words});
      case GcodeLineKind::kRestarted:
        in_step_ = false;
        return tl::unexpected(RobotFault{
            RobotFaultKind::kController,
            "the controller has begun anew: its position is lost, home it"});
      case GcodeLineKind::kReport:
      case GcodeLineKind::kRemark:
        break;
    }
  }
}

tl::expected<GcodeLine, RobotFault> GcodeRobot::report(const std::stop_token& stop) {
  const GcodeDialect& is = *settings_.dialect;
  const auto deadline = answer_by();
  if (const auto told =
          tell(is.ask_is_line ? fmt::format("{}\n", is.ask) : std::string(is.ask));
      !told) {
    return tl::unexpected(told.error());
  }
  std::optional<GcodeLine> found;
  for (;;) {
    auto line = next_line(deadline, stop);
    if (!line) return tl::unexpected(line.error());
    if (line->kind == GcodeLineKind::kReport) {
      found = *std::move(line);
      if (!is.ask_is_line) return *std::move(found);
    } else if (line->kind == GcodeLineKind::kOk) {
      if (found) return *std::move(found);
      if (!is.ask_is_line) continue;  // of something before
      return tl::unexpected(link_fault(
          {FaultKind::kBadFrame, fmt::format("{} is answered without a position", is.ask)}));
    } else {
      in_step_ = false;
      return tl::unexpected(RobotFault{
          RobotFaultKind::kController,
          line->words.empty() ? "the controller has begun anew: its position is lost, home it"
                              : line->words});
    }
  }
}

}  // namespace sixdial::acquisition
