#include "simulation/circumstances.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "geometry/same_pose.h"
#include "simulation/weight.h"

namespace sixdial::simulation {
namespace {

// A collector that is asked for a side comes from so far behind the pose.
constexpr double kFromBehind_rad = 0.01;
constexpr double kFromBehind_mm = 0.5;
// A plunger has moved if it went so many standard deviations of its reading.
constexpr double kMoves_sd = 5.0;
// A face that is nearer than this to letting go of a tip may do so.
constexpr double kHardlyTouches_mm = 0.2;

/// A plunger with friction: its direction turns once it has come back by more than the play.
struct Plunger {
  double play_mm = 0.0;
  double turning_mm = 0.0;  // furthest point in the present direction
  double direction = 0.0;   // 0: nobody knows
  bool placed = false;
  void go_to(double mm) {
    if (!placed) {
      placed = true;
      turning_mm = mm;
      return;
    }
    const double way_mm = mm - turning_mm;
    if (direction != 0.0 && way_mm * direction >= 0.0) {
      turning_mm = mm;
    } else if (std::abs(way_mm) > play_mm) {
      direction = way_mm > 0 ? 1.0 : -1.0;
      turning_mm = mm;
    }
  }
};

double play_of(const geometry::Dial& dial) {
  return kMoves_sd * std::hypot(dial.repeatability_mm, dial.resolution_mm / std::sqrt(12.0));
}

}  // namespace

std::vector<SidesFrom> sides_from(
    const geometry::RobotModel& robot, std::span<const Trial> trials) {
  // So many moves, on each side one in ten, and so many of a hundred against them: a plan that
  // comes from sides goes against half of its moves, and one that always comes from the same
  // side tells nothing.
  constexpr int kFewestMoves = 20;
  constexpr int kOneInSides = 10;
  constexpr double kNearlyAll = 0.95;
  std::vector<SidesFrom> result;
  for (std::size_t joint = 0; joint < robot.joints.size(); ++joint) {
    const auto j = static_cast<Eigen::Index>(joint);
    const double jitter = geometry::same_pose(robot.joints[joint].unit());
    int known = 0;
    int moves = 0;
    int up = 0;
    int against = 0;
    for (std::size_t t = 0; t < trials.size(); ++t) {
      const int side = trials[t].approach_of(joint);
      known += side != 0;
      if (t == 0 || side == 0 || trials[t].q.size() != trials[t - 1].q.size()) continue;
      const double way = trials[t].q[j] - trials[t - 1].q[j];
      if (std::abs(way) <= jitter || trials[t].assembly != trials[t - 1].assembly) continue;
      ++moves;
      up += side > 0;
      against += side * way < 0;
    }
    const bool both = std::min(up, moves - up) * kOneInSides >= moves;
    const bool reversed = moves >= kFewestMoves && both && against >= kNearlyAll * moves;
    result.push_back(
        known == 0 ? SidesFrom::kRows
        : reversed ? SidesFrom::kReversed
                   : SidesFrom::kColumns);
  }
  return result;
}

namespace {

/// Goes through a session as the robot did.
class Walk {
 public:
  Walk(const ForwardModel& model, const ModelVector& at, std::span<const Trial> trials)
      : model_(model), at_(at), trials_(trials), from_(sides_from(model.robot(), trials)) {
    for (const geometry::Dial& dial : model.rig().dials) {
      plungers_.push_back({.play_mm = play_of(dial)});
    }
    std::size_t against = 0;
    for (std::size_t t = 1; t < trials.size(); ++t) against += arrives_against_its_move(t);
    constexpr std::size_t kOneIn = 5;  // of random moves, half or more do
    comes_from_sides_ = against * kOneIn > trials.size();
  }

  /// Sample t, in order. Fills what depends on the past.
  void take(std::size_t t, Circumstance& sample) {
    const Trial& trial = trials_[t];
    sample.approach = sides_at(t);
    if (t == 0 || has_moved(t)) {
      for (const Eigen::VectorXd& q : way_to(t, sample.approach)) pass(trial, q);
      arrived_ = trial.q;
    }
    sample.travel = travel_;
    sample.plunger_direction.clear();
    for (const Plunger& each : plungers_) sample.plunger_direction.push_back(each.direction);
    sides_ = sample.approach;
    add_forces(trial, sample);
  }

