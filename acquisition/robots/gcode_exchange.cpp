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

// Remarks are passed over. A controller that began anew in between has lost its place.
tl::expected<std::optional<GcodeLine>, RobotFault> GcodeRobot::line_by(
    WallTime deadline, const std::stop_token& stop) {
  const std::string form =
      fmt::format("line of {}: look at baud rate and dialect", dialect_.in_words);
  for (;;) {
    auto line = hear(deadline, stop, dialect_.parse, form);
    if (!line) in_step_ = false;
    if (!line || !*line || (*line)->kind != GcodeLineKind::kRemark) return line;
  }
}

tl::expected<GcodeLine, RobotFault> GcodeRobot::next_line(
    WallTime deadline, std::string_view asked, const std::stop_token& stop) {
  auto line = line_by(deadline, stop);
  if (!line) return tl::unexpected(line.error());
  if (!*line) return tl::unexpected(silent(asked));
  return **std::move(line);
}

tl::expected<void, RobotFault> GcodeRobot::quiet_down(const std::stop_token& stop) {
  const auto longest = answer_by();
  while (steady_clock::now() < longest) {
    const auto text = hear(steady_clock::now() + kSettle, stop);
    if (text && !*text) break;
    if (!text && (stop.stop_requested() || !is_open())) return tl::unexpected(text.error());
  }
  return {};
}

tl::expected<void, RobotFault> GcodeRobot::catch_up(const std::stop_token& stop) {
  if (in_step_) return {};
  const auto quiet = quiet_down(stop);
  if (quiet) in_step_ = true;
  return quiet;
}

// A controller that begins anew when its port is opened hears nothing for a while, or prints
// its greeting in between: it is greeted until it answers.
tl::expected<void, RobotFault> GcodeRobot::greet(const std::stop_token& stop) {
  const auto last = steady_clock::now() + clock_.wall_timeout(boot_, boot_);
  for (;;) {
    if (const auto told = tell(fmt::format("{}\n", dialect_.hello)); !told) return told;
    const auto until = std::min(last, steady_clock::now() + kGreeting);
    for (;;) {
      const auto line = next_line(until, "the greeting", stop);
      if (line && line->kind == GcodeLineKind::kOk) return quiet_down(stop);
      if (line && line->kind == GcodeLineKind::kError) {
        return tl::unexpected(RobotFault{RobotFaultKind::kController, line->words});
      }
      if (line) continue;
      const bool may_come = line.error().kind == RobotFaultKind::kLink && is_open();
      if (!may_come || steady_clock::now() >= last) return tl::unexpected(line.error());
      break;
    }
  }
}

tl::expected<void, RobotFault> GcodeRobot::open_line() {
  const auto fresh = open_channel();
  if (!fresh) return tl::unexpected(fresh.error());
  if (*fresh) {
    in_step_ = false;
    offset_.clear();
    sent_.clear();
  }
  return {};
}

tl::expected<void, RobotFault> GcodeRobot::ready(const std::stop_token& stop) {
  if (const auto opened = open_line(); !opened) return opened;
  if (in_step_) return {};
  if (const auto quiet = quiet_down(stop); !quiet) return quiet;
  if (halted_ && !dialect_.drop.empty()) {
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
    if (const auto told = tell(dialect_.ask); !told) return told;
    const auto line = next_line(deadline, dialect_.ask, stop);
    if (!line) return tl::unexpected(line.error());
    if (line->kind != GcodeLineKind::kReport) continue;
    if (line->motion != Motion::kMoving) break;
    clock_.sleep_for(at_least_on_wall(clock_, kLook, kLook), stop);
    if (stop.stop_requested()) {
      return tl::unexpected(RobotFault{RobotFaultKind::kCancelled, ""});
    }
  }
  return tell(dialect_.drop);
}

tl::expected<void, RobotFault> GcodeRobot::command(
    std::string_view text, WallTime deadline, const std::stop_token& stop) {
  if (const auto told = tell(fmt::format("{}\n", text)); !told) return told;
  for (;;) {
    const auto line = next_line(deadline, text, stop);
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
  const GcodeDialect& is = dialect_;
  const auto deadline = answer_by();
  const std::string asked = is.ask_is_line ? fmt::format("{}\n", is.ask) : std::string(is.ask);
  if (const auto told = tell(asked); !told) return tl::unexpected(told.error());
  std::optional<GcodeLine> found;
  for (;;) {
    auto line = next_line(deadline, is.ask, stop);
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
