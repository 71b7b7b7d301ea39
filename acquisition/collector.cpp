#include "acquisition/collector.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "acquisition/longest_silence.h"
#include "geometry/same_pose.h"
#include "geometry/tool.h"
#include "session/reason.h"

namespace sixdial::acquisition {
namespace {

using session::Quality;

constexpr int kHalvings = 3;  // of the way to a pre-position that cannot be reached

// A read-back that differs by less from what was commanded is the command in the digits of the
// controller: both say the same.
constexpr double kSameCommand_rad = 2e-6;
constexpr double kSameCommand_mm = 1e-4;

bool is_fault(const Reading& reading) {
  return reading.quality == Quality::kBad && !reading.value_mm;
}

/// Whether any joint was read back elsewhere than it was told to go.
bool differs(
    const geometry::RobotModel& robot, const Eigen::VectorXd& read,
    const Eigen::VectorXd& command) {
  if (read.size() != command.size() || read.size() != robot.joint_count()) return false;
  for (Eigen::Index i = 0; i < read.size(); ++i) {
    const auto& joint = robot.joints[static_cast<std::size_t>(i)];
    const bool turns = joint.kind == geometry::JointKind::kRevolute;
    const double same = turns ? kSameCommand_rad : kSameCommand_mm;
    if (std::abs(read[i] - command[i]) > same) return true;
  }
  return false;
}

}  // namespace

Collector::Collector(
    geometry::Rig rig, session::Plan plan, RobotPort& robot, DialSource& dials, Clock& clock,
    Callbacks callbacks, CollectorSettings settings)
    : rig_(std::move(rig)),
      plan_(std::move(plan)),
      robot_(robot),
      dials_(dials),
      clock_(clock),
      callbacks_(std::move(callbacks)),
      settings_(settings),
      plausibility_(rig_, settings.implausible_mm),
      attempts_(plan_.points.size(), 0),
      counted_(plan_.points.size(), false),
      last_move_(session::layout_of(rig_).joints.size(), 0) {
  if (!callbacks_.store)
    throw std::invalid_argument("collector: nothing to store samples with");
  if (dials_.size() != rig_.dials.size()) {
    throw std::invalid_argument(fmt::format(
        "collector: {} dials are connected, the rig has {}", dials_.size(), rig_.dials.size()));
  }
}

CollectorResult Collector::run(const std::stop_token& stop) {
  started_ = clock_.monotonic();
  for (std::size_t i = 0; i < plan_.points.size(); ++i) {
    if (callbacks_.done && callbacks_.done(plan_.points[i])) {
      counted_[i] = true;
      ++done_;
      ++result_.already_done;
    } else {
      pending_.push_back(i);
    }
  }
  if (!asked_before_first_move(stop)) return result_;
  while (!stop.stop_requested()) {
    bool pause = false;
    {
      const std::lock_guard lock(mutex_);
      pause = pause_wanted_;
    }
    if (pause) {
      const std::optional<std::size_t> next =
          pending_.empty() ? std::nullopt : std::optional(pending_.front());
      const Wish wish = wait_paused(next, PauseReason::kAsked, "", "", stop);
      if (wish == Wish::kSkip && next) {
        pending_.pop_front();
        (void)skipped(*next, "skipped by the operator");
      } else if (wish == Wish::kRetake && last_stored_) {
        retake(*last_stored_);
      }
      continue;
    }
    const std::optional<std::size_t> index = next_point();
    if (!index) break;
    if (point(*index, stop) == Outcome::kAgain) pending_.push_front(*index);
  }
  result_.complete = !stop.stop_requested();
  report(result_.complete ? CollectorStage::kFinished : CollectorStage::kStopped, std::nullopt);
  return result_;
}

std::optional<std::size_t> Collector::next_point() {
  {
    const std::lock_guard lock(mutex_);
    // Asked for after the last point was stored and before this one began.
    if (wish_ == Wish::kRetake && last_stored_) retakes_.push_back(*last_stored_);
    wish_ = Wish::kNone;
    here_.emplace();
    if (!retakes_.empty()) {
      const std::size_t index = retakes_.front();
      retakes_.pop_front();
      return index;
    }
  }
  while (!pending_.empty()) {
    const std::size_t index = pending_.front();
    pending_.pop_front();
    if (!callbacks_.wanted || callbacks_.wanted(plan_.points[index])) return index;
    ++result_.left_out;
    if (!counted_[index]) {
      counted_[index] = true;
      ++done_;
    }
  }
  return std::nullopt;
}

Collector::Outcome Collector::point(std::size_t index, const std::stop_token& stop) {
  std::stop_source here = [&] {
    const std::lock_guard lock(mutex_);
    return *here_;
  }();
  const std::stop_callback relay(stop, [&] { here.request_stop(); });
  remarks_.clear();
  const Outcome outcome = measure(index, here.get_token(), stop);
  const std::lock_guard lock(mutex_);
  here_.reset();
  return outcome;
}

Collector::Outcome Collector::measure(
    std::size_t index, const std::stop_token& here, const std::stop_token& stop) {
  if (const auto outcome = change_branch(index, here, stop)) return *outcome;
  settling_.clear();
  report(CollectorStage::kMoving, index);
  if (const auto there = go(index, here, stop); !there) return there.error();
  auto measured = settle(index, here, stop);
  if (!measured) return measured.error();
  if (const auto outcome = judge_faults(index, *measured, stop)) return *outcome;
  // Angles of now: an arm that is let go after the move must not be taken for where it was.
  const auto state = robot_.state(here);
  if (!state) {
    return here.stop_requested() ? interrupted(index, stop)
                                 : robot_trouble(index, state.error(), stop);
  }
  return store(index, *state, std::move(measured->readings), stop);
}

std::optional<Collector::Outcome> Collector::judge_faults(
    std::size_t index, const Measured& measured, const std::stop_token& stop) {
  if (measured.faulty.empty()) return std::nullopt;
  std::vector<std::string> faults;
  for (const std::size_t i : measured.faulty) {
    const Reading& reading = measured.readings[i];
    faults.push_back(
        fmt::format("dial {}: {}, {}", rig_.dials[i].id, reading.reason, reading.detail));
  }
  const bool none = measured.faulty.size() == rig_.dials.size();
  if (none || settings_.on_dial_fault == OnDialFault::kPause) {
    const std::string trouble =
        fmt::format("{}{}", none ? "no dial answers: " : "", fmt::join(faults, "; "));
    constexpr const char* kAdvice =
        "resume measures again, accept stores the point as it is, skip leaves it out";
    switch (wait_paused(index, PauseReason::kDialFault, trouble, kAdvice, stop)) {
      case Wish::kAccept:
        break;
      case Wish::kSkip:
        return skipped(
            index, fmt::format("skipped by the operator: {}", fmt::join(faults, "; ")));
      case Wish::kNone:
      case Wish::kRetake:
        return stop.stop_requested() ? Outcome::kStopped : Outcome::kAgain;
    }
  }
  remarks_.insert(remarks_.end(), faults.begin(), faults.end());
  return std::nullopt;
}

// Where to come from, so that each joint arrives from its asked side; nearer if that is out of
// reach, empty if no side is asked for or none can be had.
std::optional<Eigen::VectorXd> Collector::pre_position(const session::PlanPoint& point) const {
  Eigen::VectorXd sides(point.q.size());
  for (Eigen::Index joint = 0; joint < sides.size(); ++joint) {
    sides[joint] = session::approach_of(point, static_cast<std::size_t>(joint));
  }
  if (sides.isZero()) return std::nullopt;
  const geometry::Assembly assembly = session::branch_of(rig_, point).assembly;
  Eigen::VectorXd away(sides.size());
  for (Eigen::Index joint = 0; joint < away.size(); ++joint) {
    const auto& info = rig_.robot.model->joints[static_cast<std::size_t>(joint)];
    away[joint] = info.unit() == "rad" ? settings_.approach_rad : settings_.approach_mm;
  }
  for (int halving = 0; halving <= kHalvings; ++halving, away /= 2) {
    const Eigen::VectorXd q = point.q - away.cwiseProduct(sides);
    if (geometry::Tool(rig_).position(rig_.robot.nominal, q, assembly)) return q;
  }
  return std::nullopt;
}

Collector::OrOutcome<RobotState> Collector::go(
    std::size_t index, const std::stop_token& here, const std::stop_token& stop) {
  const session::PlanPoint& point = plan_.points[index];
  const auto failed = [&](const RobotFault& fault) {
    if (!lost_.empty()) return tl::unexpected(lost_contact(index, stop));
    return tl::unexpected(
        here.stop_requested() ? interrupted(index, stop) : robot_trouble(index, fault, stop));
  };
  const std::optional<Eigen::VectorXd> pre = pre_position(point);
  if (robot_.by_hand()) {  // one request for both steps
    robot_.announce_approach(pre);
    if (pre) last_q_ = *pre;
  } else if (pre) {
    const auto arrived = move(*pre, here);
    if (!arrived && arrived.error().kind != RobotFaultKind::kUnreachable) {
      return failed(arrived.error());
    }
    if (!arrived) remarks_.push_back("the asked approach cannot be reached");
  }
  if (!pre && std::ranges::any_of(point.approach, [](int side) { return side != 0; })) {
    remarks_.push_back("the asked approach cannot be reached");
  }
  const auto arrived = move(point.q, here);
  if (!arrived) return failed(arrived.error());
  return *arrived;
}

tl::expected<RobotState, RobotFault> Collector::move(
    const Eigen::VectorXd& q, const std::stop_token& here) {
  for (int attempt = 0;; ++attempt) {
    if (!last_q_) {
      const auto now = robot_.state(here);
      if (!now) return now;
      if (now->motion != Motion::kIdle && now->q.size() == q.size()) last_q_ = now->q;
    }
    if (last_q_) {
      for (std::size_t joint = 0; joint < last_move_.size(); ++joint) {
        const auto j = static_cast<Eigen::Index>(joint);
        const double way = q[j] - (*last_q_)[j];
        // Encoders jitter: a joint that is sent to where it stands has not moved.
        const double still = geometry::same_pose(rig_.robot.model->joints[joint].unit());
        if (std::abs(way) > still) last_move_[joint] = way > 0 ? 1 : -1;
      }
    }
    const auto arrived = guarded_move(q, here);
    if (arrived && arrived->q.size() != q.size()) {
      return tl::unexpected(RobotFault{
          RobotFaultKind::kController,
          fmt::format(
              "the controller tells of {} joints, the robot has {}", arrived->q.size(),
              q.size())});
    }
    if (arrived) {
      last_q_ = arrived->q;
      return arrived;
    }
    // Stopped anywhere on the way: the next move starts from where it then is.
    last_q_.reset();
    std::ranges::fill(last_move_, 0);
    const RobotFaultKind kind = arrived.error().kind;
    const bool again = (kind == RobotFaultKind::kLink || kind == RobotFaultKind::kNotThere) &&
                       lost_.empty() && robot_.silent_for() < longest_silence(clock_);
    if (!again || attempt >= settings_.robot_retries || here.stop_requested()) return arrived;
  }
}

Collector::OrOutcome<Collector::Measured> Collector::settle(
    std::size_t index, const std::stop_token& here, const std::stop_token& stop) {
  const std::size_t count = rig_.dials.size();
  const DeviceTime deadline = clock_.monotonic() + settings_.settle_timeout;
  std::vector<SettlingHistory> histories(count);
  std::vector<int> faults(count, 0);
  settling_.assign(count, {});
  for (int round = 1;; ++round) {
    Measured measured{dials_.read_since(clock_.monotonic(), here), {}};
    if (here.stop_requested()) return tl::unexpected(interrupted(index, stop));
    bool ready = true;
    bool can_tell = true;  // each dial that answers has enough readings to be judged by
    for (std::size_t i = 0; i < count; ++i) {
      const Reading& reading = measured.readings[i];
      const double spread_mm = settings_.settle_spread_mm > 0
                                   ? settings_.settle_spread_mm
                                   : rest_spread_mm(rig_.dials[i].repeatability_mm);
      settling_[i] = {.spread_mm = {}, .limit_mm = spread_mm};
      if (is_fault(reading)) {
        measured.faulty.push_back(i);
        histories[i].forget();
        ready = ++faults[i] > settings_.fault_retries && ready;
        continue;
      }
      faults[i] = 0;
      histories[i].add(reading, settings_.settle_readings, settings_.settle_window);
      settling_[i] =
          histories[i].judged(settings_.settle_readings, settings_.settle_window, spread_mm);
      ready = settling_[i].settled && ready;
      can_tell = histories[i].has(settings_.settle_readings) && can_tell;
    }
    // However slow the dials answer; but one that keeps failing in between is not waited for.
    const int most_rounds = settings_.settle_readings * (settings_.fault_retries + 1);
    const bool late = clock_.monotonic() >= deadline && (can_tell || round >= most_rounds);
    for (std::size_t i = 0; late && i < count; ++i) {
      Reading& reading = measured.readings[i];
      if (settling_[i].settled || reading.quality != Quality::kGood) continue;
      reading.quality = Quality::kUncertain;
      reading.reason = session::reason::kUnsettled;
      reading.detail = fmt::format("moves by more than {:.3f} mm", settling_[i].limit_mm);
      remarks_.push_back(fmt::format("dial {}: unsettled", rig_.dials[i].id));
    }
    report(CollectorStage::kSettling, index, "", measured.readings);
    if (ready || late) return measured;
    if (!measured.faulty.empty()) clock_.sleep_for(settings_.retry_pause, here);
  }
}

Collector::Outcome Collector::store(
    std::size_t index, const RobotState& state, std::vector<Reading> readings,
    const std::stop_token& stop) {
  const session::PlanPoint& point = plan_.points[index];
  std::vector<ExpectedDial> expected =
      plausibility_.expected_at(state.q, session::branch_of(rig_, point).assembly);
  plausibility_.judge(readings, expected);
  Plausibility::judge_frozen(readings, expected, last_readings_, last_expected_);

  CollectedSample collected;
  collected.plan_index = index;
  collected.attempt = attempts_[index] + 1;
  session::Sample& sample = collected.sample;
  sample.set = point.set;
  sample.point = point.point;
  sample.repeat = point.repeat;
  sample.time_utc = clock_.now_utc();
  sample.q = state.q;
  if (!robot_.by_hand() && differs(*rig_.robot.model, state.q, point.q)) {
    sample.q_command = point.q;
  }
  sample.target_mm = point.target_mm;
  sample.approach.assign(last_move_.begin(), last_move_.end());
  sample.temperature_c = state.temperature_c;
  for (std::size_t i = 0; i < readings.size(); ++i) {
    const Reading& reading = readings[i];
    sample.channels.push_back(
        {reading.value_mm, reading.quality, reading.reason, reading.time_utc});
    if (reading.quality != Quality::kGood && !is_fault(reading) &&
        reading.reason != session::reason::kUnsettled) {
      remarks_.push_back(
          fmt::format("dial {}: {}, {}", rig_.dials[i].id, reading.reason, reading.detail));
    }
  }
  collected.remarks = remarks_;
  if (const auto otherwise = keep(collected, stop)) return *otherwise;

  ++attempts_[index];
  ++result_.stored;
  if (!counted_[index]) {
    counted_[index] = true;
    ++done_;
  }
  last_stored_ = index;
  report(
      CollectorStage::kStored, index, fmt::format("{}", fmt::join(collected.remarks, "; ")),
      readings);
  last_readings_ = std::move(readings);
  last_expected_ = std::move(expected);
  return Outcome::kStored;
}

std::optional<Collector::Outcome> Collector::keep(
    const CollectedSample& collected, const std::stop_token& stop) {
  for (;;) {
    std::string why;
    try {
      callbacks_.store(collected);
      return std::nullopt;
    } catch (const StoreLater& later) {
      why = later.what();
    }
    const Wish wish = wait_paused(collected.plan_index, PauseReason::kStore, why, "", stop);
    if (stop.stop_requested()) return Outcome::kStopped;
    if (wish == Wish::kSkip) return skipped(collected.plan_index, why);
    if (wish == Wish::kRetake) return Outcome::kAgain;
  }
}

Collector::Outcome Collector::robot_trouble(
    std::size_t index, const RobotFault& fault, const std::stop_token& stop) {
  const std::string why = fmt::format("{}: {}", describe(fault.kind), fault.detail);
  if (fault.kind == RobotFaultKind::kUnreachable) {
    result_.failed.push_back({index, why});
    if (!counted_[index]) {
      counted_[index] = true;
      ++done_;
    }
    report(CollectorStage::kFailed, index, why);
    return Outcome::kFailed;
  }
  const Wish wish = wait_paused(
      index, PauseReason::kRobot, why, "resume tries again, skip leaves the point out", stop);
  if (stop.stop_requested()) return Outcome::kStopped;
  return wish == Wish::kSkip ? skipped(index, fmt::format("skipped by the operator: {}", why))
                             : Outcome::kAgain;
}

Collector::Outcome Collector::skipped(std::size_t index, const std::string& why) {
  result_.skipped.push_back({index, why});
  if (!counted_[index]) {
    counted_[index] = true;
    ++done_;
  }
  report(CollectorStage::kSkipped, index, why);
  return Outcome::kSkipped;
}

// The point in hand was stopped: from outside, or by a wish.
Collector::Outcome Collector::interrupted(std::size_t index, const std::stop_token& stop) {
  if (stop.stop_requested()) return Outcome::kStopped;
  return take_wish() == Wish::kSkip ? skipped(index, "skipped by the operator")
                                    : Outcome::kAgain;
}

}  // namespace sixdial::acquisition