 private:
  [[nodiscard]] double jitter(Eigen::Index joint) const {
    return geometry::same_pose(model_.robot().joints[static_cast<std::size_t>(joint)].unit());
  }
  [[nodiscard]] double behind(Eigen::Index joint) const {
    const bool turns = jitter(joint) == geometry::kSamePose_rad;
    return turns ? kFromBehind_rad : kFromBehind_mm;
  }
  [[nodiscard]] double side_of(const Trial& trial, Eigen::Index joint) const {
    const auto j = static_cast<std::size_t>(joint);
    const double side = trial.approach_of(j);
    return from_[j] == SidesFrom::kReversed ? -side : side;
  }

  /// The robot was sent behind its pose first: a joint arrives from another side than it came
  /// from, or the same pose is reached from another side.
  [[nodiscard]] bool arrives_against_its_move(std::size_t t) const {
    const Trial& trial = trials_[t];
    const Trial& before = trials_[t - 1];
    if (trial.q.size() != before.q.size() || trial.assembly != before.assembly) return false;
    bool moved = false;
    bool from_elsewhere = false;
    for (Eigen::Index joint = 0; joint < trial.q.size(); ++joint) {
      const double way = trial.q[joint] - before.q[joint];
      const double side = side_of(trial, joint);
      if (std::abs(way) > jitter(joint)) {
        moved = true;
        if (way * side < 0) return true;
      } else {
        from_elsewhere = from_elsewhere || side * side_of(before, joint) < 0;
      }
    }
    return from_elsewhere && !moved;
  }
  [[nodiscard]] bool comes_from_behind(std::size_t t) const {
    return comes_from_sides_ || (t > 0 && arrives_against_its_move(t));
  }

  /// Where nobody says a side, it is still that of the last move if the robot has not moved;
  /// and that of the way from the sample before, if sides were not recorded at all. A joint
  /// that moved by less than its encoder scatters while another one moved may have been sent
  /// either way, or not at all: nobody knows.
  [[nodiscard]] Eigen::VectorXd sides_at(std::size_t t) const {
    const Trial& trial = trials_[t];
    Eigen::VectorXd result(trial.q.size());
    for (Eigen::Index joint = 0; joint < result.size(); ++joint) {
      result[joint] = side_of(trial, joint);
      if (result[joint] != 0.0 || t == 0 || sides_.size() != result.size()) continue;
      const double way = trial.q[joint] - trials_[t - 1].q[joint];
      if (std::abs(way) <= jitter(joint)) {
        if (way == 0.0 || !any_moved(t)) result[joint] = sides_[joint];
      } else if (from_[static_cast<std::size_t>(joint)] == SidesFrom::kRows) {
        result[joint] = way > 0 ? 1.0 : -1.0;
      }
    }
    return result;
  }

  /// Since the sample before.
  [[nodiscard]] bool any_moved(std::size_t t) const {
    const Eigen::VectorXd way = trials_[t].q - trials_[t - 1].q;
    for (Eigen::Index joint = 0; joint < way.size(); ++joint) {
      if (std::abs(way[joint]) > jitter(joint)) return true;
    }
    return false;
  }

  [[nodiscard]] bool has_moved(std::size_t t) const {
    const Trial& trial = trials_[t];
    if (arrived_.size() != trial.q.size()) return true;
    if (comes_from_behind(t)) return true;
    for (Eigen::Index joint = 0; joint < trial.q.size(); ++joint) {
      if (std::abs(trial.q[joint] - arrived_[joint]) > jitter(joint)) return true;
    }
    return false;
  }

  /// Joint values that the robot passed on its way to sample t.
  [[nodiscard]] std::vector<Eigen::VectorXd> way_to(
      std::size_t t, const Eigen::VectorXd& sides) const {
    const Eigen::VectorXd& q = trials_[t].q;
    if (!comes_from_behind(t) || sides.isZero()) return {q};
    Eigen::VectorXd from = q;
    for (Eigen::Index joint = 0; joint < q.size(); ++joint) {
      from[joint] -= behind(joint) * sides[joint];
    }
    return {from, q};
  }

  /// The tool and the plungers at joint values q; where the robot has no pose, they stay.
  void pass(const Trial& trial, const Eigen::VectorXd& q) {
    const bool free = model_.rig().cuboid.mount == geometry::Mount::kFree;
    if (!model_.predict(
            at_, q, trial.assembly, free ? trial.gamma_rad : std::nullopt, true, seen_)) {
      return;
    }
    const Eigen::Vector3d here = seen_.frames.X[0].p;
    if (tool_) {
      const Eigen::Vector3d way = here - *tool_;
      constexpr double kMoves_mm = 1e-3;
      if (way.norm() > kMoves_mm) travel_ = way.normalized();
    }
    tool_ = here;
    for (std::size_t i = 0; i < plungers_.size(); ++i) plungers_[i].go_to(pushed_mm(i));
  }

