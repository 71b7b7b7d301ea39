#include "session/plan_in_space.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "geometry/long_work.h"
#include "geometry/tool.h"
#include "geometry/units.h"

namespace sixdial::session {
namespace {

using Eigen::Index;
using Eigen::Vector3d;
using Eigen::VectorXd;

/// [[joint]] rows as rig.toml has them.
std::vector<geometry::FileValue::Table> joint_rows(const geometry::Rig& rig) {
  const geometry::RobotModel& robot = *rig.robot.model;
  if (robot.kind->to_file == nullptr) return {};
  return robot.kind->to_file(robot, rig.robot.nominal).joints;
}

/// A pose or why it is none.
struct Tried {
  std::optional<PlanPose> pose;
  Position target_mm;
  std::string why;
};

/// The nominal robot, its tool always with three coordinates.
class Planner {
 public:
  Planner(const geometry::Rig& rig, geometry::WorkingMode mode)
      : rig_(rig),
        mode_(mode),
        tool_(rig.robot.model, 3),
        axes_(rig.instrument.dimensions),
        listed_(lists_its_joints(rig)) {}

  /// Uniform over the ranges of the joints.
  VectorXd drawn_joints(Uniform& random) const {
    VectorXd q(tool_.robot().joint_count());
    for (Index k = 0; k < q.size(); ++k) {
      const geometry::JointInfo& joint = info(k);
      q[k] = joint.low + random.next() * (joint.high - joint.low);
    }
    return q;
  }

  Tried of_joints(const VectorXd& exact) const {
    const VectorXd q = rounded(exact, kJointDigits);
    Tried tried{.pose = {}, .target_mm = Position::Zero(axes_), .why = {}};
    const geometry::Robot& robot = rig_.robot;
    const auto at = tool_.position(robot.nominal, q, robot.assembly);
    if (!at) {
      tried.why = describe(at.error());
      return tried;
    }
    tried.target_mm = rounded(Position(at->head(axes_)), kTargetDigits);
    tried.why = beyond_range(q);
    if (tried.why.empty()) tried.why = singular_there(rig_, q, robot.assembly);
    const auto mode = tool_.mode_of(robot.nominal, q, robot.assembly);
    if (tried.why.empty() && (!mode || *mode != mode_)) {
      tried.why = "it is in another working mode there";
    }
    if (tried.why.empty()) tried.pose = {tried.target_mm, q};
    return tried;
  }

  /// With the tool turned as it comes from these joint values; empty: as it comes.
  Tried as_it_comes(const Vector3d& target, const VectorXd& from) const {
    const geometry::RobotModel& robot = tool_.robot();
    geometry::Pose<double> X_WE{.p = target};
    X_WE.R.setConstant(std::numeric_limits<double>::quiet_NaN());
    const auto span = [](const VectorXd& values) {
      return std::span<const double>(values.data(), static_cast<std::size_t>(values.size()));
    };
    if (robot.kind->inverse == nullptr) return refused(target, "it has no inverse");
    const auto q =
        robot.kind->inverse(robot, span(rig_.robot.nominal), X_WE, mode_, span(from));
    if (!q) return refused(target, std::string(describe(q.error())));
    return of_joints(*q);
  }

  /// With the tool turned as at `near`.
  Tried turned_as(const Vector3d& target, const VectorXd& near) const {
    const auto q = tool_.inverse(rig_.robot.nominal, target, mode_, near);
    if (!q) return refused(target, std::string(describe(q.error())));
    return of_joints(*q);
  }

  /// With the tool there, of several ways to stand the one whose joints are farthest from the
  /// ends of their ranges.
  Tried with_most_room(const Vector3d& target) const {
    constexpr int kWays = 30;
    Tried best = as_it_comes(target, VectorXd());
    double most = best.pose ? room(best.pose->q) : -1.0;
    Uniform random(1, "ways to stand");
    for (int way = 0; way < kWays && listed_; ++way) {
      Tried tried = as_it_comes(target, drawn_joints(random));
      const double here = tried.pose ? room(tried.pose->q) : -1.0;
      if (here <= most) continue;
      most = here;
      best = std::move(tried);
    }
    return best;
  }

  [[nodiscard]] bool listed() const { return listed_; }

 private:
  [[nodiscard]] const geometry::JointInfo& info(Index k) const {
    return tool_.robot().joints[static_cast<std::size_t>(k)];
  }

  [[nodiscard]] Tried refused(const Vector3d& target, std::string why) const {
    return {.pose = {}, .target_mm = target.head(axes_), .why = std::move(why)};
  }

