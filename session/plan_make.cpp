// Plans by rule: a grid or random points. In the plane targets of a rectangle, each tried
// against the nominal robot and the dials; in space plan_in_space.h.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "geometry/long_work.h"
#include "geometry/tool.h"
#include "session/plan.h"
#include "session/plan_draw.h"
#include "session/plan_in_space.h"

namespace sixdial::session {
namespace {

using Eigen::Vector2d;

/// From which side each joint comes: in turn all from below, all from above, every other one.
std::vector<int> sides(std::size_t turn, std::size_t joints) {
  std::vector<int> signs(joints);
  for (std::size_t j = 0; j < joints; ++j) {
    const bool other = turn % 4 >= 2 && j % 2 == 1;
    signs[j] = (turn % 2 == 0) != other ? 1 : -1;
  }
  return signs;
}

/// The plan's points from its targets: joint values are given, order is final.
Plan numbered(const std::vector<PlanPose>& poses, const PlanOptions& options) {
  Plan plan;
  for (std::size_t i = 0; i < poses.size(); ++i) {
    PlanPoint point;
    point.set = options.set;
    point.point = options.first_point + static_cast<int>(i);
    point.target_mm = poses[i].target_mm;
    point.q = poses[i].q;
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

PlanRefusal refuse(std::string reason, std::string advice) {
  return refusal_of(Vector2d(0, 0), std::move(reason), std::move(advice));
}

std::optional<PlanRefusal> rectangle_refused(const PlanOptions& options) {
  const Rectangle& area = options.rectangle;
  const Vector2d size = area.max_mm - area.min_mm;
  if (!area.min_mm.allFinite() || !area.max_mm.allFinite() || size.minCoeff() < 0.0) {
    return refuse("the rectangle has no area", "give the lower left corner first");
  }
  if (!(options.margin_mm >= 0.0) || size.minCoeff() < 2 * options.margin_mm) {
    return refuse(
        fmt::format("a margin of {} mm leaves nothing of the rectangle", options.margin_mm),
        "use a margin from 0 to half the shorter side");
  }
  if (options.box) {
    return refuse("a box is for robots that work in space", "give a rectangle");
  }
  return std::nullopt;
}

std::optional<PlanRefusal> modes_refused(
    const geometry::Rig& rig, const std::vector<geometry::WorkingMode>& modes) {
  for (auto mode = modes.begin(); mode != modes.end(); ++mode) {
    const std::string_view name = rig.robot.model->mode_name(*mode);
    if (name.empty()) {
      return refuse(
          fmt::format("this robot has no working mode {}", to_string(*mode)),
          "leave the working mode out");
    }
    if (std::find(modes.begin(), mode, *mode) == mode) continue;
    return refuse(fmt::format("working mode {} is named twice", name), "name it once");
  }
  return std::nullopt;
}

std::optional<PlanRefusal> request_refused(
    const geometry::Rig& rig, std::int64_t points, const PlanOptions& options) {
  constexpr std::int64_t kMostPoints = 1'000'000;
  if (options.set.empty()) return refuse("the set has no name", "use G1, G2 or a name");
  if (points < 1 || points > kMostPoints) {
    return refuse(fmt::format("{} points make no plan", points), "ask for 1 to 1000000 points");
  }
  if (!works_in_space(rig)) {
    if (auto refusal = rectangle_refused(options)) return refusal;
  } else if (options.box) {
    const Eigen::Vector3d size = options.box->max_mm - options.box->min_mm;
    if (!size.allFinite() || size.minCoeff() < 0.0) {
      return refuse("the box has no inside", "give its lowest corner first");
    }
  }
  if (!(options.robot_error_mm >= 0.0) || !std::isfinite(options.robot_error_mm)) {
    return refuse("the robot error is negative", "give it in mm, 0 or more");
  }
  if (options.repeats < 1 || options.every < 1 || options.first_point < 0 ||
      options.repeats * points > kMostPoints) {
    return refuse(
        "repeats, every or first point make no sense", "use 1 or more, and 0 or more");
  }
  if (auto refusal = modes_refused(rig, options.working_modes)) return refusal;
  if (!rig.robot.nominal.allFinite()) return refuse("the rig has no robot", "load a rig file");
  return std::nullopt;
}

std::vector<geometry::WorkingMode> modes_of(
    const geometry::Rig& rig, const PlanOptions& options) {
  if (options.working_modes.empty()) return {rig.robot.working_mode};
  return options.working_modes;
}

PlanRefusal refused_in(
    PlanRefusal refusal, const geometry::Rig& rig, geometry::WorkingMode mode,
    std::size_t points, const PlanOptions& options) {
  refusal.point = options.first_point + static_cast<int>(points);
  if (options.working_modes.size() > 1) {
    refusal.reason =
        fmt::format("in working mode {}: {}", rig.robot.model->mode_name(mode), refusal.reason);
    refusal.advice += ", or leave this mode out";
  }
  return refusal;
}

/// A target in the plane, in the coordinates in which the rig measures.
Position in_plane(const geometry::Rig& rig, const Vector2d& target) {
  Position place = Position::Zero(rig.instrument.dimensions);
  place.head<2>() = rounded(target, kTargetDigits);
  return place;
}

/// Where the joints turn from: the reference pose, else the rectangle's middle.
tl::expected<Eigen::VectorXd, PlanRefusal> home_of(
    const geometry::Rig& rig, geometry::WorkingMode mode, const Rectangle& area) {
  const Vector2d middle = (area.min_mm + area.max_mm) / 2;
  for (const Vector2d& place : {rig.cuboid.reference_pose_mm, middle}) {
    if (const auto q = geometry::Tool(rig).inverse(rig.robot.nominal, place, mode)) return *q;
  }
  return tl::unexpected(refusal_of(
      middle,
      fmt::format(
          "in working mode {} the robot reaches neither the reference pose nor the rectangle's "
          "middle",
          rig.robot.model->mode_name(mode)),
      "check the working mode and the rectangle"));
}

/// Fisher-Yates, of those from `first` on.
void shuffle(std::vector<PlanPose>& poses, std::size_t first, Uniform& random) {
  for (std::size_t i = poses.size() - 1; i > first; --i) {
    const auto j =
        first + static_cast<std::size_t>(random.next() * static_cast<double>(i - first + 1));
    std::swap(poses[i], poses[j]);
  }
}

/// Back and forth over the rectangle; refused with how many poses there were before.
tl::expected<void, PlanRefusal> add_grid(
    const geometry::Rig& rig, geometry::WorkingMode mode, int nx, int ny,
    const PlanOptions& options, std::vector<PlanPose>& poses) {
  const auto home = home_of(rig, mode, options.rectangle);
  if (!home) return tl::unexpected(home.error());
  const Vector2d margin(options.margin_mm, options.margin_mm);
  const Vector2d low = options.rectangle.min_mm + margin;
  const Vector2d size = options.rectangle.max_mm - margin - low;
  const auto part = [](int i, int n) {
    return n == 1 ? 0.5 : static_cast<double>(i) / static_cast<double>(n - 1);
  };
  for (int iy = 0; iy < ny; ++iy) {
    for (int step = 0; step < nx; ++step) {
      geometry::check_end();
      const int ix = iy % 2 == 0 ? step : nx - 1 - step;
      const Position target =
          in_plane(rig, low + Vector2d(size.x() * part(ix, nx), size.y() * part(iy, ny)));
      auto q = measurable(rig, target, mode, options.robot_error_mm, *home);
      if (!q) {
        return tl::unexpected(
            refused_in(std::move(q.error()), rig, mode, poses.size(), options));
      }
      poses.push_back({target, *q});
    }
  }
  return {};
}

tl::expected<void, PlanRefusal> add_random(
    const geometry::Rig& rig, geometry::WorkingMode mode, int count, const PlanOptions& options,
    Uniform& random, std::vector<PlanPose>& poses) {
  const auto home = home_of(rig, mode, options.rectangle);
  if (!home) return tl::unexpected(home.error());
  const Vector2d margin(options.margin_mm, options.margin_mm);
  const Vector2d low = options.rectangle.min_mm + margin;
  const Vector2d size = options.rectangle.max_mm - margin - low;
  const std::int64_t most_draws = std::int64_t{kMostDrawsPerPoint} * count;
  const std::size_t first = poses.size();
  const std::size_t all = first + static_cast<std::size_t>(count);
  for (std::int64_t draw = 0; poses.size() < all; ++draw) {
    geometry::check_end();
    const double x = random.next();
    const double y = random.next();
    const Position target = in_plane(rig, low + Vector2d(size.x() * x, size.y() * y));
    auto q = measurable(rig, target, mode, options.robot_error_mm, *home);
    if (q) {
      poses.push_back({target, *q});
    } else if (draw + 1 >= most_draws) {
      q.error().reason = fmt::format(
          "only {} of {} random points can be measured; the last one: {}", poses.size() - first,
          draw + 1, q.error().reason);
      return tl::unexpected(refused_in(std::move(q.error()), rig, mode, poses.size(), options));
    }
  }
  return {};
}

tl::expected<void, PlanRefusal> add_random_in_space(
    const geometry::Rig& rig, geometry::WorkingMode mode, int count, const PlanOptions& options,
    Uniform& random, std::vector<PlanPose>& poses) {
  auto drawn = drawn_in_space(rig, mode, options.box, count, random);
  if (!drawn) return tl::unexpected(drawn.error());
  const std::size_t found = drawn->poses.size();
  poses.insert(poses.end(), drawn->poses.begin(), drawn->poses.end());
  if (found == static_cast<std::size_t>(count)) return {};
  return tl::unexpected(refused_in(
      refusal_of(
          drawn->last_mm,
          fmt::format(
              "only {} of {} random points can be measured; the last one: {}", found,
              drawn->draws, drawn->why),
          "choose another box, or narrower ranges of the joints"),
      rig, mode, poses.size(), options));
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
    std::string at;
    for (const double each_mm : refusal.target_mm) {
      at += fmt::format("{}{:.3f}", at.empty() ? "" : ", ", each_mm);
    }
    text = fmt::format("point {} at ({}) mm: ", refusal.point, at);
  }
  return text + refusal.reason + "; " + refusal.advice;
}

bool works_in_space(const geometry::Rig& rig) { return rig.robot.model->axes == 3; }

tl::expected<Plan, PlanRefusal> plan_grid(
    const geometry::Rig& rig, int nx, int ny, const PlanOptions& options) {
  const bool in_space = works_in_space(rig);
  const bool none = nx < 1 || ny < 1 || options.nz < 1;
  const std::int64_t count =
      none ? 0 : std::int64_t{nx} * ny * (in_space ? options.nz : std::int64_t{1});
  if (auto refusal = request_refused(rig, count, options)) {
    return tl::unexpected(std::move(*refusal));
  }
  if (in_space && !options.box) {
    return tl::unexpected(refuse(
        "a grid of a robot that works in space needs a box",
        "sixdial plan grid ... --box x0 y0 z0 x1 y1 z1; plan random needs none for an arm"));
  }
  Uniform random(options.seed, options.set);
  std::vector<PlanPose> poses;
  for (const geometry::WorkingMode mode : modes_of(rig, options)) {
    const std::size_t first = poses.size();
    const auto added = in_space ? add_grid_in_space(rig, mode, nx, ny, options, poses)
                                : add_grid(rig, mode, nx, ny, options, poses);
    if (!added && in_space) {
      return tl::unexpected(refused_in(added.error(), rig, mode, poses.size(), options));
    }
    if (!added) return tl::unexpected(added.error());
    if (options.shuffle) shuffle(poses, first, random);
  }
  return numbered(poses, options);
}

tl::expected<Plan, PlanRefusal> plan_random(
    const geometry::Rig& rig, int count, const PlanOptions& options) {
  if (auto refusal = request_refused(rig, count, options)) {
    return tl::unexpected(std::move(*refusal));
  }
  Uniform random(options.seed, options.set);
  std::vector<PlanPose> poses;
  const auto add = works_in_space(rig) ? add_random_in_space : add_random;
  for (const geometry::WorkingMode mode : modes_of(rig, options)) {
    if (const auto added = add(rig, mode, count, options, random, poses); !added) {
      return tl::unexpected(added.error());
    }
  }
  return numbered(poses, options);
}

}  // namespace sixdial::session