  /// How far the plunger is in, in what was seen last; out of contact it rests at its stop.
  [[nodiscard]] double pushed_mm(std::size_t dial) const {
    if (dial >= seen_.in_contact.size()) return 0.0;
    const double reading_mm = seen_.reading[static_cast<Eigen::Index>(dial)];
    const double travel_mm = model_.rig().dials[dial].geometry.travel_mm;
    if (reading_mm >= travel_mm) return travel_mm;
    return seen_.in_contact[dial] ? reading_mm : 0.0;
  }

  /// Of each plunger on the cuboid. A dial that gave no reading may be out of contact, or may
  /// have failed: where the simulation sees it in contact, it pushes.
  void add_forces(const Trial& trial, Circumstance& sample) const {
    const auto& dials = model_.rig().dials;
    sample.plunger_force_n.assign(dials.size(), 0.0);
    sample.plunger_force_sd_n.assign(dials.size(), 0.0);
    for (std::size_t i = 0; i < dials.size() && i < trial.reading.size(); ++i) {
      const geometry::Dial& dial = dials[i];
      const double in_mm = trial.reading[i].value_or(pushed_mm(i));
      const bool touches = trial.reading[i].has_value() || in_mm > 0.0;
      if (touches) sample.plunger_force_n[i] = dial.force_n + dial.spring_n_per_mm * in_mm;
      if (!trial.reading[i] && i < seen_.in_contact.size()) {
        const double reading_mm = seen_.reading[static_cast<Eigen::Index>(i)];
        if (std::abs(reading_mm) < kHardlyTouches_mm) {
          sample.plunger_force_sd_n[i] = 0.5 * dial.force_n;
        }
      }
      sample.force_n += sample.plunger_force_n[i] * dial.geometry.axis;
    }
  }