  /// The least share of its range that a joint has to the nearer end.
  [[nodiscard]] double room(const VectorXd& q) const {
    double least = 0.5;
    for (Index k = 0; k < q.size() && listed_; ++k) {
      const double end = std::min(q[k] - info(k).low, info(k).high - q[k]);
      least = std::min(least, end / (info(k).high - info(k).low));
    }
    return least;
  }

  [[nodiscard]] std::string beyond_range(const VectorXd& q) const {
    if (!listed_) return "";
    for (Index k = 0; k < q.size(); ++k) {
      const geometry::JointInfo& joint = info(k);
      if (q[k] >= joint.low && q[k] <= joint.high) continue;
      const bool turns = joint.kind == geometry::JointKind::kRevolute;
      const double unit = turns ? geometry::kDegPerRad : 1.0;
      return fmt::format(
          "joint {} would be at {:.1f} {}, beyond its range of {:.1f} to {:.1f}", joint.name,
          q[k] * unit, turns ? "deg" : "mm", joint.low * unit, joint.high * unit);
    }
    return "";
  }

  const geometry::Rig& rig_;
  geometry::WorkingMode mode_;
  geometry::Tool tool_;
  int axes_;
  bool listed_;
};

}  // namespace

bool lists_its_joints(const geometry::Rig& rig) { return !joint_rows(rig).empty(); }

bool lacks_ranges(const geometry::Rig& rig) {
  for (const geometry::FileValue::Table& row : joint_rows(rig)) {
    bool low = false;
    bool high = false;
    for (const auto& [key, value] : row) {
      low = low || key.starts_with("low_");
      high = high || key.starts_with("high_");
    }
    if (!row.contains("follows") && !(low && high)) return true;
  }
  return false;
}

tl::expected<DrawnPoses, PlanRefusal> drawn_in_space(
    const geometry::Rig& rig, geometry::WorkingMode mode, const std::optional<TargetBox>& box,
    int count, Uniform& random) {
  const Planner planner(rig, mode);
  if (!box && !planner.listed()) {
    return tl::unexpected(refusal_of(
        Position::Zero(rig.instrument.dimensions),
        fmt::format(
            "rig.toml does not say which joint values this {} takes",
            rig.robot.model->kind->in_words),
        "say in which box to measure: sixdial plan random ... --box x0 y0 z0 x1 y1 z1"));
  }
  DrawnPoses drawn;
  const std::int64_t most_draws = std::int64_t{kMostDrawsPerPoint} * count;
  while (std::ssize(drawn.poses) < count && drawn.draws < most_draws) {
    geometry::check_end();
    ++drawn.draws;
    const VectorXd q = planner.listed() ? planner.drawn_joints(random) : VectorXd();
    Tried tried;
    if (box) {
      Vector3d target;
      for (Index k = 0; k < 3; ++k) {
        target[k] = box->min_mm[k] + random.next() * (box->max_mm[k] - box->min_mm[k]);
      }
      tried = planner.as_it_comes(target, q);
    } else {
      tried = planner.of_joints(q);
    }
    if (tried.pose) {
      drawn.poses.push_back(*std::move(tried.pose));
    } else {
      drawn.last_mm = tried.target_mm;
      drawn.why = std::move(tried.why);
    }
  }
  return drawn;
}

tl::expected<void, PlanRefusal> add_grid_in_space(
    const geometry::Rig& rig, geometry::WorkingMode mode, int nx, int ny,
    const PlanOptions& options, std::vector<PlanPose>& poses) {
  const auto refuse = [](const Tried& tried, const std::string& where) {
    return tl::unexpected(refusal_of(
        tried.target_mm, where + tried.why, "choose a smaller box, or plan random points"));
  };
  const Planner planner(rig, mode);
  const Vector3d low = options.box->min_mm;
  const Vector3d size = options.box->max_mm - low;
  const Tried middle = planner.with_most_room(low + size / 2);
  if (!middle.pose) return refuse(middle, "in the middle of the box: ");
  const auto part = [](int i, int n) {
    return n == 1 ? 0.5 : static_cast<double>(i) / static_cast<double>(n - 1);
  };
  int row = 0;
  for (int iz = 0; iz < options.nz; ++iz) {
    for (int iy = 0; iy < ny; ++iy, ++row) {
      for (int step = 0; step < nx; ++step) {
        geometry::check_end();
        const int ix = row % 2 == 0 ? step : nx - 1 - step;
        const Vector3d share(part(ix, nx), part(iy, ny), part(iz, options.nz));
        Tried tried = planner.turned_as(low + size.cwiseProduct(share), middle.pose->q);
        if (!tried.pose) return refuse(tried, "");
        poses.push_back(*std::move(tried.pose));
      }
    }
  }
  return {};
}

}  // namespace sixdial::session
