// Plans by rule: a grid or random points, each tried against the nominal robot and the dials.
#include <Random123/philox.h>
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <utility>

#include "geometry/long_work.h"
#include "geometry/units.h"
#include "session/csv.h"
#include "session/plan.h"
#include "session/trials.h"

namespace sixdial::session {
namespace {

using Eigen::Vector2d;

// Distal links closer to one line than this make the tool's position run away (singular).
constexpr double kLeastSine = 0.1;
// The clamp angle is known to a degree.
constexpr double kClampError_rad = geometry::kRadPerDeg;

/// Numbers in [0, 1) from Philox 4x32-10 by seed, stream and place: the same on every machine.
class Uniform {
 public:
  Uniform(std::uint64_t seed, std::uint32_t stream) : stream_(stream) {
    key_[0] = static_cast<std::uint32_t>(seed);
    key_[1] = static_cast<std::uint32_t>(seed >> 32U);
  }

  double next() {
    const r123::Philox4x32::ctr_type counter{
        {static_cast<std::uint32_t>(count_), static_cast<std::uint32_t>(count_ >> 32U), stream_,
         0U}};
    const auto bits = r123::Philox4x32()(counter, key_);
    ++count_;
    const std::uint64_t both = (std::uint64_t{bits[0]} << 32U) | bits[1];
    return static_cast<double>(both >> 11U) * 0x1.0p-53;
  }

