// How well an extended model says that it knows its targets, against where the true robot goes.
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <random>
#include <vector>

#include "geometry/lever.h"
#include "studies/diagnose.h"
#include "studies/extended_command.h"
#include "tests/support/pose_session.h"

namespace sixdial::studies {
namespace {

using Eigen::Vector3d;
using Eigen::VectorXd;
using testing::PoseSession;

constexpr int kTargets = 20;
constexpr double kFactor = 2.0;  // between deviations that are said and found

DiagnosisResult diagnosed(const PoseSession& made) {
  return diagnose(made.session, {.bootstrap = 0, .with_gain = false});
}

GivenTarget target_at(const PoseSession& made, const VectorXd& q) {
  const geometry::Pose<double> X = made.at(q);
  return {X.p, AskedTurn{geometry::rotation_vector(X.R), "rotation vector"}};
}

/// Mean squares of where the true tool was off, and of what was said of it [mm^2, rad^2].
struct SaidAndTrue {
  double place = 0.0, said_place = 0.0, turn = 0.0, said_turn = 0.0;
};

/// Targets that the true robot takes with joint 6 at `last_rad`.
SaidAndTrue commanded(const PoseSession& made, const ExtendedFit& fit, double last_rad) {
  const geometry::Rig& rig = made.session.rig;
  const ExtendedCommand command(fit, rig);
  std::mt19937_64 random(12);
  SaidAndTrue sum;
  for (int i = 0; i < kTargets; ++i) {
    VectorXd q = testing::any_open_joints(random);
    q[5] = last_rad;
    const GivenTarget given = target_at(made, q);
    const auto found = command.solve(given.target(), geometry::WorkingMode(0), {}, q);
    EXPECT_TRUE(found) << found.error().message;
    if (!found) continue;
    const CommandedTarget at = commanded_target(
        found, CompensateBy::kExtended, given, geometry::WorkingMode(0), *rig.robot.model);
    const auto said = command.uncertainty(at, {});
    EXPECT_TRUE(said && said->turn_sd_rad);
    if (!said || !said->turn_sd_rad) continue;
    const geometry::Pose<double> there = made.at(found->q);
    sum.place += (there.p - given.p_mm).squaredNorm() / kTargets;
    sum.turn += std::pow(geometry::turn_between(there.R, *given.target().R), 2) / kTargets;
    sum.said_place += std::pow(said->position_sd_mm, 2) / kTargets;
    sum.said_turn += std::pow(*said->turn_sd_rad, 2) / kTargets;
  }
  return sum;
}

TEST(ExtendedUncertainty, IsThatOfTheTrueErrors) {
  // One session's parameters are off all together; of four the mean squares agree to a factor.
  constexpr std::array<std::uint64_t, 4> kSeeds{5, 6, 7, 8};
  SaidAndTrue sum;
  for (const std::uint64_t seed : kSeeds) {
    const PoseSession made = testing::pose_session({.seed = seed});
    const ExtendedFit fit = diagnosed(made).extended_fit;
    EXPECT_TRUE(fit.turns.value_or(false));
    ASSERT_TRUE(fit.left_sd_mm);
    EXPECT_LT(*fit.left_sd_mm, 0.02);
    const SaidAndTrue here = commanded(made, fit, 0.1);
    EXPECT_LT(std::sqrt(here.place), 0.1);
    sum.place += here.place;
    sum.said_place += here.said_place;
    sum.turn += here.turn;
    sum.said_turn += here.said_turn;
  }
  const double place = std::sqrt(sum.place / sum.said_place);
  const double turn = std::sqrt(sum.turn / sum.said_turn);
  EXPECT_LT(place, kFactor);
  EXPECT_GT(place, 1.0 / kFactor);
  EXPECT_LT(turn, kFactor);
  EXPECT_GT(turn, 1.0 / kFactor);
}

TEST(ExtendedUncertainty, KnowsNoBetterThanBeforeWhatNoPoseShowed) {
  // Joint 6 rests in all poses: links before it and the tool behind it can be exchanged.
  const PoseSession made = testing::pose_session({.last_joint_rests = true});
  const ExtendedFit fit = diagnosed(made).extended_fit;
  const SaidAndTrue at_rest = commanded(made, fit, 0.0);
  EXPECT_LT(at_rest.place, 6.0 * at_rest.said_place);
  EXPECT_LT(std::sqrt(at_rest.said_place), 0.3);
  const SaidAndTrue turned = commanded(made, fit, 1.0);
  EXPECT_LT(turned.place, 6.0 * turned.said_place);
  EXPECT_LT(turned.turn, 6.0 * turned.said_turn);
  EXPECT_GT(turned.said_turn, 9.0 * at_rest.said_turn);
  // Nor worse: what can be exchanged is known to plausible changes of the turns that share it.
  const geometry::Robot& robot = made.session.rig.robot;
  double most_rad = 0.0;
  for (const geometry::ParameterInfo& each : robot.model->parameters) {
    if (each.unit == "rad") most_rad = std::max(most_rad, each.change);
  }
  EXPECT_LT(std::sqrt(turned.said_turn), 2.0 * most_rad);
}

TEST(ExtendedUncertainty, HasSmoothErrorsWithoutANameInIt) {
  const PoseSession made = testing::pose_session();
  const geometry::Rig& rig = made.session.rig;
  const auto n = made.truth.size();
  ExtendedFit fit{
      .model = {made.truth.begin(), made.truth.end()},
      .nominal = std::vector<double>(made.truth.begin(), made.truth.end()),
      .covariance = Eigen::MatrixXd(1e-12 * Eigen::MatrixXd::Identity(n, n)),
      .turns = true};
  const SaidAndTrue without = commanded(made, fit, 0.1);
  fit.left_sd_mm = 0.07;
  const SaidAndTrue with = commanded(made, fit, 0.1);
  EXPECT_NEAR(with.said_place - without.said_place, 3 * 0.07 * 0.07, 1e-9);
  const double at_lever = 0.07 / geometry::lever_mm(*geometry::instrument_of(rig));
  EXPECT_NEAR(with.said_turn - without.said_turn, 3 * at_lever * at_lever, 1e-15);
}

}  // namespace
}  // namespace sixdial::studies
