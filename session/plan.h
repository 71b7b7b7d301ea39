// What to measure: the planned points of a session, as a CSV file people can edit.
// Columns: set,point,repeat,target_x_mm,target_y_mm,theta1_rad,theta2_rad,approach1,approach2,
// mode; of another robot its own joints and coordinates (session/sample_layout.h), and where
// the rig has sockets the one that the ball is put into, `socket`; where it measures turns
// target_rx_deg,target_ry_deg,target_rz_deg, as rig.toml's `orientation` reads them. A point's
// working mode is that of its angles; `mode` says it, and is used where the angles are left
// out.
#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <tl/expected.hpp>
#include <vector>

#include "geometry/rig.h"
#include "session/data_error.h"
#include "session/sample_layout.h"

namespace sixdial::session {

struct PlanPoint {
  std::string set;
  int point = 0;
  int repeat = 0;
  Position target_mm;  // in W
  Eigen::VectorXd q;   // joint values to command [rad, mm], by nominal parameters
  /// Sign of each joint's last move; 0, or left out at the end: as it comes.
  std::vector<int> approach;
  std::string socket{};  // that the ball on the tool is put into; empty: none
  /// How the tool is to be turned: three angles [rad] by rig.toml's `orientation`; empty: as
  /// the joint values turn it.
  std::optional<Eigen::Vector3d> target_turn_rad{};
  friend bool operator==(const PlanPoint& a, const PlanPoint& b);
};
/// Of joint `joint`; 0: as it comes.
[[nodiscard]] int approach_of(const PlanPoint& point, std::size_t joint);

struct Plan {
  std::vector<PlanPoint> points;
  friend bool operator==(const Plan&, const Plan&) = default;
};

/// Of targets of a robot that works in the plane [mm, W].
struct Rectangle {
  Eigen::Vector2d min_mm{16, 30};
  Eigen::Vector2d max_mm{40, 66};
};

/// Of targets of a robot that works in space [mm, W].
struct TargetBox {
  Eigen::Vector3d min_mm{0, 0, 0};
  Eigen::Vector3d max_mm{0, 0, 0};
};

enum class ApproachRule {
  kAsItComes,  // approach 0, 0
  kAlternate,  // one side for each point: ++, --, +-, -+ in turn
  kBothSides,  // every `every`-th point twice, from ++ and from --; the others as with
               // kAlternate
};
/// "as-it-comes", "alternate", "both-sides".
[[nodiscard]] std::string_view to_string(ApproachRule rule);
[[nodiscard]] std::optional<ApproachRule> approach_rule_from(std::string_view text);

struct PlanOptions {
  std::string set = "G1";
  int first_point = 0;    // points are numbered from here in the order of measurement
  Rectangle rectangle{};  // of a robot in the plane
  /// Of a robot in space. Empty: plan_random draws joint values in the ranges of rig.toml's
  /// [[joint]] rows; plan_grid needs a box, and so do robots without such rows.
  std::optional<TargetBox> box{};
  int nz = 1;  // layers of a grid in a box, from its lowest to its highest; 1: halfway
  /// Margin kept free inside the rectangle's edge. Near the left edge of the default rectangle,
  /// no three dials give a position for a robot that is 4 mm off.
  double margin_mm = 1.0;
  /// Contacts must hold for a tool that is off by this much in any direction.
  double robot_error_mm = 4.0;
  int repeats = 1;
  ApproachRule approach = ApproachRule::kAsItComes;
  int every = 1;  // of kBothSides
  /// Working modes, measured one after the other; each gets the whole grid or the whole count.
  /// Between two modes an operator has to bring the legs over. Empty: the rig's.
  std::vector<geometry::WorkingMode> working_modes{};
  bool shuffle = true;  // a grid's order; false: serpentine
  std::uint64_t seed = 1;
};

/// A point that cannot be planned.
struct PlanRefusal {
  int point = -1;  // -1: the request as a whole
  Position target_mm = Eigen::Vector2d(0, 0);
  std::string reason;
  std::string advice;
};
/// "point 7 at (40.000, 66.000) mm: ...; ...".
[[nodiscard]] std::string describe(const PlanRefusal& refusal);

/// nx x ny points in each working mode over the rectangle less its margin, the edges of that
/// included; of a robot in space over the box, with the tool turned as in its middle. Refused
/// as a whole if one cannot be measured.
[[nodiscard]] tl::expected<Plan, PlanRefusal> plan_grid(
    const geometry::Rig& rig, int nx, int ny, const PlanOptions& options = {});

/// `count` random points in each working mode: targets, uniform over the rectangle less its
/// margin or over the box; of a robot in space without a box joint values, uniform over their
/// ranges. One that cannot be measured is drawn again, up to kMostDrawsPerPoint draws a point
/// on average. The same seed and set give the same plan.
[[nodiscard]] tl::expected<Plan, PlanRefusal> plan_random(
    const geometry::Rig& rig, int count, const PlanOptions& options = {});
inline constexpr int kMostDrawsPerPoint = 100;

/// Joint values for a target that the robot can reach, away from singular poses, and the dials
/// can measure, near `near`; else why not. An instrument's rig, without dials, needs no
/// contacts.
[[nodiscard]] tl::expected<Eigen::VectorXd, PlanRefusal> measurable(
    const geometry::Rig& rig, const Position& target_mm, geometry::WorkingMode mode,
    double robot_error_mm, const Eigen::VectorXd& near);

/// How the legs stand at a planned point, by the nominal robot. Between points whose branches
/// differ lies a singular pose, which no controller drives through by itself.
struct Branch {
  geometry::WorkingMode mode;
  geometry::Assembly assembly = geometry::Assembly::kLeft;
  friend bool operator==(const Branch&, const Branch&) = default;
};
/// The rig's where the angles have no pose at the target.
[[nodiscard]] Branch branch_of(const geometry::Rig& rig, const PlanPoint& point);

/// Points that follow each other in one branch.
struct Stretch {
  Branch branch;
  std::size_t first = 0;  // index into Plan::points
  std::size_t points = 0;
};
[[nodiscard]] std::vector<Stretch> stretches_of(const geometry::Rig& rig, const Plan& plan);

/// What an operator has to know of a plan, a sentence a line: where the legs change over,
/// joints of which rig.toml gives no range.
[[nodiscard]] std::vector<std::string> operator_notes(
    const geometry::Rig& rig, const Plan& plan);

/// Reads a plan file; set, point and repeat together stand in one row only. Columns may stand
/// in any order; repeat, the angles, the approaches and the mode may be absent or empty: repeat
/// 0, angles by nominal inverse kinematics in the point's mode, else the rig's, approach 0.
/// Throws DataError with file, line and column, also for angles out of reach or of another mode
/// than the row says.
[[nodiscard]] Plan parse_plan(
    std::string_view text, const std::string& file_name, const geometry::Rig& rig);
[[nodiscard]] Plan read_plan(const std::string& path, const geometry::Rig& rig);

/// The plan as CSV; parse_plan gives back an equal plan if its numbers have at most 9 decimals,
/// as those of plan_grid and plan_random. With a rig: says the working mode of each point too.
[[nodiscard]] std::string plan_csv(const Plan& plan, const SampleLayout& layout);
[[nodiscard]] std::string plan_csv(const Plan& plan, const geometry::Rig& rig);

}  // namespace sixdial::session
