// The filter that runs while points come in: honest about what it knows at each moment, equal
// to the fit of everything at the end, not led astray by a gross error.
#include "calibration/online.h"

#include <gtest/gtest.h>

#include <cmath>

#include "calibration/random.h"
#include "calibration/space_fit.h"
#include "tests/calibration/support.h"

namespace sixdial::calibration {
namespace {

using geometry::ParameterVector;
using testing::SessionPlan;
using testing::simulate;

const Eigen::Vector2d kLow(16, 30);
const Eigen::Vector2d kHigh(40, 66);
const geometry::Tool kTool(geometry::default_rig());

simulation::Trial trial_of(const PositionObservations& set, int i) {
  const auto k = static_cast<std::size_t>(i);
  simulation::Trial trial;
  trial.point = set.point[k];
  trial.repeat = set.repeat[k];
  trial.q = set.q_rad.col(i);
  trial.assembly = set.assembly[k];
  trial.position_mm = set.p_WE.col(i);
  trial.position_covariance = set.covariance_mm2[k];
  return trial;
}

/// A robot drawn from what the settings say is known of one.
ParameterVector drawn_robot(
    const ParameterVector& nominal, const OnlineSettings& settings, std::uint64_t seed) {
  RandomSequence random(seed, 77);
  ParameterVector v = nominal;
  for (int i = 0; i < 10; ++i) {
    const double known_to = geometry::kParameters[static_cast<std::size_t>(i)].known_to;
    v[i] += settings.times_known * known_to * random.normal();
  }
  return v;
}

TEST(Online, ThePredictedUncertaintyIsTheErrorThatIsMade) {
  const OnlineSettings settings{.times_known = 0.3};
  const std::array<geometry::WorkingMode, 1> modes{geometry::WorkingMode{}};
  for (const int count : {3, 8, 20, 60}) {
    double normalised = 0.0;
    int tried = 0;
    for (std::uint64_t seed = 1; seed <= 150; ++seed) {
      SessionPlan plan;
      plan.robot = drawn_robot(plan.nominal, settings, seed);
      plan.g1_points = count;
      const auto session = simulate(plan, seed);
      OnlineEstimator online(kTool, session.nominal, settings);
      for (int i = 0; i < session.g1.size(); ++i) online.add(trial_of(session.g1, i));
      ASSERT_EQ(online.samples(), count);
      for (const WorkspacePose& pose :
           workspace_grid(kTool, session.nominal, kLow, kHigh, 3, 3, modes)) {
        const auto said = geometry::forward(online.v(), pose.q, pose.assembly);
        const auto is = geometry::forward(session.robot, pose.q, pose.assembly);
        ASSERT_TRUE(said && is);
        const double sd = position_sd_mm(kTool, online.v(), online.P(), pose);
        normalised += (said->p_WE - is->p_WE).squaredNorm() / (sd * sd);
        ++tried;
      }
    }
    ASSERT_EQ(tried, 1350);
    // Mean of a chi-squared over its degrees of freedom, errors correlated within a session.
    EXPECT_NEAR(normalised / tried, 1.0, 0.25) << count << " samples";
  }
}

TEST(Online, EndsWhereTheFitOfAllSamplesEnds) {
  const auto session = simulate({}, 5);
  OnlineEstimator usual(kTool, session.nominal);
  for (int i = 0; i < session.g1.size(); ++i) usual.add(trial_of(session.g1, i));
  SpaceFitSettings settings;
  settings.weighting = Weighting::kByCovariance;
  const auto fit = fit_positions(session.g1, session.nominal, settings);
  ASSERT_EQ(fit.fit.held, 0);
  for (int i = 0; i < geometry::kParameterCount; ++i) {
    const double sd = std::sqrt(usual.P()(i, i));
    // The prior of a millimetre pulls by the square of sd over it.
    EXPECT_LT(std::abs(usual.v()[i] - fit.v[i]), 0.1 * sd) << i;
    EXPECT_NEAR(sd / std::sqrt(fit.covariance(i, i)), 1.0, 0.15) << i;
  }
}

TEST(Online, EachSampleMakesTheWorkspaceBetterKnown) {
  SessionPlan plan;
  plan.noise_mm = 0.0;
  const auto session = simulate(plan, 6);
  const std::array<geometry::WorkingMode, 1> modes{geometry::WorkingMode{}};
  const auto where = workspace_grid(kTool, session.nominal, kLow, kHigh, 5, 5, modes);
  ASSERT_EQ(where.size(), 25U);
  OnlineEstimator online(kTool, session.nominal);
  double before = online.predicted(where).rms_mm;
  EXPECT_GT(before, 1.0);
  for (int i = 0; i < session.g1.size(); ++i) {
    online.add(trial_of(session.g1, i));
    const double now = online.predicted(where).rms_mm;
    // The derivatives move with the estimate while that is still millimetres off.
    EXPECT_LT(now, before * (i < 8 ? 1.02 : 1.0 + 1e-6)) << i;
    before = now;
  }
  EXPECT_LT(before, 0.002);
  EXPECT_EQ(online.variance_factor(), 1.0);
}

TEST(Online, WhatKinematicsCannotExplainWidensTheUncertainty) {
  SessionPlan plan;
  plan.non_kinematic = 1.0;
  const auto bent = simulate(plan, 7);
  plan.non_kinematic = 0.0;
  const auto straight = simulate(plan, 7);
  OnlineEstimator with(kTool, bent.nominal);
  OnlineEstimator without(kTool, bent.nominal);
  for (int i = 0; i < bent.g1.size(); ++i) {
    with.add(trial_of(bent.g1, i));
    without.add(trial_of(straight.g1, i));
  }
  EXPECT_GT(with.variance_factor(), 5.0);  // 0.02 mm of bending against 0.003 mm of noise
  EXPECT_LT(without.variance_factor(), 1.5);
  EXPECT_GT(with.P().trace(), 3 * without.P().trace());
  EXPECT_EQ(with.set_aside(), 0);
}

/// A frame that lies elsewhere and is turned, by a standard deviation of each.
constexpr double kShift_mm = 0.01;
Eigen::MatrixXd frame_at(const Eigen::VectorXd& p_mm) {
  constexpr double kTurn_rad = 1e-4;
  Eigen::MatrixXd shared(2, 2);
  shared << kShift_mm, -kTurn_rad * p_mm.y(), 0.0, kTurn_rad * p_mm.x();
  return shared;
}

TEST(Online, WhatAllSamplesShareIsCountedAsFarAsItMovesTheEstimate) {
  const auto session = simulate({}, 9);
  OnlineEstimator plain(kTool, session.nominal), told(kTool, session.nominal);
  std::vector<OnlineEstimator> moved(2, plain);
  for (int i = 0; i < session.g1.size(); ++i) {
    const simulation::Trial trial = trial_of(session.g1, i);
    const Eigen::MatrixXd shared = frame_at(*trial.position_mm);
    plain.add(trial);
    told.add(trial, shared);
    for (std::size_t k = 0; k < moved.size(); ++k) {
      simulation::Trial off = trial;
      *off.position_mm += shared.col(static_cast<Eigen::Index>(k));
      moved[k].add(off);
    }
  }
  EXPECT_EQ(told.v(), plain.v());
  EXPECT_EQ(told.P(), plain.P());
  EXPECT_EQ(plain.covariance(), plain.P());
  EXPECT_FALSE(plain.has_shared());
  ASSERT_TRUE(told.has_shared());
  Eigen::MatrixXd expected = Eigen::MatrixXd::Zero(10, 10);
  for (const OnlineEstimator& each : moved) {
    const Eigen::VectorXd by = each.v() - plain.v();
    expected += by * by.transpose();
  }
  EXPECT_LT((told.shared_covariance() - expected).norm(), 0.01 * expected.norm());
  EXPECT_NEAR(
      std::sqrt(told.shared_covariance()(geometry::kX0, geometry::kX0)), kShift_mm,
      0.02 * kShift_mm);
  // The tool's place is as uncertain as the frame, and by noise besides.
  const std::array<geometry::WorkingMode, 1> modes{geometry::WorkingMode{}};
  const auto where = workspace_grid(kTool, session.nominal, kLow, kHigh, 3, 3, modes);
  for (const WorkspacePose& pose : where) {
    const double sd_mm = position_sd_mm(kTool, told.v(), told.shared_covariance(), pose);
    EXPECT_NEAR(sd_mm / frame_at(pose.target_mm).norm(), 1.0, 0.02);
  }
  EXPECT_GT(told.predicted(where).max_mm, plain.predicted(where).max_mm);
}

TEST(Online, AGrossErrorIsSetAsideAndItsSizeTold) {
  const auto session = simulate({}, 8);
  OnlineEstimator clean(kTool, session.nominal);
  OnlineEstimator online(kTool, session.nominal);
  for (int i = 0; i < session.g1.size(); ++i) {
    simulation::Trial trial = trial_of(session.g1, i);
    clean.add(trial);
    const bool wrong = i == 40;
    if (wrong) trial.position_mm->x() += 0.2;
    const auto told = online.add(trial);
    ASSERT_TRUE(told);
    EXPECT_EQ(told->set_aside, wrong) << i;
    if (wrong) {
      EXPECT_GT(told->times_usual, 20.0);
      EXPECT_NEAR(told->innovation_mm.x(), 0.2, 0.03);
    }
  }
  EXPECT_EQ(online.set_aside(), 1);
  for (int i = 0; i < geometry::kParameterCount; ++i) {
    EXPECT_LT(std::abs(online.v()[i] - clean.v()[i]), std::sqrt(clean.P()(i, i))) << i;
  }
}

TEST(Online, AGrossErrorAmongTheFirstSamplesIsFoundOut) {
  for (const int wrong : {0, 4, 9}) {
    const auto session = simulate({}, 12);
    OnlineEstimator clean(kTool, session.nominal);
    OnlineEstimator online(kTool, session.nominal);
    for (int i = 0; i < 30; ++i) {
      simulation::Trial trial = trial_of(session.g1, i);
      if (i != wrong) clean.add(trial);
      if (i == wrong) *trial.position_mm += Eigen::Vector2d(-10.3, 6.1);
      online.add(trial);
    }
    EXPECT_EQ(online.set_aside(), 1) << wrong;
    EXPECT_EQ(online.samples(), 29);
    EXPECT_LT(online.variance_factor(), 2.0);
    EXPECT_LT(
        (online.v() - clean.v()).cwiseQuotient(clean.P().diagonal().cwiseSqrt()).norm(), 1e-2);
  }
}

TEST(Online, ARetakenSampleTakesTheEarlierOnesPlace) {
  const auto session = simulate({}, 9);
  OnlineEstimator once(kTool, session.nominal);
  OnlineEstimator retaken(kTool, session.nominal);
  for (int i = 0; i < 30; ++i) {
    simulation::Trial trial = trial_of(session.g1, i);
    once.add(trial);
    if (i == 12) {
      trial.position_mm->y() -= 0.5;  // too early to be seen as gross
      retaken.add(trial);
    }
    retaken.add(trial_of(session.g1, i));
  }
  EXPECT_EQ(retaken.samples(), 30);
  EXPECT_LT(
      (retaken.v() - once.v()).cwiseQuotient(once.P().diagonal().cwiseSqrt()).norm(), 1e-3);
}

TEST(Online, ASampleWithoutAPositionTeachesNothing) {
  const auto session = simulate({}, 10);
  OnlineEstimator online(kTool, session.nominal);
  simulation::Trial trial = trial_of(session.g1, 0);
  trial.position_mm.reset();
  EXPECT_FALSE(online.add(trial));
  EXPECT_EQ(online.samples(), 0);
  EXPECT_EQ(online.v(), session.nominal);
}

}  // namespace
}  // namespace sixdial::calibration
