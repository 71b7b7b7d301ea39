#include "mock_devices/session_generator.h"

#include <fmt/format.h>

#include <cmath>
#include <stdexcept>

#include "mock_devices/hidden/cause.h"
#include "mock_devices/random.h"

namespace sixdial::mock_devices {
namespace {

using Eigen::Vector2d;

// Who plans an approach makes the robot come from so far behind the pose.
constexpr double kOvershoot_rad = 0.02;
// A joint that is sent no further than this stays where it is; what its encoder then says is
// jitter.
constexpr double kStill_rad = 1e-4;
constexpr double kStill_mm = 1e-9;
constexpr double kPlay_mm = 0.002;  // a plunger that comes back by less keeps its direction

struct Shown {
  Readings mm;
  std::array<int, 2> approach;  // as a controller knows it: 0 before the first move
};

/// The rig on its way through a plan. What a move leaves behind (the side on which a gear
/// lies, the elbows' play, the friction of a plunger) stays until the next move: standing still
/// takes nothing of it away. Before the first move it is somewhere, and nobody knows where.
class Way {
 public:
  explicit Way(const WorldModel& model) : model_(model) {
    const Random before(model.world().seed, Stream::kBefore);
    const auto side = [&](std::uint64_t counter) {
      return before.uniform(counter) < 0.5 ? -1 : 1;
    };
    side_ = {side(0), side(1)};
    travel_ = direction(before.uniform(2, 0.0, kTwoPi));
    for (std::size_t dial = 0; dial < model.dial_count(); ++dial) {
      plungers_.push_back({side(3 + dial), {}});
    }
  }

  /// Goes to a pose and reads the dials, noise-free.
  [[nodiscard]] Shown go(const PlannedPose& planned, Moment moment) {
    const bool asked = planned.approach != std::array{0, 0};
    if (asked) {
      moment.q_rad =
          planned.q_rad - kOvershoot_rad * Vector2d(planned.approach[0], planned.approach[1]);
      pass(moment);
    }
    moment.q_rad = planned.q_rad;
    arrive(moment, asked);
    return {readings(pass(moment), moment, planned), known_};
  }

 private:
  struct PlungerState {
    int direction;
    std::optional<double> turning_mm;  // furthest point in that direction
  };

  /// By how much this arrival is off; a robot that stands still stays as far off as it was.
  void arrive(Moment& moment, bool asked) {
    const Scatter& scatter = model_.world().scatter;
    if (!(scatter.tool_mm > 0.0 || scatter.joints_rad > 0.0)) return;
    const bool moved =
        asked || !sent_to_ || (moment.q_rad - *sent_to_).cwiseAbs().maxCoeff() > kStill_rad;
    sent_to_ = moment.q_rad;
    if (moved) {
      const Random random(model_.world().seed, Stream::kScatter);
      const auto first = 4 * static_cast<std::uint64_t>(moment.sample);
      off_mm_ = scatter.tool_mm * Vector2d(random.normal(first), random.normal(first + 1));
      off_rad_ =
          scatter.joints_rad * Vector2d(random.normal(first + 2), random.normal(first + 3));
    }
    moment.scatter_mm = off_mm_;
    moment.q_rad += off_rad_;
  }

  /// Arrives somewhere; `moment` gets what it owes to the past. Empty where there is no pose.
  std::optional<TruePose> pass(Moment& moment) {
    for (std::size_t joint = 0; joint < 2; ++joint) {
      const auto j = static_cast<Eigen::Index>(joint);
      const double way = q_here_ ? moment.q_rad[j] - (*q_here_)[j] : 0.0;
      if (std::abs(way) <= kStill_rad) continue;
      side_[joint] = known_[joint] = way > 0 ? 1 : -1;
    }
    moment.approach = side_;
    if (q_here_ && (moment.q_rad - *q_here_).cwiseAbs().maxCoeff() > kStill_rad) {
      Moment start = moment;
      start.q_rad = *q_here_;
      const auto from = model_.tool(start);
      const auto to = model_.tool(moment);
      if (from && to && (*to - *from).norm() > kStill_mm) travel_ = (*to - *from).normalized();
    }
    moment.travel = travel_;
    q_here_ = moment.q_rad;
    auto pose = model_.pose(moment);
    if (!pose) return pose;
    for (std::size_t dial = 0; dial < plungers_.size(); ++dial) {
      const auto& push = pose->pushes[dial];
      const double travel_mm = model_.world().rig.dials[dial].geometry.travel_mm;
      // Out of contact the plunger rests at its stop.
      follow(plungers_[dial], push ? std::min(push->displacement_mm, travel_mm) : 0.0);
    }
    return pose;
  }

  static void follow(PlungerState& plunger, double mm) {
    const double way = plunger.turning_mm ? mm - *plunger.turning_mm : 0.0;
    if (way * plunger.direction < 0 && std::abs(way) <= kPlay_mm) return;
    if (way != 0.0) plunger.direction = way > 0 ? 1 : -1;
    plunger.turning_mm = mm;
  }

  [[nodiscard]] Readings readings(
      const std::optional<TruePose>& pose, const Moment& moment,
      const PlannedPose& planned) const {
    if (!pose) {
      throw std::invalid_argument(fmt::format(
          "{} point {}: the true robot cannot take the joint angles ({:.6f}, {:.6f}) rad",
          planned.set, planned.point, moment.q_rad[0], moment.q_rad[1]));
    }
    Readings result;
    for (std::size_t dial = 0; dial < plungers_.size(); ++dial) {
      const auto& push = pose->pushes[dial];
      const double travel_mm = model_.world().rig.dials[dial].geometry.travel_mm;
      if (!push || push->on_corner || push->displacement_mm >= travel_mm) {
        result.emplace_back();
      } else {
        result.emplace_back(model_.shown_mm(
            dial, push->displacement_mm, plungers_[dial].direction, moment, true));
      }
    }
    return result;
  }

