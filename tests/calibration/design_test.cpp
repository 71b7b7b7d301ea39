// What to measure next: the choice is the best one by its own criterion, and it saves points
// where it counts, in errors really made.
#include "calibration/design.h"

#include <gtest/gtest.h>

#include <Eigen/Cholesky>
#include <Eigen/LU>
#include <cmath>

#include "calibration/online.h"
#include "calibration/random.h"
#include "calibration/space_fit.h"
#include "tests/calibration/support.h"

namespace sixdial::calibration {
namespace {

using Eigen::Matrix2d;
using geometry::ParameterMatrix;
using geometry::ParameterVector;
using geometry::WorkingMode;

const Eigen::Vector2d kLow(16, 30);
const Eigen::Vector2d kHigh(40, 66);
const ParameterVector kNominal = geometry::default_rig().robot.nominal;
const geometry::Tool kTool(geometry::default_rig());
constexpr double kNoise_mm = 0.003;
const Matrix2d kR = kNoise_mm * kNoise_mm * Matrix2d::Identity();

ParameterMatrix prior() { return OnlineEstimator(kTool, kNominal).information(); }

std::vector<DesignCandidate> candidates_of(int nx, int ny, std::span<const WorkingMode> modes) {
  std::vector<DesignCandidate> candidates;
  for (const WorkspacePose& pose :
       workspace_grid(kTool, kNominal, kLow, kHigh, nx, ny, modes)) {
    candidates.push_back({pose, kR});
  }
  return candidates;
}

ParameterMatrix told(const DesignCandidate& candidate) {
  const auto d =
      geometry::forward_derivative(kNominal, candidate.pose.q, candidate.pose.assembly);
  return d->J_v.transpose() * candidate.covariance_mm2.inverse() * d->J_v;
}

TEST(Design, EachChoiceIsTheBestOfAllByItsCriterion) {
  const std::array<WorkingMode, 2> modes{WorkingMode{+1, +1}, WorkingMode{-1, +1}};
  const auto where = workspace_grid(kTool, kNominal, kLow, kHigh, 5, 5, modes);
  const auto candidates = candidates_of(6, 7, modes);
  for (const Criterion criterion : {Criterion::kD, Criterion::kI}) {
    ParameterMatrix M = prior();
    const auto steps = greedy_design(kTool, kNominal, M, candidates, where, 8, criterion);
    ASSERT_EQ(steps.size(), 8U);
    std::vector<bool> taken(candidates.size(), false);
    for (const DesignStep& step : steps) {
      EXPECT_FALSE(taken[step.candidate]);
      const auto value = [&](std::size_t i) {
        const ParameterMatrix with = M + told(candidates[i]);
        if (criterion == Criterion::kD) {
          return -with.ldlt().vectorD().array().log().sum();
        }
        return workspace_uncertainty(kTool, kNominal, with.inverse(), where).rms_mm;
      };
      const double chosen = value(step.candidate);
      for (std::size_t i = 0; i < candidates.size(); ++i) {
        if (taken[i]) continue;
        EXPECT_LT(chosen, value(i) + 1e-9 * std::abs(chosen));
      }
      taken[step.candidate] = true;
      M += told(candidates[step.candidate]);
      EXPECT_NEAR(
          step.uncertainty.mean_mm,
          workspace_uncertainty(kTool, kNominal, M.inverse(), where).mean_mm, 1e-6);
    }
  }
}

TEST(Design, NothingIsProposedMoreOftenThanAllowed) {
  const std::array<WorkingMode, 1> modes{WorkingMode{}};
  const auto candidates = candidates_of(2, 2, modes);
  const auto where = workspace_grid(kTool, kNominal, kLow, kHigh, 3, 3, modes);
  EXPECT_EQ(
      greedy_design(kTool, kNominal, prior(), candidates, where, 10, Criterion::kI).size(), 4U);
  EXPECT_EQ(
      greedy_design(kTool, kNominal, prior(), candidates, where, 10, Criterion::kI, 2).size(),
      8U);
  EXPECT_TRUE(greedy_design(kTool, kNominal, prior(), {}, where, 10, Criterion::kI).empty());
}

TEST(Design, WorkingModesPooledMakeTheParametersWellConditioned) {
  const std::array<WorkingMode, 1> one{WorkingMode{}};
  const auto condition = [](std::span<const WorkingMode> modes, int n) {
    testing::SessionPlan plan;
    const auto poses = workspace_grid(kTool, kNominal, kLow, kHigh, n, n, modes);
    PositionObservations set;
    set.q_rad.resize(2, static_cast<Eigen::Index>(poses.size()));
    set.p_WE.resize(2, static_cast<Eigen::Index>(poses.size()));
    for (std::size_t i = 0; i < poses.size(); ++i) {
      set.q_rad.col(static_cast<Eigen::Index>(i)) = poses[i].q;
      set.p_WE.col(static_cast<Eigen::Index>(i)) = poses[i].target_mm;
      set.assembly.push_back(poses[i].assembly);
      set.covariance_mm2.push_back(kR);
    }
    set.target_mm.resize(poses.size());
    return assess_positions(set, kNominal, kNominal).fit.condition();
  };
  const double single = condition(one, 10);
  const double pooled = condition(geometry::kWorkingModes, 5);
  std::printf("condition number: one mode %.0f, four modes %.0f\n", single, pooled);
  EXPECT_GT(single, 100.0);
  EXPECT_LT(pooled, single / 2);
}

/// Mean position error really made over the workspace with parameters fitted to `set`.
double error_made(
    const ParameterVector& robot, const std::vector<DesignCandidate>& set,
    std::span<const WorkspacePose> where, std::uint64_t seeds) {
  double sum = 0.0;
  int tried = 0;
  for (std::uint64_t seed = 1; seed <= seeds; ++seed) {
    RandomSequence random(seed, 55);
    OnlineEstimator online(kTool, kNominal);
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
      ++tried;
    }
  }
  return sum / tried;
}

TEST(Design, ChosenPosesMakeNoLargerErrorsThanAGridOfManyMore) {
  const std::array<WorkingMode, 1> modes{WorkingMode{}};
  const auto where = workspace_grid(kTool, kNominal, kLow, kHigh, 7, 7, modes);
  const auto grid = candidates_of(10, 10, modes);
  ParameterMatrix M = prior();
  for (const DesignCandidate& each : grid) M += told(each);
  const double limit_mm = workspace_uncertainty(kTool, kNominal, M.inverse(), where).mean_mm;

  const auto candidates = candidates_of(25, 25, modes);
  const auto steps =
      greedy_design(kTool, kNominal, prior(), candidates, where, 100, Criterion::kI);
  std::vector<DesignCandidate> chosen;
  for (const DesignStep& step : steps) {
    chosen.push_back(candidates[step.candidate]);
    if (step.uncertainty.mean_mm <= limit_mm) break;
  }
  const double grid_mm = error_made(geometry::table_2_robot(), grid, where, 60);
  const double chosen_mm = error_made(geometry::table_2_robot(), chosen, where, 60);
  std::printf(
      "grid of 100: predicted %.5f mm, made %.5f mm; %zu chosen poses: made %.5f mm\n",
      limit_mm, grid_mm, chosen.size(), chosen_mm);
  EXPECT_LE(chosen.size(), 80U);
  // Means of 60 repeats of correlated errors: some percent.
  EXPECT_LT(chosen_mm, 1.12 * grid_mm);
}

}  // namespace
}  // namespace sixdial::calibration
