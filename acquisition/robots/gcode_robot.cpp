#include "acquisition/robots/gcode_robot.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "acquisition/bus.h"
#include "acquisition/longest_silence.h"
#include "acquisition/robots/axis_robot.h"
#include "geometry/units.h"

namespace sixdial::acquisition {
namespace {

using std::chrono::milliseconds;
using std::chrono::steady_clock;

constexpr milliseconds kLook{100};  // on the wall, between two looks at a move
constexpr int kMostReports = 40;    // Grbl tells its offset at least every 30th time
constexpr double kLargest = 1e6;    // deg, mm

const AxisFigure* find_axis(const std::vector<AxisFigure>& axes, char letter) {
  const auto found = std::ranges::find(axes, letter, &AxisFigure::letter);
  return found == axes.end() ? nullptr : &*found;
}

}  // namespace

GcodeRobot::GcodeRobot(
    GcodeSettings settings, std::span<const RobotJoint> joints, Open open, Clock& clock)
    : settings_(std::move(settings)),
      joints_(joints.begin(), joints.end()),
      open_(std::move(open)),
      clock_(clock) {}

// Reports have fewer digits than commands. Where one agrees with what was commanded to all the
// digits that it has, the joint stands where it was sent.
tl::expected<Eigen::VectorXd, RobotFault> GcodeRobot::joint_values(GcodeLine& line) {
  if (!line.offset.empty()) offset_ = line.offset;
  const bool shifted = line.position.empty();
  Eigen::VectorXd q(static_cast<Eigen::Index>(joints_.size()));
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
    if (j < commanded_.size()) {
      const double half = 0.5 * std::pow(10.0, -axis->decimals);
      if (std::abs(value - commanded_[j]) <= half * (1.0 + 1e-6)) value = commanded_[j];
    }
    q[static_cast<Eigen::Index>(j)] = joints_[j].turns ? value * geometry::kRadPerDeg : value;
  }
  return q;
}

tl::expected<RobotState, RobotFault> GcodeRobot::state_now(const std::stop_token& stop) {
  for (int asked = 0;; ++asked) {
    auto line = report(stop);
    if (!line) return tl::unexpected(line.error());
    const bool wants_offset = line->position.empty() && line->offset.empty() && offset_.empty();
    if (wants_offset && asked < kMostReports) continue;
    if (wants_offset) {
      return tl::unexpected(RobotFault{
          RobotFaultKind::kController,
          "the controller never says its work offset (WCO): set $10=0, so that it reports "
          "the position of its commands"});
    }
    auto q = joint_values(*line);
    if (!q) return tl::unexpected(q.error());
    RobotState state;
    state.q = *std::move(q);
    state.moves = moves_;
    state.motion = line->motion.value_or(Motion::kInPosition);
    if (halted_) state.motion = Motion::kFault;
    if (state.motion == Motion::kFault && !halted_ && !line->halted) {
      return tl::unexpected(RobotFault{RobotFaultKind::kController, line->words});
    }
    if (state.motion == Motion::kFault) state.fault_code = 2;
    if (state.motion == Motion::kInPosition && moves_ == 0) state.motion = Motion::kIdle;
    return state;
  }
}

tl::expected<RobotState, RobotFault> GcodeRobot::state(const std::stop_token& stop) {
  const std::lock_guard lock(mutex_);
  if (halted_ && channel_ && !settings_.dialect->drop.empty()) {
    return state_now(stop);  // as it stands: the rest of the move is dropped by the next one
  }
  if (const auto good = ready(stop); !good) return tl::unexpected(good.error());
  return state_now(stop);
}

std::string GcodeRobot::move_line(const Eigen::VectorXd& q) {
  std::string line = "G1";
  commanded_.clear();
  for (std::size_t j = 0; j < joints_.size(); ++j) {
    const double value = q[static_cast<Eigen::Index>(j)];
    const std::string text =
        figure_text(joints_[j].turns ? value / geometry::kRadPerDeg : value);
    line += fmt::format(" {}{}", settings_.axes[j], text);
    commanded_.push_back(std::stod(text));
  }
  return line + fmt::format(" F{}", figure_text(settings_.feed * percent_ / 100.0));
}