  const WorldModel& model_;
  std::optional<Vector2d> q_here_, sent_to_;
  Vector2d off_mm_{0, 0}, off_rad_{0, 0};
  std::array<int, 2> side_{}, known_{0, 0};
  Vector2d travel_;
  std::vector<PlungerState> plungers_;
};

Readings rewired(const WorldModel& model, const Readings& by_dial) {
  Readings result(by_dial.size());
  for (std::size_t name = 0; name < by_dial.size(); ++name) {
    result[name] = by_dial[model.wired_to(name)];
  }
  return result;
}

}  // namespace

double GeneratedSession::effect_rms_mm() const {
  double sum = 0.0;
  int count = 0;
  for (const MeasuredRow& row : rows) {
    for (std::size_t i = 0; i < row.noise_free_mm.size(); ++i) {
      if (!row.noise_free_mm[i] || !row.no_effects_mm[i]) continue;
      sum += std::pow(*row.noise_free_mm[i] - *row.no_effects_mm[i], 2);
      ++count;
    }
  }
  return count > 0 ? std::sqrt(sum / count) : 0.0;
}

GeneratedSession generate_session(const World& world, const std::vector<PlannedPose>& plan) {
  const WorldModel model(world);
  World bare_world = world;
  bare_world.effects.clear();
  const WorldModel bare(bare_world);

  GeneratedSession session;
  session.rows.reserve(plan.size());
  Way way(model);
  Way bare_way(bare);
  Readings handed_before;
  for (std::size_t i = 0; i < plan.size(); ++i) {
    const PlannedPose& planned = plan[i];
    MeasuredRow row;
    row.planned = planned;
    row.temperature_c = planned.temperature_c.value_or(model.temperature_c(planned.time_s));
    const Moment moment{
        .time_s = planned.time_s,
        .temperature_c = row.temperature_c,
        .sample = static_cast<std::int64_t>(i),
        .assembly = planned.assembly};
    const Shown shown = way.go(planned, moment);
    row.approach = shown.approach;
    row.no_effects_mm = bare_way.go(planned, moment).mm;
    row.noise_free_mm = rewired(model, shown.mm);

    Readings handed = shown.mm;
    for (std::size_t dial = 0; dial < handed.size(); ++dial) {
      if (!handed[dial]) continue;
      const double gross = model.gross_error_mm(dial, moment.sample);
      row.gross = row.gross || gross != 0.0;
      handed[dial] = model.quantised_mm(*handed[dial] + model.noise_mm(dial, i) + gross);
    }
    handed = rewired(model, handed);
    const Readings fresh = handed;
    for (std::size_t dial = 0; dial < handed.size() && !handed_before.empty(); ++dial) {
      if (!model.is_stale(dial, moment.sample)) continue;
      handed[dial] = handed_before[dial];
      row.stale = true;
    }
    row.dial_mm = handed;
    handed_before = fresh;
    session.rows.push_back(std::move(row));
  }
  return session;
}

std::vector<PlannedPose> random_plan(
    const geometry::Rig& rig, std::uint64_t seed, int count_g1, int count_g2,
    const Vector2d& low_mm, const Vector2d& high_mm) {
  const Random random(seed, Stream::kRobot, 1);
  // Angles are continuous around the reference pose: theta2 passes pi on the default rectangle.
  const auto reference = geometry::inverse(
      rig.robot.nominal, rig.cuboid.reference_pose_mm, rig.robot.working_mode);
  if (!reference) {
    throw std::invalid_argument(
        "random_plan: the nominal robot cannot take its reference pose");
  }
  constexpr std::uint64_t kMostTries = 1'000'000;
  std::vector<PlannedPose> plan;
  double time_s = 0.0;
  std::uint64_t tried = 0;
  while (static_cast<int>(plan.size()) < count_g1 + count_g2) {
    const std::uint64_t counter = 4 * tried;
    if (++tried > kMostTries) {
      throw std::invalid_argument(
          "random_plan: the nominal robot reaches next to nothing of this rectangle");
    }
    const Vector2d target(
        random.uniform(counter, low_mm.x(), high_mm.x()),
        random.uniform(counter + 1, low_mm.y(), high_mm.y()));
    const auto q =
        geometry::inverse(rig.robot.nominal, target, rig.robot.working_mode, reference.value());
    if (!q) continue;
    const auto assembly = geometry::assembly_at(rig.robot.nominal, *q, target);
    if (!assembly) continue;
    PlannedPose pose;
    const int index = static_cast<int>(plan.size());
    pose.set = index < count_g1 ? "G1" : "G2";
    pose.point = index;
    time_s += random.uniform(counter + 2, 6.0, 10.0);
    pose.time_s = std::round(time_s * 1000.0) / 1000.0;
    // Nine decimals, as the file has them: what is written is what was commanded.
    pose.q_rad = (*q * 1e9).array().round().matrix() / 1e9;
    pose.target_mm = target;
    pose.assembly = *assembly;
    plan.push_back(pose);
  }
  return plan;
}

}  // namespace sixdial::mock_devices
