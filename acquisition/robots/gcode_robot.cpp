#include "acquisition/robots/gcode_robot.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

namespace sixdial::acquisition {
namespace {

using std::chrono::milliseconds;
using std::chrono::steady_clock;

constexpr milliseconds kLook{100};  // on the wall, between two looks at a move
constexpr int kMostReports = 40;    // Grbl tells its offset at least every 30th time

const AxisFigure* find_axis(const std::vector<AxisFigure>& axes, char letter) {
  const auto found = std::ranges::find(axes, letter, &AxisFigure::letter);
  return found == axes.end() ? nullptr : &*found;
}

}  // namespace

GcodeRobot::GcodeRobot(
    AxisSettings settings, const GcodeDialect* dialect, milliseconds boot, Open open,
    Clock& clock, std::span<const RobotJoint> joints)
    : AxisRobot(std::move(settings), std::move(open), clock, joints),
      dialect_(*dialect),
      boot_(boot) {}

// Reports have fewer digits than commands. Where one agrees with what was commanded to all the
// digits that it has, the joint stands where it was sent.
tl::expected<std::vector<double>, RobotFault> GcodeRobot::stands_at(const GcodeLine& line) {
  if (!line.offset.empty()) offset_ = line.offset;
  const bool shifted = line.position.empty();
  std::vector<double> values;
  for (std::size_t j = 0; j < joints_.size(); ++j) {
    const char letter = settings_.axes[j];
    const AxisFigure* axis = find_axis(shifted ? line.machine : line.position, letter);
    if (axis == nullptr) {
      return tl::unexpected(RobotFault{
          RobotFaultKind::kController,
          fmt::format(
              "the controller says nothing of its axis {}: look at axes= in the rig file",
              letter)});
    }
    double value = axis->value;
    if (shifted) {
      const AxisFigure* zero = find_axis(offset_, letter);
      if (zero != nullptr) value -= zero->value;
    }
    if (j < sent_.size()) {
      const double half = 0.5 * std::pow(10.0, -axis->decimals);
      if (std::abs(value - sent_[j]) <= half * (1.0 + 1e-6)) value = sent_[j];
    }
    values.push_back(value);
  }
  return values;
}

tl::expected<GcodeRobot::Look, RobotFault> GcodeRobot::look(const std::stop_token& stop) {
  for (int asked = 0;; ++asked) {
    const auto line = report(stop);
    if (!line) return tl::unexpected(line.error());
    const bool wants_offset = line->position.empty() && line->offset.empty() && offset_.empty();
    if (wants_offset && asked < kMostReports) continue;
    if (wants_offset) {
      return tl::unexpected(RobotFault{
          RobotFaultKind::kController,
          "the controller never says its work offset (WCO): set $10=0, so that it reports "
          "the position of its commands"});
    }
    auto stands = stands_at(*line);
    if (!stands) return tl::unexpected(stands.error());
    const Motion motion = line->motion.value_or(Motion::kInPosition);
    if (motion == Motion::kFault && !halted_ && !line->halted) {
      return tl::unexpected(RobotFault{RobotFaultKind::kController, line->words});
    }
    return Look{.stands = *std::move(stands), .motion = motion};
  }
}

RobotState GcodeRobot::shown_by(const Look& seen) const {
  return state_of(seen.stands, halted_ ? Motion::kFault : seen.motion);
}

tl::expected<RobotState, RobotFault> GcodeRobot::state_now(const std::stop_token& stop) {
  // The rest of a halted move is dropped by the next one: until then as it stands.
  const bool stands_held = halted_ && is_open() && !dialect_.drop.empty();
  const auto good = stands_held ? catch_up(stop) : ready(stop);
  if (!good) return tl::unexpected(good.error());
  const auto seen = look(stop);
  if (!seen) return tl::unexpected(seen.error());
  return shown_by(*seen);
}

tl::expected<void, RobotFault> GcodeRobot::wait_for_end(
    WallTime deadline, const std::stop_token& stop) {
  if (const auto told = tell(fmt::format("{}\n", dialect_.wait)); !told) return told;
  auto heard = steady_clock::now();
  for (;;) {
    const auto now = steady_clock::now();
    if (now >= deadline) {
      in_step_ = false;
      return tl::unexpected(
          RobotFault{RobotFaultKind::kNotThere, "the move has not ended in its time"});
    }
    // What can be asked in between answers at once, or is gone.
    const bool looks = !dialect_.look.empty();
    const auto line = line_by(looks ? std::min(deadline, now + kLook) : deadline, stop);
    if (!line) return tl::unexpected(line.error());
    if (!*line) {
      if (!looks) continue;
      if (steady_clock::now() - heard > longest_wait()) {
        return tl::unexpected(silent(dialect_.look));
      }
      if (const auto told = tell(dialect_.look); !told) return told;
      continue;
    }
    const GcodeLine& said = **line;
    heard = steady_clock::now();
    if (said.kind == GcodeLineKind::kOk) return {};
    const bool held = said.kind == GcodeLineKind::kReport && said.motion == Motion::kFault;
    if (said.kind == GcodeLineKind::kReport && !held) continue;
    in_step_ = false;
    if (held && said.halted) halted_ = true;
    return tl::unexpected(RobotFault{
        held && said.halted ? RobotFaultKind::kHalted : RobotFaultKind::kController,
        said.kind == GcodeLineKind::kRestarted
            ? "the controller has begun anew: its position is lost, home it"
            : said.words});
  }
}

tl::expected<RobotState, RobotFault> GcodeRobot::go_to(
    const std::vector<double>& target, milliseconds timeout, const std::stop_token& stop) {
  if (halted_) in_step_ = false;
  if (const auto good = ready(stop); !good) return tl::unexpected(good.error());
  halted_ = false;
  if (stop_asked_) halted_ = true;  // while it got ready
  const auto before = look(stop);
  const RobotFault stopped{RobotFaultKind::kHalted, "the robot was stopped"};
  if (halted_) {
    in_step_ = false;
    return tl::unexpected(stopped);
  }
  if (!before) return tl::unexpected(before.error());
  const WallTime deadline = ends_by(timeout);
  ++moves_;
  sent_ = target;
  const auto ended =
      command(move_words(target, feed()), std::min(deadline, answer_by()), stop).and_then([&] {
        return wait_for_end(deadline, stop);
      });
  if (!ended) {
    const RobotFaultKind kind = ended.error().kind;
    const bool runs_on = kind == RobotFaultKind::kCancelled ||
                         kind == RobotFaultKind::kNotThere || kind == RobotFaultKind::kLink;
    // Not to be left running with nobody watching. Best effort: the cause is reported anyway.
    if (runs_on && is_open() && !halted_) {
      halted_ = true;
      (void)tell(dialect_.halt);
    }
    in_step_ = false;
    return tl::unexpected(ended.error());
  }
  if (halted_) {
    (void)tell(dialect_.halt);  // it may have come just before the move was sent
    in_step_ = false;
    return tl::unexpected(stopped);
  }
  const auto there = look(stop);
  if (!there) return tl::unexpected(there.error());
  if (auto fault = not_there(there->stands, target)) return tl::unexpected(*std::move(fault));
  return shown_by(*there);
}

tl::expected<void, RobotFault> GcodeRobot::halt(const std::stop_token&) {
  stop_asked_ = true;
  for (;;) {
    std::unique_lock turn(mutex_, std::defer_lock);
    if (!is_open() && turn.try_lock()) {  // nobody speaks to it: a line of its own, no waiting
      if (const auto opened = open_line(); !opened) return opened;
    }
    halted_ = true;
    const auto told = tell_meanwhile(dialect_.halt);
    in_step_ = false;
    if (!told) return tl::unexpected(told.error());
    if (*told) return {};
    std::this_thread::sleep_for(kTurn);  // somebody else opens the line, or has just lost it
  }
}

}  // namespace sixdial::acquisition
