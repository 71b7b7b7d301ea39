// sixdial plan sockets: poses of an arm with a ball on its tool in two or more sockets, such
// that their joint values alone determine the robot; no instrument measures anything. Made
// before any session, from where the sockets roughly are, with what each length of the plan
// would tell.
//
// The ball is at the same, unknown, place whenever it sits in the same socket. Where the arm
// stands is not asked: its base frame is W, as the rig file has it. A length is told by a known
// distance of two sockets alone: without one the robot is found up to a common factor of all
// its lengths.
//
//   const SocketPlan made = socket_plan(arm, {.at_mm = {{350, -90, 40}, {350, 90, 40}}});
//   session::write_file("plan.csv", session::plan_csv(made.plan, made.rig));
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "calibration/design.h"
#include "geometry/units.h"
#include "session/plan.h"
#include "session/plan_at_sockets.h"
#include "studies/next_plan.h"

namespace sixdial::studies {

/// How well a ball comes back to where it sat, joint readings included, where nobody says it.
inline constexpr double kUsualSeat_mm = 0.1;

struct SocketPlanRequest {
  /// Where the ball's centre will be in each socket, to a few centimetres, in W. In the order
  /// of the rig file's [[socket]] rows, if it has any.
  std::vector<Eigen::Vector3d> at_mm{};
  int count = 20;    // poses of each socket that are to be fitted, G1
  int to_judge = 4;  // and as many more that are not: G2, drawn instead of chosen
  session::SeatRule seat{.cone_rad = 45.0 * geometry::kRadPerDeg};
  /// Known distance of the first and second socket, of the third and fourth, and so on; empty:
  /// what the rig file says.
  std::optional<double> distance_mm{};
  double distance_sd_mm = 0.05;
  /// Empty: that of a rig file whose instrument is a ball in sockets, else kUsualSeat_mm.
  std::optional<double> seat_sd_mm{};
  calibration::Criterion criterion = calibration::Criterion::kD;
  std::uint64_t seed = 1;
};

struct PlannedSocket {
  std::string name{};
  Eigen::Vector3d at_mm{0, 0, 0};
  int poses = 0;                                 // of G1
  double least_lean_rad = 0, most_lean_rad = 0;  // of the ball's stem, G1 and G2
};

/// A known distance, beside that of the places as they were given.
struct PlannedDistance {
  std::string first{}, second{};
  double mm = 0.0, sd_mm = 0.0;
  double places_mm = 0.0;
};

/// How well the poses of the plan would tell one of the robot's parameters. What they do not
/// tell counts as well as it is known before, of a robot of its kind.
struct PlannedParameter {
  std::string name{}, unit{};  // "mm" or "rad"
  double sd = 0.0;
  bool open = false;  // part of it they do not tell
};

/// How well the first `poses` poses of each socket would tell where the tool is, anywhere in
/// the joints' ranges, once the arm is registered where it works: what a motion of the whole
/// arm does is left out.
struct SocketStage {
  int poses = 0;
  PositionSd position{};
  std::optional<double> open_mm{};  // the mean's part that they do not tell; empty: none
  std::vector<std::string> open{};  // that: directions of the parameters, in words
};

struct SocketPlanFigures {
  int points = 0;  // of the plan
  std::vector<PlannedSocket> sockets{};
  std::vector<PlannedDistance> distances{};
  double seat_sd_mm = 0.0;
  bool seat_sd_assumed = false;  // neither asked for nor in the rig file
  double cone_rad = 0.0;
  calibration::Criterion criterion = calibration::Criterion::kD;
  /// A known distance of two sockets would tell what nothing else does: the lengths' common
  /// factor.
  bool scale_is_open = false;
  std::vector<SocketStage> stages{};           // half of the plan, the plan, twice as much
  std::vector<PlannedParameter> parameters{};  // by the plan; those that are fitted
};

struct SocketPlan {
  session::Plan plan;  // G1 and G2 socket by socket, each pose near the one before
  geometry::Rig rig;   // the arm with these sockets as its instrument
  SocketPlanFigures figures;
};

/// The same request gives the same plan. Throws StudyError: invalid_params for fewer than two
/// places, or places, distances or angles without sense; bad_data where the robot is no arm in
/// space with ranges of its joints, or a socket cannot be reached in enough ways.
[[nodiscard]] SocketPlan socket_plan(
    const geometry::Rig& arm, const SocketPlanRequest& request);

}  // namespace sixdial::studies