tl::expected<void, RobotFault> GcodeRobot::wait_for_end(
    WallTime deadline, const std::stop_token& stop) {
  const GcodeDialect& is = *settings_.dialect;
  if (const auto told = tell(fmt::format("{}\n", is.wait)); !told) return told;
  const auto silence = clock_.wall_timeout(longest_silence(clock_));
  auto heard = steady_clock::now();
  for (;;) {
    const auto now = steady_clock::now();
    if (now >= deadline) {
      in_step_ = false;
      return tl::unexpected(
          RobotFault{RobotFaultKind::kNotThere, "the move has not ended in its time"});
    }
    // What can be asked in between answers at once, or is gone.
    const auto until = is.look.empty() ? deadline : std::min(deadline, now + kLook);
    const auto line = next_line(until, stop);
    if (!line) {
      const bool only_waits = line.error().kind == RobotFaultKind::kLink && channel_ &&
                              steady_clock::now() >= until;
      if (!only_waits || (!is.look.empty() && steady_clock::now() - heard > silence)) {
        return tl::unexpected(line.error());
      }
      if (!is.look.empty()) {
        if (const auto told = tell(is.look); !told) return told;
      }
      continue;
    }
    heard = steady_clock::now();
    if (line->kind == GcodeLineKind::kOk) {
      in_step_ = !halted_;  // the looks in between took nothing away
      return {};
    }
    const bool held = line->kind == GcodeLineKind::kReport && line->motion == Motion::kFault;
    if (line->kind == GcodeLineKind::kReport && !held) continue;
    in_step_ = false;
    if (held && line->halted) halted_ = true;
    return tl::unexpected(RobotFault{
        held && line->halted ? RobotFaultKind::kHalted : RobotFaultKind::kController,
        line->kind == GcodeLineKind::kRestarted
            ? "the controller has begun anew: its position is lost, home it"
            : line->words});
  }
}

std::optional<RobotFault> GcodeRobot::not_there(const RobotState& state) const {
  std::string off;
  for (std::size_t j = 0; j < joints_.size(); ++j) {
    const double q = state.q[static_cast<Eigen::Index>(j)];
    const double value = joints_[j].turns ? q / geometry::kRadPerDeg : q;
    if (std::abs(value - commanded_[j]) <= settings_.arrived) continue;
    off += fmt::format(
        "{}{} ({}) stands at {} and was sent to {}", off.empty() ? "" : ", ", settings_.axes[j],
        joints_[j].name, figure_text(value), figure_text(commanded_[j]));
  }
  if (off.empty()) return std::nullopt;
  return RobotFault{RobotFaultKind::kUnreachable, off + ": beyond its travel?"};
}

tl::expected<RobotState, RobotFault> GcodeRobot::move_to(
    const Eigen::VectorXd& q, milliseconds timeout, const std::stop_token& stop) {
  const std::lock_guard lock(mutex_);
  const bool good = q.size() == static_cast<Eigen::Index>(joints_.size()) && q.allFinite() &&
                    q.cwiseAbs().maxCoeff() < kLargest;
  if (!good) {
    return tl::unexpected(RobotFault{
        RobotFaultKind::kUnreachable,
        fmt::format("{} joint values, or one that is no number", q.size())});
  }
  if (halted_) in_step_ = false;
  if (const auto open = ready(stop); !open) return tl::unexpected(open.error());
  halted_ = false;
  if (const auto before = state_now(stop); !before) return before;
  const auto deadline =
      steady_clock::now() + clock_.wall_timeout(timeout, std::min(timeout, milliseconds{2000}));
  ++moves_;
  auto ended = command(move_line(q), std::min(deadline, answer_by()), stop).and_then([&] {
    return wait_for_end(deadline, stop);
  });
  if (!ended) {
    const RobotFaultKind kind = ended.error().kind;
    const bool runs_on = kind == RobotFaultKind::kCancelled ||
                         kind == RobotFaultKind::kNotThere || kind == RobotFaultKind::kLink;
    if (halted_ && !runs_on) return tl::unexpected(ended.error());
    // Not to be left running with nobody watching. Best effort: the cause is reported anyway.
    if (runs_on && channel_ && !halted_) {
      halted_ = true;
      (void)tell(settings_.dialect->halt);
    }
    in_step_ = false;
    return tl::unexpected(ended.error());
  }
  if (halted_) {
    in_step_ = false;
    return tl::unexpected(RobotFault{RobotFaultKind::kHalted, "the robot was stopped"});
  }
  auto there = state_now(stop);
  if (!there) return there;
  if (auto fault = not_there(*there)) return tl::unexpected(*std::move(fault));
  return there;
}

tl::expected<void, RobotFault> GcodeRobot::halt(const std::stop_token&) {
  {
    const std::lock_guard lock(write_mutex_);
    if (channel_) {
      halted_ = true;
      const auto written = channel_->write(settings_.dialect->halt, kGcodeWrite);
      in_step_ = false;
      if (!written) return tl::unexpected(link_fault(written.error()));
      return {};
    }
  }
  // Nobody speaks to it: its own line, and nothing is waited for.
  const std::lock_guard lock(mutex_);
  auto opened = open_();
  if (!opened) return tl::unexpected(link_fault(opened.error()));
  const std::lock_guard writing(write_mutex_);
  channel_ = *std::move(opened);
  in_step_ = false;
  halted_ = true;
  const auto written = channel_->write(settings_.dialect->halt, kGcodeWrite);
  if (!written) return tl::unexpected(link_fault(written.error()));
  return {};
}

tl::expected<std::optional<int>, RobotFault> GcodeRobot::speed(const std::stop_token&) {
  return std::optional<int>(percent_);
}

tl::expected<void, RobotFault> GcodeRobot::set_speed(int percent, const std::stop_token&) {
  percent_ = std::clamp(percent, 1, 100);
  return {};
}

}  // namespace sixdial::acquisition
