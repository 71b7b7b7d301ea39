// How many points chosen by `plan next` do what a grid does, what pooling working modes is
// worth, and where a collection ends that stops by itself: the tables of doc/online.md. First
// by positions with noise and the robot of Table 2, then with drawn robots whose sessions the
// mock rig's dials give. Errors "made" are those of the estimate against the true robot, over
// the workspace.
#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <string>
#include <vector>

#include "calibration/design.h"
#include "calibration/five_bar/spaces.h"
#include "calibration/online.h"
#include "calibration/random.h"
#include "calibration/space_fit.h"
#include "mock_devices/session_generator.h"
#include "session/bundle.h"
#include "session/plan.h"
#include "studies/live_estimate.h"
#include "studies/next_plan.h"

namespace {

using namespace sixdial;
using calibration::DesignCandidate;
using calibration::WorkspacePose;
using geometry::ParameterMatrix;
using geometry::WorkingMode;

constexpr double kNoise_mm = 0.003;
constexpr std::uint64_t kRepeats = 200;
const geometry::Rig kRig = geometry::default_rig();
const geometry::Tool kTool(kRig);
const Eigen::Vector2d kLow(17, 31);
const Eigen::Vector2d kHigh(39, 65);
const Eigen::Matrix2d kR = kNoise_mm * kNoise_mm * Eigen::Matrix2d::Identity();

/// What the dials can measure with a robot that is 4 mm off.
std::vector<DesignCandidate> candidates(int nx, int ny, std::span<const WorkingMode> modes) {
  std::vector<DesignCandidate> result;
  for (const WorkspacePose& pose :
       calibration::workspace_grid(kTool, kRig.robot.nominal, kLow, kHigh, nx, ny, modes)) {
    if (session::measurable(kRig, pose.target_mm, pose.mode, 4.0, pose.q)) {
      result.push_back({pose, kR});
    }
  }
  return result;
}

void add(ParameterMatrix& M, const DesignCandidate& candidate) {
  const auto d = geometry::forward_derivative(
      kRig.robot.nominal, candidate.pose.q, candidate.pose.assembly);
  if (d) M += d->J_v.transpose() * candidate.covariance_mm2.inverse() * d->J_v;
}

double condition(const std::vector<DesignCandidate>& set) {
  calibration::PositionObservations observations;
  const auto n = static_cast<Eigen::Index>(set.size());
  observations.q_rad.resize(2, n);
  observations.p_WE.resize(2, n);
  for (Eigen::Index i = 0; i < n; ++i) {
    const WorkspacePose& pose = set[static_cast<std::size_t>(i)].pose;
    observations.q_rad.col(i) = pose.q;
    observations.p_WE.col(i) = pose.target_mm;
    observations.assembly.push_back(pose.assembly);
    observations.covariance_mm2.push_back(kR);
  }
  observations.target_mm.resize(set.size());
  const auto space = calibration::position_space(observations, kRig.robot.nominal);
  return calibration::assess_space(space, space.nominal).fit.condition();
}

double error_made(
    const std::vector<DesignCandidate>& set, const std::vector<WorkspacePose>& where) {
  const geometry::ParameterVector robot = geometry::table_2_robot();
  double sum = 0.0;
  for (std::uint64_t seed = 1; seed <= kRepeats; ++seed) {
    calibration::RandomSequence random(seed, 55);
    calibration::OnlineEstimator online(kTool, kRig.robot.nominal);
    for (std::size_t i = 0; i < set.size(); ++i) {
      const WorkspacePose& pose = set[i].pose;
      simulation::Trial trial;
      trial.point = static_cast<int>(i);
      trial.q = pose.q;
      trial.assembly = pose.assembly;
      trial.position_covariance = kR;
      trial.position_mm = geometry::forward(robot, pose.q, pose.assembly)->p_WE +
                          kNoise_mm * Eigen::Vector2d(random.normal(), random.normal());
      online.add(trial);
    }
    for (const WorkspacePose& pose : where) {
      sum += (geometry::forward(online.v(), pose.q, pose.assembly)->p_WE -
              geometry::forward(robot, pose.q, pose.assembly)->p_WE)
                 .norm();
    }
  }
  return sum / static_cast<double>(kRepeats * where.size());
}

void row(
    const std::string& name, const std::vector<DesignCandidate>& set,
    const std::vector<WorkspacePose>& where) {
  ParameterMatrix M = calibration::OnlineEstimator(kTool, kRig.robot.nominal).information();
  for (const DesignCandidate& each : set) add(M, each);
  const auto u =
      calibration::workspace_uncertainty(kTool, kRig.robot.nominal, M.inverse(), where);
  std::printf(
      "| %s | %zu | %.2f | %.2f | %.2f | %.0f |\n", name.c_str(), set.size(), 1000 * u.mean_mm,
      1000 * u.max_mm, 1000 * error_made(set, where), condition(set));
}

std::vector<DesignCandidate> chosen(
    const std::vector<DesignCandidate>& from, const std::vector<WorkspacePose>& where,
    calibration::Criterion criterion, int most_each, double limit_mm) {
  std::vector<DesignCandidate> set;
  for (const auto& step : calibration::greedy_design(
           kTool, kRig.robot.nominal,
           calibration::OnlineEstimator(kTool, kRig.robot.nominal).information(), from, where,
           200, criterion, most_each)) {
    set.push_back(from[step.candidate]);
    if (step.uncertainty.mean_mm <= limit_mm) break;
  }
  return set;
}

void study(
    const char* title, std::span<const WorkingMode> used,
    std::span<const WorkingMode> measured) {
  const auto where =
      calibration::workspace_grid(kTool, kRig.robot.nominal, kLow, kHigh, 7, 7, used);
  const auto grid = candidates(10, 10, used);
  ParameterMatrix M = calibration::OnlineEstimator(kTool, kRig.robot.nominal).information();
  for (const DesignCandidate& each : grid) add(M, each);
  const double limit_mm =
      calibration::workspace_uncertainty(kTool, kRig.robot.nominal, M.inverse(), where).mean_mm;
  std::printf(
      "\n%s\n\n| poses | points | predicted mean, um | predicted max, um | made, um | "
      "condition "
      "|\n|---|---|---|---|---|---|\n",
      title);
  row("grid", grid, where);
  const auto from = candidates(25, 25, measured);
  using calibration::Criterion;
  row("I-optimal, each pose once", chosen(from, where, Criterion::kI, 1, limit_mm), where);
  row("I-optimal, up to 5 repeats", chosen(from, where, Criterion::kI, 5, limit_mm), where);
  row("D-optimal, each pose once", chosen(from, where, Criterion::kD, 1, limit_mm), where);
}

// ---- Point by point, as a collection goes: sessions by the dials of the mock rig.

constexpr std::uint64_t kRobots = 20;
constexpr int kFirstPoints = 6;
constexpr int kBatch = 5;
constexpr std::size_t kMostPoints = 150;

mock_devices::World world_of(std::uint64_t seed) {
  mock_devices::World world;
  world.seed = seed;
  world.robot = mock_devices::drawn_robot(world.rig, seed);
  world.dials.curve_mm = 0.0;
  world.dials.hysteresis_mm = 0.0;
  return world;
}

session::Session measured(const mock_devices::World& world, const session::Plan& plan) {
  std::vector<mock_devices::PlannedPose> poses;
  for (const session::PlanPoint& point : plan.points) {
    mock_devices::PlannedPose pose;
    pose.point = point.point;
    pose.time_s = 8.0 * static_cast<double>(poses.size());
    pose.q_rad = point.q;
    pose.target_mm = point.target_mm;
    pose.assembly = session::branch_of(world.rig, point).assembly;
    poses.push_back(pose);
  }
  return session::parse_session(
      mock_devices::session_csv(
          mock_devices::generate_session(world, poses), world.rig, "2026-03-02T08:30:00.000Z"),
      "session.csv", mock_devices::rig_toml(world.rig), "rig.toml");
}

struct Spread {
  double sum = 0.0, least = 1e300, most = 0.0;
  int count = 0;
  void add(double value) {
    sum += value;
    least = std::min(least, value);
    most = std::max(most, value);
    ++count;
  }
  [[nodiscard]] double mean() const { return sum / count; }
};

struct Made {
  double mean_mm = 0.0, at_worst_mm = 0.0;  // the latter where the estimate says it is worst
};
Made made_by(const studies::LiveEstimate& estimate, const mock_devices::World& world) {
  Made made;
  const auto& where = estimate.workspace();
  for (std::size_t i = 0; i < where.size(); ++i) {
    const auto& pose = where[i];
    const double error =
        (geometry::forward(estimate.filter().v(), pose.q, pose.assembly)->p_WE -
         geometry::forward(world.robot.parameters, pose.q, pose.assembly)->p_WE)
            .norm();
    made.mean_mm += error / static_cast<double>(where.size());
    if (i == estimate.uncertainty().worst) made.at_worst_mm = error;
  }
  return made;
}

studies::LiveEstimate estimate_of(
    const session::Session& session, const std::vector<session::PlanPoint>& workspace) {
  studies::LiveEstimate estimate(session.rig, workspace);
  for (const session::Sample& sample : session.samples) estimate.add(sample);
  return estimate;
}

/// Points until the worst place is as well known as by the grid, and the errors then made.
void chosen_point_by_point(const std::vector<WorkingMode>& modes, const char* name) {
  const session::Plan grid = session::plan_grid(kRig, 10, 10).value();
  Spread points;
  Spread made;
  Spread grid_made;
  for (std::uint64_t seed = 1; seed <= kRobots; ++seed) {
    const mock_devices::World world = world_of(seed);
    const auto by_grid = estimate_of(measured(world, grid), grid.points);
    grid_made.add(1000 * made_by(by_grid, world).mean_mm);
    session::Plan plan = session::plan_random(kRig, kFirstPoints, {.seed = seed}).value();
    for (;;) {
      const session::Session so_far = measured(world, plan);
      const auto estimate = estimate_of(so_far, grid.points);
      if (estimate.uncertainty().max_mm <= by_grid.uncertainty().max_mm ||
          plan.points.size() >= kMostPoints) {
        points.add(static_cast<double>(plan.points.size()));
        made.add(1000 * made_by(estimate, world).mean_mm);
        break;
      }
      const studies::NextPlan next = studies::next_plan(
          so_far,
          {.points = kBatch, .modes = modes, .rectangle = session::Rectangle{kLow, kHigh}});
      plan.points.insert(plan.points.end(), next.plan.points.begin(), next.plan.points.end());
    }
  }
  std::printf(
      "| %s | %.1f (%.0f to %.0f) | %.2f | 100 | %.2f |\n", name, points.mean(), points.least,
      points.most, made.mean(), grid_made.mean());
}

/// collect --stop-below: random points until the limit.
void stopped_below(double limit_mm) {
  Spread points;
  Spread squares;
  for (std::uint64_t seed = 1; seed <= kRobots; ++seed) {
    const mock_devices::World world = world_of(seed);
    const session::Plan plan = session::plan_random(kRig, 300, {.seed = seed}).value();
    const session::Session session = measured(world, plan);
    studies::LiveEstimate estimate(session.rig, plan.points);
    std::size_t taken = 0;
    while (taken < session.samples.size() && !estimate.below(limit_mm)) {
      estimate.add(session.samples[taken++]);
    }
    points.add(static_cast<double>(taken));
    const double ratio = made_by(estimate, world).at_worst_mm / limit_mm;
    squares.add(ratio * ratio);
  }
  std::printf(
      "| %.3f | %.1f (%.0f to %.0f) | %.2f |\n", limit_mm, points.mean(), points.least,
      points.most, std::sqrt(squares.mean()));
}

}  // namespace

