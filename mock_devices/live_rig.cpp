#include "mock_devices/live_rig.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "mock_devices/random.h"

namespace sixdial::mock_devices {
namespace {

using Eigen::Vector2d;

constexpr double kSettled = 40.0;  // time constants after which nothing is left
constexpr int kSubsteps = 6;       // of a dial's tick while something moves
constexpr int kPathPoints = 40;
constexpr std::size_t kKeptMoves = 64;
constexpr double kStill_mm = 1e-9;
constexpr double kAtStop_mm = 0.0005;

}  // namespace

LiveRig::LiveRig(const World& world, const LiveRigHabits& habits)
    : model_(world), habits_(habits) {
  const geometry::Robot& robot = world.rig.robot;
  const auto q =
      geometry::inverse(robot.nominal, world.rig.cuboid.reference_pose_mm, robot.working_mode);
  if (!q) throw std::invalid_argument("the nominal robot cannot take its reference pose");
  legs_.push_back({Move(*q, *q, 0.0, habits.motion, 1.0), assembly_for(*q), false});
  const auto start = model_.pose(moment(0.0));
  if (!start) throw std::invalid_argument("the true robot cannot take the reference pose");
  for (std::size_t i = 0; i < model_.dial_count(); ++i) {
    const auto place = static_cast<std::uint32_t>(i);
    Dial dial{};
    dial.rate_hz = Random(world.seed, Stream::kRate, place).uniform(0, 8.0, 20.0);
    dial.phase = Random(world.seed, Stream::kRate, place).uniform(1);
    dial.tau_s = Random(world.seed, Stream::kSettling, place).uniform(0, 0.020, 0.050);
    dial.tick = -2;
    if (start->pushes[i]) dial.plunger_mm = start->pushes[i]->displacement_mm;
    dial.turning_mm = dial.plunger_mm;
    dials_.push_back(dial);
    advance(i, 0.0);
  }
}

const LiveRig::Leg& LiveRig::leg_at(double time_s) const {
  for (auto leg = legs_.rbegin(); leg != legs_.rend(); ++leg) {
    if (leg->move.start_s() <= time_s) return *leg;
  }
  return legs_.front();
}

geometry::Assembly LiveRig::assembly_for(const Vector2d& q_rad) const {
  const geometry::Rig& rig = model_.world().rig;
  const auto assembly =
      geometry::assembly_at(rig.robot.nominal, q_rad, rig.cuboid.reference_pose_mm);
  return assembly ? *assembly : rig.robot.assembly;
}

Moment LiveRig::moment(double time_s) const {
  const Leg& leg = leg_at(time_s);
  const Move& move = leg.move;
  Moment now{
      .time_s = time_s,
      .temperature_c = model_.temperature_c(time_s),
      .sample = std::max<std::int64_t>(0, moves_started_ - 1),
      .q_rad = move.at(time_s),
      .approach = approach_,
      .assembly = leg.assembly};
  if (!model_.world().effects.empty()) now.travel = last_travel(now);
  return now;
}

Vector2d LiveRig::last_travel(const Moment& now) const {
  const auto to = model_.tool(now);
  // A move to where the rig stands already is none: the one before counts.
  for (auto leg = legs_.rbegin(); to && leg != legs_.rend(); ++leg) {
    if (leg->move.start_s() > now.time_s) continue;
    Moment start = now;
    start.q_rad = leg->move.from_rad();
    const auto from = model_.tool(start);
    if (from && (*to - *from).norm() > kStill_mm) return (*to - *from).normalized();
  }
  return Vector2d::Zero();
}

bool LiveRig::start_move(const Vector2d& q_rad, int speed_percent, double time_s) {
  const double step = habits_.encoder_step_rad;
  const Vector2d target =
      step > 0.0 ? Vector2d((q_rad / step).array().round().matrix() * step) : q_rad;
  const double share = std::clamp(speed_percent, 1, 100) / 100.0;
  return set_off(target, habits_.motion, share, false, time_s);
}

bool LiveRig::follow(const Vector2d& q_rad, double seconds, double time_s) {
  const bool goes_on = time_s < legs_.back().move.end_s();
  const Vector2d here = leg_at(time_s).move.at(time_s);
  return set_off(q_rad, limits_of_move(here, q_rad, seconds), 1.0, goes_on, time_s);
}

bool LiveRig::set_off(
    const Vector2d& target, const MotionLimits& limits, double share, bool goes_on,
    double time_s) {
  advance(time_s);
  const Vector2d here = leg_at(time_s).move.at(time_s);
  const double step = habits_.encoder_step_rad;
  const geometry::Robot& robot = model_.world().rig.robot;
  const geometry::Assembly assembly = assembly_for(target);
  const auto mode_here =
      geometry::working_mode_of(robot.nominal, here, leg_at(time_s).assembly);
  const auto mode_there = geometry::working_mode_of(robot.nominal, target, assembly);
  const bool changes_mode = !mode_here || !mode_there || *mode_here != *mode_there ||
                            leg_at(time_s).assembly != assembly;
  Moment on_way = moment(time_s);
  on_way.assembly = assembly;
  for (int i = changes_mode ? kPathPoints : 1; i <= kPathPoints; ++i) {
    on_way.q_rad = here + (target - here) * (static_cast<double>(i) / kPathPoints);
    if (!geometry::forward(robot.nominal, on_way.q_rad, assembly) || !model_.tool(on_way)) {
      fault_ = RobotFault::kOutOfReach;
      legs_.back().move.cut(time_s);
      return false;
    }
  }
  if (!goes_on) {
    for (Dial& dial : dials_) dial.before_move_mm = dial.face.value_mm;
  }
  for (std::size_t joint = 0; joint < 2; ++joint) {
    const double way = (target - here)[static_cast<Eigen::Index>(joint)];
    if (std::abs(way) > step / 2) approach_[joint] = way > 0 ? 1 : -1;
  }
  legs_.back().move.cut(time_s);
  legs_.push_back({Move(here, target, time_s, limits, share), assembly, changes_mode});
  if (legs_.size() > kKeptMoves) legs_.pop_front();
  if (!goes_on) ++moves_started_;
  fault_ = RobotFault::kNone;
  resting_state_ = MotionState::kInPosition;
  return true;
}

void LiveRig::stop(double time_s) {
  advance(time_s);
  if (time_s >= legs_.back().move.end_s()) return;
  legs_.back().move.cut(time_s);
  fault_ = RobotFault::kStopped;
}

RobotReport LiveRig::robot(double time_s) const {
  RobotReport report;
  report.fault = fault_;
  report.state = fault_ != RobotFault::kNone          ? MotionState::kFault
                 : time_s < legs_.back().move.end_s() ? MotionState::kMoving
                                                      : resting_state_;
  report.q_rad = leg_at(time_s).move.at(time_s);
  report.moves_started = static_cast<std::uint16_t>(moves_started_);
  report.temperature_c = model_.temperature_c(time_s);
  report.cycles = static_cast<std::uint16_t>(
      static_cast<std::int64_t>(std::max(0.0, time_s) / habits_.cycle_s));
  return report;
}

DialFace LiveRig::dial(std::size_t name, double time_s) {
  const std::size_t wired = model_.wired_to(name);
  advance(wired, time_s);
  return dials_[wired].face;
}

TruePose LiveRig::true_pose(double time_s) const {
  auto pose = model_.pose(moment(time_s));
  if (!pose) throw std::logic_error("the true robot stands where its links cannot close");
  return *std::move(pose);
}

void LiveRig::advance(double time_s) {
  for (std::size_t i = 0; i < dials_.size(); ++i) advance(i, time_s);
}

void LiveRig::advance(std::size_t index, double time_s) {
  Dial& dial = dials_[index];
  const auto last = static_cast<std::int64_t>(std::floor(time_s * dial.rate_hz - dial.phase));
  const auto time_of = [&](std::int64_t tick) {
    return (static_cast<double>(tick) + dial.phase) / dial.rate_hz;
  };
  const double quiet_s = legs_.back().move.end_s() + kSettled * dial.tau_s;
  while (dial.tick < last) {
    const double from_s = time_of(dial.tick);
    const bool at_rest = from_s > quiet_s;
    dial.tick = at_rest ? last : dial.tick + 1;
    follow(dial, index, from_s, time_of(dial.tick), at_rest);
  }
}

void LiveRig::follow(Dial& dial, std::size_t index, double from_s, double to_s, bool at_rest) {
  const double travel = model_.world().rig.dials[index].geometry.travel_mm;
  const int steps = at_rest ? 1 : kSubsteps;
  const double step_s = (to_s - from_s) / steps;
  bool touched = false;
  bool closed = false;
  Moment now;
  double speed_mm_s = 0.0;
  for (int i = 1; i <= steps; ++i) {
    now = moment(from_s + i * step_s);
    const auto pose = model_.pose(now);
    if (!pose) {
      if (!leg_at(now.time_s).changes_mode) {
        throw std::logic_error("the true robot stands where its links cannot close");
      }
      dial.face.moving_fast = true;  // somebody is lifting the legs across
      closed = false;
      continue;
    }
    closed = true;
    const auto& push = pose->pushes[index];
    touched = push.has_value();
    const double pushed = push ? std::min(push->displacement_mm, travel) : 0.0;
    const double before = dial.plunger_mm;
    dial.plunger_mm =
        at_rest ? pushed : pushed + (before - pushed) * std::exp(-step_s / dial.tau_s);
    speed_mm_s = at_rest ? 0.0 : std::abs(dial.plunger_mm - before) / step_s;

    const double beyond = dial.plunger_mm - dial.turning_mm;
    if (dial.direction == 0 ? std::abs(beyond) > habits_.hysteresis_play_mm
                            : beyond * dial.direction < -habits_.hysteresis_play_mm) {
      dial.direction = beyond > 0 ? 1 : -1;
      dial.turning_mm = dial.plunger_mm;
    } else if (beyond * dial.direction > 0.0) {
      dial.turning_mm = dial.plunger_mm;
    }
  }
  if (!closed) return;
  DialFace& face = dial.face;
  face.in_contact = touched;
  face.at_travel_end = touched && dial.plunger_mm >= travel - kAtStop_mm;
  face.moving_fast = speed_mm_s > habits_.fast_mm_s;
  if (!touched && dial.plunger_mm < kAtStop_mm) {
    face.value_mm = model_.end_stop_mm(index);
    return;
  }
  if (face.at_travel_end) {
    face.value_mm = model_.quantised_mm(travel);
    return;
  }
  if (moves_started_ > 1 && to_s > legs_.back().move.end_s() &&
      model_.is_stale(index, now.sample)) {
    face.value_mm = dial.before_move_mm;
    return;
  }
  const double shown = model_.shown_mm(index, dial.plunger_mm, dial.direction, now) +
                       model_.noise_mm(index, static_cast<std::uint64_t>(dial.tick + 2)) +
                       model_.gross_error_mm(index, now.sample);
  face.value_mm = model_.quantised_mm(std::clamp(shown, 0.0, travel));
}

}  // namespace sixdial::mock_devices
