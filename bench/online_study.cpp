// How many points chosen by `plan next` do what a grid does, and what pooling working modes is
// worth: the tables of doc/online.md. Simulated on the default rig with the robot of Table 2;
// errors "made" are those of fitted parameters against the true robot, over the workspace.
#include <Eigen/LU>
#include <cstdint>
#include <cstdio>
#include <string>
#include <vector>

#include "calibration/design.h"
#include "calibration/online.h"
#include "calibration/position_fit.h"
#include "calibration/random.h"
#include "session/plan.h"

namespace {

using namespace sixdial;
using calibration::DesignCandidate;
using calibration::WorkspacePose;
using geometry::ParameterMatrix;
using geometry::WorkingMode;

constexpr double kNoise_mm = 0.003;
constexpr std::uint64_t kRepeats = 200;
const geometry::Rig kRig = geometry::default_rig();
const Eigen::Vector2d kLow(17, 31);
const Eigen::Vector2d kHigh(39, 65);
const Eigen::Matrix2d kR = kNoise_mm * kNoise_mm * Eigen::Matrix2d::Identity();

/// What the dials can measure with a robot that is 4 mm off.
std::vector<DesignCandidate> candidates(int nx, int ny, std::span<const WorkingMode> modes) {
  std::vector<DesignCandidate> result;
  for (const WorkspacePose& pose :
       calibration::workspace_grid(kRig.robot.nominal, kLow, kHigh, nx, ny, modes)) {
    if (session::measurable(kRig, pose.target_mm, pose.mode, 4.0, pose.q_rad)) {
      result.push_back({pose, kR});
    }
  }
  return result;
}

void add(ParameterMatrix& M, const DesignCandidate& candidate) {
  const auto d = geometry::forward_derivative(
      kRig.robot.nominal, candidate.pose.q_rad, candidate.pose.assembly);
  if (d) M += d->J_v.transpose() * candidate.covariance_mm2.inverse() * d->J_v;
}

double condition(const std::vector<DesignCandidate>& set) {
  calibration::PositionObservations observations;
  const auto n = static_cast<Eigen::Index>(set.size());
  observations.q_rad.resize(2, n);
  observations.p_WE.resize(2, n);
  for (Eigen::Index i = 0; i < n; ++i) {
    const WorkspacePose& pose = set[static_cast<std::size_t>(i)].pose;
    observations.q_rad.col(i) = pose.q_rad;
    observations.p_WE.col(i) = pose.target_mm;
    observations.assembly.push_back(pose.assembly);
    observations.covariance_mm2.push_back(kR);
  }
  return calibration::assess_positions(observations, kRig.robot.nominal, kRig.robot.nominal)
      .fit.condition();
}

double error_made(
    const std::vector<DesignCandidate>& set, const std::vector<WorkspacePose>& where) {
  const geometry::ParameterVector robot = geometry::table_2_robot();
  double sum = 0.0;
  for (std::uint64_t seed = 1; seed <= kRepeats; ++seed) {
    calibration::RandomSequence random(seed, 55);
    calibration::OnlineEstimator online(kRig.robot.nominal);
    for (std::size_t i = 0; i < set.size(); ++i) {
      const WorkspacePose& pose = set[i].pose;
      simulation::Trial trial;
      trial.point = static_cast<int>(i);
      trial.q_rad = pose.q_rad;
      trial.assembly = pose.assembly;
      trial.position_covariance = kR;
      trial.position_mm = geometry::forward(robot, pose.q_rad, pose.assembly)->p_WE +
                          kNoise_mm * Eigen::Vector2d(random.normal(), random.normal());
      online.add(trial);
    }
    for (const WorkspacePose& pose : where) {
      sum += (geometry::forward(online.v(), pose.q_rad, pose.assembly)->p_WE -
              geometry::forward(robot, pose.q_rad, pose.assembly)->p_WE)
                 .norm();
    }
  }
  return sum / static_cast<double>(kRepeats * where.size());
}

void row(
    const std::string& name, const std::vector<DesignCandidate>& set,
    const std::vector<WorkspacePose>& where) {
  ParameterMatrix M = calibration::OnlineEstimator(kRig.robot.nominal).information();
  for (const DesignCandidate& each : set) add(M, each);
  const auto u = calibration::workspace_uncertainty(kRig.robot.nominal, M.inverse(), where);
  std::printf(
      "| %s | %zu | %.2f | %.2f | %.2f | %.0f |\n", name.c_str(), set.size(), 1000 * u.mean_mm,
      1000 * u.max_mm, 1000 * error_made(set, where), condition(set));
}

std::vector<DesignCandidate> chosen(
    const std::vector<DesignCandidate>& from, const std::vector<WorkspacePose>& where,
    calibration::Criterion criterion, int most_each, double limit_mm) {
  std::vector<DesignCandidate> set;
  for (const auto& step : calibration::greedy_design(
           kRig.robot.nominal, calibration::OnlineEstimator(kRig.robot.nominal).information(),
           from, where, 200, criterion, most_each)) {
    set.push_back(from[step.candidate]);
    if (step.uncertainty.mean_mm <= limit_mm) break;
  }
  return set;
}

void study(
    const char* title, std::span<const WorkingMode> used,
    std::span<const WorkingMode> measured) {
  const auto where = calibration::workspace_grid(kRig.robot.nominal, kLow, kHigh, 7, 7, used);
  const auto grid = candidates(10, 10, used);
  ParameterMatrix M = calibration::OnlineEstimator(kRig.robot.nominal).information();
  for (const DesignCandidate& each : grid) add(M, each);
  const double limit_mm =
      calibration::workspace_uncertainty(kRig.robot.nominal, M.inverse(), where).mean_mm;
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
  return 0;
}