int main() {
  const std::vector<WorkingMode> one{{+1, +1}};
  const std::vector<WorkingMode> two{{+1, +1}, {-1, +1}};
  const std::vector<WorkingMode> four(
      geometry::kWorkingModes.begin(), geometry::kWorkingModes.end());
  study("Used and measured in mode ++:", one, one);
  study("Used in mode ++, measured in ++ and -+:", one, two);
  study("Used in mode ++, measured in all four modes:", one, four);
  std::printf("\n| grid in modes | points | condition |\n|---|---|---|\n");
  std::printf(
      "| ++ | %zu | %.0f |\n", candidates(10, 10, one).size(),
      condition(candidates(10, 10, one)));
  std::printf(
      "| ++, -+ | %zu | %.0f |\n", candidates(7, 7, two).size(),
      condition(candidates(7, 7, two)));
  std::printf(
      "| all four | %zu | %.0f |\n", candidates(6, 6, four).size(),
      condition(candidates(6, 6, four)));
  std::printf(
      "\n| plan next in modes | points | made, um | grid | made by the grid, um "
      "|\n|---|---|---|---|---|\n");
  chosen_point_by_point(one, "++");
  chosen_point_by_point(two, "++, -+");
  std::printf(
      "\n| --stop-below, mm | points of 300 | made at the worst place over the limit, rms "
      "|\n|---|---|---|\n");
  for (const double limit_mm : {0.02, 0.01, 0.005, 0.003}) stopped_below(limit_mm);
  return 0;
}