  const ForwardModel& model_;
  const ModelVector& at_;
  std::span<const Trial> trials_;
  std::vector<SidesFrom> from_;    // by joint
  bool comes_from_sides_ = false;  // as a rule: the plan asked for sides
  std::vector<Plunger> plungers_;
  Eigen::VectorXd arrived_;  // joint values after the last move
  Eigen::VectorXd sides_;
  std::optional<Eigen::Vector3d> tool_;
  Eigen::Vector3d travel_{0, 0, 0};
  Prediction seen_;
};

/// Variance of wandering, per unit of `along`: of known values against the line between their
/// neighbours, and against their neighbour alone.
struct Wandering {
  double between = 0.0;
  double beyond = 0.0;
};
Wandering wandering_of(
    std::span<const double> along, std::span<const std::optional<double>> values,
    const std::vector<std::size_t>& known) {
  Wandering result;
  double between = 0, beyond = 0;
  for (std::size_t k = 1; k < known.size(); ++k) {
    const double since = along[known[k]] - along[known[k - 1]];
    if (!(since > 0)) continue;
    const double step = *values[known[k]] - *values[known[k - 1]];
    result.beyond += step * step / since;
    ++beyond;
    if (k + 1 == known.size()) break;
    const double until = along[known[k + 1]] - along[known[k]];
    if (!(until > 0)) continue;
    const double next = *values[known[k + 1]];
    const double line = (*values[known[k - 1]] * until + next * since) / (since + until);
    result.between += std::pow(*values[known[k]] - line, 2) * (since + until) / (since * until);
    ++between;
  }
  if (beyond > 0) result.beyond /= beyond;
  result.between = between > 0 ? result.between / between : result.beyond;
  return result;
}

}  // namespace

std::vector<Filled> without_gaps(
    std::span<const double> along, std::span<const std::optional<double>> values) {
  std::vector<Filled> result(values.size());
  std::vector<std::size_t> known;
  for (std::size_t i = 0; i < values.size(); ++i) {
    if (values[i]) known.push_back(i);
  }
  if (known.empty()) return result;
  const Wandering wanders = wandering_of(along, values, known);
  for (std::size_t i = 0; i < values.size(); ++i) {
    if (values[i]) {
      result[i].value = *values[i];
      continue;
    }
    const auto next = std::ranges::upper_bound(known, i);
    if (next == known.begin() || next == known.end()) {
      const std::size_t nearest = next == known.begin() ? known.front() : known.back();
      result[i] = {
          *values[nearest], std::sqrt(wanders.beyond * std::abs(along[i] - along[nearest]))};
      continue;
    }
    const std::size_t a = *(next - 1);
    const std::size_t b = *next;
    const double whole = along[b] - along[a];
    const double share = whole > 0 ? (along[i] - along[a]) / whole : 0.5;
    result[i] = {
        (1 - share) * *values[a] + share * *values[b],
        std::sqrt(wanders.between * std::max(0.0, whole) * share * (1 - share))};
  }
  return result;
}

std::vector<Circumstance> circumstances_of(
    const ForwardModel& model, const ModelVector& at, std::span<const Trial> trials) {
  std::vector<double> order;
  std::vector<std::optional<double>> times, temperatures;
  std::optional<double> first_s;
  for (const Trial& trial : trials) {
    order.push_back(static_cast<double>(order.size()));
    times.push_back(trial.time_s);
    temperatures.push_back(trial.temperature_c);
    if (!first_s) first_s = trial.time_s;
  }
  const std::vector<Filled> time_s = without_gaps(order, times);
  std::vector<double> along;
  for (const Filled& each : time_s) along.push_back(first_s ? each.value : order[along.size()]);
  std::vector<Filled> temperature_degC = without_gaps(along, temperatures);
  if (std::ranges::none_of(temperatures, [](const auto& each) { return each.has_value(); })) {
    constexpr double kReference_degC = 20.0;  // then no link grows, ISO 1
    for (Filled& each : temperature_degC) each.value = kReference_degC;
  }

  std::vector<Circumstance> result;
  Weight weight(model.robot(), at.head(model.robot_parameter_count()));
  const double nan = std::numeric_limits<double>::quiet_NaN();
  std::vector<double> previous_mm(model.rig().dials.size(), nan);
  Walk walk(model, at, trials);
  for (std::size_t t = 0; t < trials.size(); ++t) {
    Circumstance each;
    each.order = static_cast<int>(t);
    each.time_h = (time_s[t].value - first_s.value_or(0.0)) / 3600.0;
    each.time_sd_h = time_s[t].sd / 3600.0;
    each.temperature_degC = temperature_degC[t].value;
    each.temperature_sd_degC = temperature_degC[t].sd;
    walk.take(t, each);
    weight.take(trials[t].q, trials[t].assembly, each);
    each.previous_mm = previous_mm;
    for (std::size_t i = 0; i < previous_mm.size() && i < trials[t].reading.size(); ++i) {
      previous_mm[i] = trials[t].reading[i].value_or(nan);
    }
    result.push_back(std::move(each));
  }
  return result;
}

std::vector<Doubt> doubts_of(std::span<const Circumstance> samples) {
  std::vector<Doubt> result;
  if (samples.empty()) return result;
  const Circumstance& first = samples.front();
  // `known` says what a sample knows; `otherwise` changes it.
  const auto add = [&](auto&& known, auto&& otherwise) {
    if (std::ranges::none_of(samples, known)) return;
    for (std::size_t t = 0; t < samples.size(); ++t) {
      if (known(samples[t])) continue;
      result.push_back({t, samples[t]});
      otherwise(result.back().otherwise);
    }
  };
  add([](const Circumstance& s) { return s.temperature_sd_degC == 0.0; },
      [](Circumstance& s) { s.temperature_degC += s.temperature_sd_degC; });
  add([](const Circumstance& s) { return s.time_sd_h == 0.0; },
      [](Circumstance& s) { s.time_h += s.time_sd_h; });
  for (Eigen::Index joint = 0; joint < first.approach.size(); ++joint) {
    add([joint](const Circumstance& s) { return s.approach[joint] != 0.0; },
        [joint](Circumstance& s) { s.approach[joint] = 1.0; });
  }
  const bool in_space =
      std::ranges::any_of(samples, [](const Circumstance& s) { return s.travel.z() != 0.0; });
  const int axes = in_space ? 3 : 2;
  for (int axis = 0; axis < axes; ++axis) {  // a unit vector of any direction
    add([](const Circumstance& s) { return !s.travel.isZero(); },
        [axis, axes](Circumstance& s) { s.travel[axis] = std::sqrt(1.0 / axes); });
  }
  for (std::size_t i = 0; i < first.plunger_direction.size(); ++i) {
    add([i](const Circumstance& s) { return s.plunger_direction[i] != 0.0; },
        [i](Circumstance& s) { s.plunger_direction[i] = 1.0; });
    add([i](const Circumstance& s) { return s.plunger_force_sd_n[i] == 0.0; },
        [i](Circumstance& s) { s.plunger_force_n[i] += s.plunger_force_sd_n[i]; });
  }
  std::ranges::stable_sort(result, {}, &Doubt::trial);
  return result;
}

}  // namespace sixdial::simulation
