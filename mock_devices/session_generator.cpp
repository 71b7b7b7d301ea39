#include "mock_devices/session_generator.h"

#include <fmt/format.h>

#include <cmath>
#include <stdexcept>

#include "mock_devices/random.h"

namespace sixdial::mock_devices {
namespace {

using Eigen::Vector2d;

// A planned approach that the direct move does not give is made from this far behind the pose.
constexpr double kOvershoot_rad = 0.02;
constexpr double kStill_rad = 1e-9;
constexpr double kStill_mm = 1e-9;

int sign_of(double value, double still) { return value > still ? 1 : value < -still ? -1 : 0; }

/// A pose and where the last stretch of the move to it began.
struct Arrival {
  std::array<int, 2> approach{0, 0};
  std::optional<Vector2d> q_from;
};

Arrival arrival_of(const PlannedPose& pose, const std::optional<Vector2d>& q_before) {
  Arrival arrival;
  Vector2d from = q_before.value_or(pose.q_rad);
  for (int joint = 0; joint < 2; ++joint) {
    const auto j = static_cast<std::size_t>(joint);
    const int direct =
        q_before ? sign_of(pose.q_rad[joint] - (*q_before)[joint], kStill_rad) : 0;
    const int wanted = pose.approach[j];
    arrival.approach[j] = wanted != 0 ? wanted : direct;
    if (wanted != 0 && wanted != direct) {
      from[joint] = pose.q_rad[joint] - kOvershoot_rad * wanted;
    }
  }
  if (q_before || pose.approach != std::array{0, 0}) arrival.q_from = from;
  return arrival;
}

struct Shown {
  Readings mm;
  std::vector<int> direction;  // of each plunger's last move
};

/// The readings of one pose, noise-free.
Shown shown_at(
    const WorldModel& model, Moment moment, const std::optional<Vector2d>& q_from,
    const std::string& name) {
  std::vector<std::optional<Push>> before;
  if (q_from) {
    Moment start = moment;
    start.q_rad = *q_from;
    // At the start of the last stretch the travel is not yet known; it hardly matters there.
    const auto tool_from = model.tool(start);
    const auto tool_to = model.tool(moment);
    if (tool_from && tool_to) {
      const Vector2d way = *tool_to - *tool_from;
      if (way.norm() > kStill_mm) moment.travel = way.normalized();
    }
    if (const auto pose = model.pose(start)) before = pose->pushes;
  }
  const auto pose = model.pose(moment);
  if (!pose) {
    throw std::invalid_argument(fmt::format(
        "{}: the true robot cannot take the joint angles ({:.6f}, {:.6f}) rad", name,
        moment.q_rad[0], moment.q_rad[1]));
  }
  Shown result;
  for (std::size_t dial = 0; dial < model.dial_count(); ++dial) {
    const auto& push = pose->pushes[dial];
    const double travel = model.world().rig.dials[dial].geometry.travel_mm;
    int direction = 0;
    if (!push || push->on_corner || push->displacement_mm >= travel) {
      result.mm.emplace_back();
    } else {
      if (q_from && !before.empty()) {
        // Out of contact the plunger rests at its stop, so it can only have been pushed in.
        const double from_mm = before[dial] ? before[dial]->displacement_mm : 0.0;
        direction = sign_of(push->displacement_mm - from_mm, kStill_mm);
      }
      result.mm.emplace_back(
          model.shown_mm(dial, push->displacement_mm, direction, moment, true));
    }
    result.direction.push_back(direction);
  }
  return result;
}

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
  std::optional<Vector2d> q_before;
  Readings handed_before;
  for (std::size_t i = 0; i < plan.size(); ++i) {
    const PlannedPose& planned = plan[i];
    const Arrival arrival = arrival_of(planned, q_before);
    MeasuredRow row;
    row.planned = planned;
    row.approach = arrival.approach;
    row.temperature_c = planned.temperature_c.value_or(model.temperature_c(planned.time_s));
    const Moment moment{
        .time_s = planned.time_s,
        .temperature_c = row.temperature_c,
        .sample = static_cast<std::int64_t>(i),
        .q_rad = planned.q_rad,
        .approach = arrival.approach,
        .assembly = planned.assembly};
    const std::string name = fmt::format("{} point {}", planned.set, planned.point);
    const Shown shown = shown_at(model, moment, arrival.q_from, name);
    row.no_effects_mm = shown_at(bare, moment, arrival.q_from, name).mm;
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
    q_before = planned.q_rad;
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