 private:
  r123::Philox4x32::key_type key_{};
  std::uint32_t stream_;
  std::uint64_t count_ = 0;
};

/// A stream for each set, so that G1 and G2 of one seed are different points (FNV-1a).
std::uint32_t stream_of(std::string_view set) {
  std::uint32_t hash = 2166136261U;
  for (const char c : set) hash = (hash ^ static_cast<unsigned char>(c)) * 16777619U;
  return hash;
}

// To what a plan file holds, so that writing and reading gives the same plan.
Vector2d rounded(const Vector2d& v, int digits) {
  return {rounded_decimal(v.x(), digits), rounded_decimal(v.y(), digits)};
}

PlanRefusal refusal_of(const Vector2d& target, std::string reason, std::string advice) {
  return {-1, target, std::move(reason), std::move(advice)};
}

std::optional<PlanRefusal> contacts_refused(
    const geometry::Rig& rig, const Vector2d& target, const geometry::CuboidPose& pose) {
  const auto dials = rig.dial_geometries();
  std::vector<geometry::DialReading> readings;
  std::string missing;
  for (std::size_t i = 0; i < dials.size(); ++i) {
    const auto contact = geometry::touch(dials[i], pose, rig.cuboid.side_mm);
    if (!contact && contact.error() == geometry::ContactTrouble::kBeyondTravel) {
      return refusal_of(
          target,
          fmt::format(
              "the cuboid would push dial {} beyond its travel of {} mm", rig.dials[i].id,
              dials[i].travel_mm),
          "keep the targets away from that dial or move it back");
    }
    if (contact && in_contact(rig.dials[i], contact->displacement_mm)) {
      readings.push_back(
          {static_cast<int>(i), contact->displacement_mm, reading_sigma_mm(rig.dials[i])});
      continue;
    }
    if (!missing.empty()) missing += ", ";
    missing += fmt::format(
        "{}: {}", rig.dials[i].id,
        contact ? "at the end of its travel" : describe(contact.error()));
  }
  const auto three =
      geometry::best_active_three(dials, readings, rig.cuboid.side_mm, pose.gamma_rad);
  if (three) return std::nullopt;
  return refusal_of(
      target,
      fmt::format(
          "with the robot at ({:.3f}, {:.3f}) mm and the cuboid turned by {:.2f} deg there are "
          "{} ({})",
          pose.p_WE.x(), pose.p_WE.y(), pose.gamma_rad * geometry::kDegPerRad,
          describe(three.error()), missing),
      "choose a smaller rectangle, a smaller robot error, or move the dials");
}

using TargetsAndAngles = std::vector<std::pair<Vector2d, Vector2d>>;

/// From which side each joint comes: in turn all from below, all from above, every other one.
std::vector<int> sides(std::size_t turn, std::size_t joints) {
  std::vector<int> signs(joints);
  for (std::size_t j = 0; j < joints; ++j) {
    const bool other = turn % 4 >= 2 && j % 2 == 1;
    signs[j] = (turn % 2 == 0) != other ? 1 : -1;
  }
  return signs;
}

/// The plan's points from its targets: angles are given, order is final.
Plan numbered(const TargetsAndAngles& target_and_q, const PlanOptions& options) {
  Plan plan;
  for (std::size_t i = 0; i < target_and_q.size(); ++i) {
    PlanPoint point;
    point.set = options.set;
    point.point = options.first_point + static_cast<int>(i);
    point.target_mm = target_and_q[i].first;
    point.q = target_and_q[i].second;
    const bool both = options.approach == ApproachRule::kBothSides &&
                      i % static_cast<std::size_t>(options.every) == 0;
    const auto joints = static_cast<std::size_t>(point.q.size());
    for (int r = 0; r < options.repeats; ++r) {
      point.approach.assign(joints, 0);
      if (options.approach != ApproachRule::kAsItComes) point.approach = sides(i, joints);
      if (both) point.approach = sides(0, joints);
      plan.points.push_back(point);
      ++point.repeat;
      if (!both) continue;
      point.approach = sides(1, joints);
      plan.points.push_back(point);
      ++point.repeat;
    }
  }
  return plan;
}

std::optional<PlanRefusal> request_refused(
    const geometry::Rig& rig, std::int64_t points, const PlanOptions& options) {
  constexpr std::int64_t kMostPoints = 1'000'000;
  const auto refuse = [](std::string reason, std::string advice) {
    return PlanRefusal{-1, {0, 0}, std::move(reason), std::move(advice)};
  };
  const Rectangle& area = options.rectangle;
  const Vector2d size = area.max_mm - area.min_mm;
  if (options.set.empty()) return refuse("the set has no name", "use G1, G2 or a name");
  if (points < 1 || points > kMostPoints) {
    return refuse(fmt::format("{} points make no plan", points), "ask for 1 to 1000000 points");
  }
  if (!area.min_mm.allFinite() || !area.max_mm.allFinite() || size.minCoeff() < 0.0) {
    return refuse("the rectangle has no area", "give the lower left corner first");
  }
  if (!(options.margin_mm >= 0.0) || size.minCoeff() < 2 * options.margin_mm) {
    return refuse(
        fmt::format("a margin of {} mm leaves nothing of the rectangle", options.margin_mm),
        "use a margin from 0 to half the shorter side");
  }
  if (!(options.robot_error_mm >= 0.0) || !std::isfinite(options.robot_error_mm)) {
    return refuse("the robot error is negative", "give it in mm, 0 or more");
  }
  if (options.repeats < 1 || options.every < 1 || options.first_point < 0 ||
      options.repeats * points > kMostPoints) {
    return refuse(
        "repeats, every or first point make no sense", "use 1 or more, and 0 or more");
  }
  const auto& modes = options.working_modes;
  for (auto mode = modes.begin(); mode != modes.end(); ++mode) {
    if (std::find(modes.begin(), mode, *mode) == mode) continue;
    return refuse(
        fmt::format("working mode {} is named twice", to_string(*mode)), "name it once");
  }
  if (!rig.robot.nominal.allFinite()) return refuse("the rig has no robot", "load a rig file");
  return std::nullopt;
}

std::vector<geometry::WorkingMode> modes_of(
    const geometry::Rig& rig, const PlanOptions& options) {
  if (options.working_modes.empty()) return {rig.robot.working_mode};
  return options.working_modes;
}

PlanRefusal refused_in(
    PlanRefusal refusal, geometry::WorkingMode mode, std::size_t points,
    const PlanOptions& options) {
  refusal.point = options.first_point + static_cast<int>(points);
  if (options.working_modes.size() > 1) {
    refusal.reason = fmt::format("in working mode {}: {}", to_string(mode), refusal.reason);
    refusal.advice += ", or leave this mode out";
  }
  return refusal;
}

/// Where the joints turn from: the reference pose, else the rectangle's middle.
tl::expected<Vector2d, PlanRefusal> home_angles(
    const geometry::Rig& rig, geometry::WorkingMode mode, const Rectangle& area) {
  const Vector2d middle = (area.min_mm + area.max_mm) / 2;
  for (const Vector2d& place : {rig.cuboid.reference_pose_mm, middle}) {
    if (const auto q = geometry::inverse(rig.robot.nominal, place, mode)) return *q;
  }
  return tl::unexpected(refusal_of(
      middle,
      fmt::format(
          "in working mode {} the robot reaches neither the reference pose nor the rectangle's "
          "middle",
          to_string(mode)),
      "check the working mode and the rectangle"));
}

}  // namespace

std::string_view to_string(ApproachRule rule) {
  switch (rule) {
    case ApproachRule::kAsItComes:
      return "as-it-comes";
    case ApproachRule::kAlternate:
      return "alternate";
    case ApproachRule::kBothSides:
      return "both-sides";
  }
  return "as-it-comes";
}

std::optional<ApproachRule> approach_rule_from(std::string_view text) {
  for (const ApproachRule rule :
       {ApproachRule::kAsItComes, ApproachRule::kAlternate, ApproachRule::kBothSides}) {
    if (to_string(rule) == text) return rule;
  }
  return std::nullopt;
}

std::string describe(const PlanRefusal& refusal) {
  std::string text;
  if (refusal.point >= 0) {
    text = fmt::format(
        "point {} at ({:.3f}, {:.3f}) mm: ", refusal.point, refusal.target_mm.x(),
        refusal.target_mm.y());
  }
  return text + refusal.reason + "; " + refusal.advice;
}

tl::expected<Vector2d, PlanRefusal> measurable(
    const geometry::Rig& rig, const Vector2d& target_mm, geometry::WorkingMode mode,
    double robot_error_mm, const Vector2d& near) {
  const auto refuse = [&](std::string reason) {
    return tl::unexpected(refusal_of(
        target_mm, std::move(reason), "choose a rectangle inside the robot's workspace"));
  };
  const geometry::ParameterVector& v = rig.robot.nominal;
  const auto exact = geometry::inverse(v, target_mm, mode, near);
  if (!exact) return refuse(std::string(describe(exact.error())));
  const Vector2d q = rounded(*exact, 9);
  const auto assembly = geometry::assembly_at(v, q, target_mm);
  if (!assembly) return refuse(std::string(describe(assembly.error())));
  const auto pose = geometry::forward(v, q, *assembly);
  if (!pose) return refuse(std::string(describe(pose.error())));
  const double between = pose->distal_angle(0) - pose->distal_angle(1);
  if (std::abs(std::sin(between)) < kLeastSine) {
    return refuse("the distal links are within 6 degrees of one line there (singular)");
  }
  const auto reference = geometry::reference_link_angle(rig);
  if (rig.dials.empty() || !reference) return q;

  // The tool in the middle and off by the robot's error in eight directions, the clamp either
  // way.
  const double gamma = geometry::cuboid_angle(rig, *reference, *pose, 0.0);
  for (int direction = -1; direction < 8; ++direction) {
    const double angle = direction * std::numbers::pi / 4;
    const Vector2d off =
        direction < 0 ? Vector2d(0, 0)
                      : Vector2d(robot_error_mm * Vector2d(std::cos(angle), std::sin(angle)));
    for (const double clamp : {0.0, -kClampError_rad, kClampError_rad}) {
      const geometry::CuboidPose cuboid{target_mm + off, gamma + clamp};
      if (auto refusal = contacts_refused(rig, target_mm, cuboid)) {
        return tl::unexpected(std::move(*refusal));
      }
    }
  }
  return q;
}

tl::expected<Plan, PlanRefusal> plan_grid(
    const geometry::Rig& rig, int nx, int ny, const PlanOptions& options) {
  const std::int64_t count = nx < 1 || ny < 1 ? 0 : std::int64_t{nx} * ny;
  if (auto refusal = request_refused(rig, count, options)) {
    return tl::unexpected(std::move(*refusal));
  }
  const Vector2d margin(options.margin_mm, options.margin_mm);
  const Vector2d low = options.rectangle.min_mm + margin;
  const Vector2d size = options.rectangle.max_mm - margin - low;
  const auto part = [](int i, int n) {
    return n == 1 ? 0.5 : static_cast<double>(i) / static_cast<double>(n - 1);
  };
  Uniform random(options.seed, stream_of(options.set));
  TargetsAndAngles points;
  for (const geometry::WorkingMode mode : modes_of(rig, options)) {
    const auto home = home_angles(rig, mode, options.rectangle);
    if (!home) return tl::unexpected(home.error());
    const std::size_t first = points.size();
    for (int iy = 0; iy < ny; ++iy) {
      for (int step = 0; step < nx; ++step) {
        geometry::check_end();
        const int ix = iy % 2 == 0 ? step : nx - 1 - step;  // back and forth
        const Vector2d target =
            rounded(low + Vector2d(size.x() * part(ix, nx), size.y() * part(iy, ny)), 6);
        auto q = measurable(rig, target, mode, options.robot_error_mm, *home);
        if (!q) {
          return tl::unexpected(refused_in(std::move(q.error()), mode, points.size(), options));
        }
        points.emplace_back(target, *q);
      }
    }
    if (options.shuffle) {  // Fisher-Yates
      for (std::size_t i = points.size() - 1; i > first; --i) {
        const auto j = first + static_cast<std::size_t>(
                                   random.next() * static_cast<double>(i - first + 1));
        std::swap(points[i], points[j]);
      }
    }
  }
  return numbered(points, options);
}

tl::expected<Plan, PlanRefusal> plan_random(
    const geometry::Rig& rig, int count, const PlanOptions& options) {
  if (auto refusal = request_refused(rig, count, options)) {
    return tl::unexpected(std::move(*refusal));
  }
  const Vector2d margin(options.margin_mm, options.margin_mm);
  const Vector2d low = options.rectangle.min_mm + margin;
  const Vector2d size = options.rectangle.max_mm - margin - low;
  Uniform random(options.seed, stream_of(options.set));
  TargetsAndAngles points;
  const std::int64_t most_draws = std::int64_t{kMostDrawsPerPoint} * count;
  for (const geometry::WorkingMode mode : modes_of(rig, options)) {
    const auto home = home_angles(rig, mode, options.rectangle);
    if (!home) return tl::unexpected(home.error());
    const std::size_t first = points.size();
    const std::size_t all = first + static_cast<std::size_t>(count);
    for (std::int64_t draw = 0; points.size() < all; ++draw) {
      geometry::check_end();
      const double x = random.next();
      const double y = random.next();
      const Vector2d target = rounded(low + Vector2d(size.x() * x, size.y() * y), 6);
      auto q = measurable(rig, target, mode, options.robot_error_mm, *home);
      if (q) {
        points.emplace_back(target, *q);
      } else if (draw + 1 >= most_draws) {
        q.error().reason = fmt::format(
            "only {} of {} random points can be measured; the last one: {}",
            points.size() - first, draw + 1, q.error().reason);
        return tl::unexpected(refused_in(std::move(q.error()), mode, points.size(), options));
      }
    }
  }
  return numbered(points, options);
}

}  // namespace sixdial::session
