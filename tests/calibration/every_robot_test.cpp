// Every kind of robot is calibrated from positions: the ladder of laws, one rung after the
// other.
#include <gtest/gtest.h>

#include <cmath>
#include <random>
#include <string>

#include "calibration/rig_spaces.h"
#include "calibration/space_fit.h"
#include "geometry/base_frame.h"
#include "geometry/rotation.h"
#include "geometry/tool.h"
#include "tests/support/test_arms.h"

namespace sixdial::calibration {
namespace {

using Eigen::VectorXd;

constexpr double kNoise_mm = 0.01;
constexpr int kSamples = 150;

SpaceFitSettings settings(
    Loss loss = Loss::kSquare, const std::optional<VectorXd>& start = std::nullopt) {
  SpaceFitSettings result;
  result.start = start;
  result.loss = loss;
  result.noise_mm = kNoise_mm;
  return result;
}

class EveryRobotFit : public ::testing::TestWithParam<const geometry::RobotKind*> {
 protected:
  EveryRobotFit() {
    rig_.name = "a rig";
    rig_.robot.model = GetParam()->example();
    rig_.robot.nominal = rig_.robot.model->nominal;
    rig_.robot.assembly =
        static_cast<geometry::Assembly>(rig_.robot.model->assemblies.front().number);
    rig_.robot.working_mode = geometry::WorkingMode(rig_.robot.model->modes.front().number);
    rig_.instrument.kind = "position";
    rig_.instrument.dimensions = rig_.robot.model->axes;
    truth_ = rig_.robot.nominal;
    for (Eigen::Index i = 0; i < truth_.size(); ++i) {
      truth_[i] +=
          within(-0.5, 0.5) * rig_.robot.model->parameters[static_cast<std::size_t>(i)].change;
    }
  }

  double within(double low, double high) {
    return std::uniform_real_distribution<double>(low, high)(random_);
  }

  std::vector<simulation::Trial> measured(double noise_mm) {
    const geometry::Tool tool(rig_);
    std::vector<simulation::Trial> trials;
    std::normal_distribution<double> noise(0.0, noise_mm);
    while (trials.size() < kSamples) {
      simulation::Trial trial;
      trial.sample = trial.point = static_cast<int>(trials.size());
      trial.assembly = rig_.robot.assembly;
      trial.q.resize(rig_.robot.model->joint_count());
      for (Eigen::Index k = 0; k < trial.q.size(); ++k) {
        const auto& joint = rig_.robot.model->joints[static_cast<std::size_t>(k)];
        trial.q[k] = within(joint.low, joint.high);
      }
      const auto at = tool.position(truth_, trial.q, trial.assembly);
      if (!at || !tool.position(rig_.robot.nominal, trial.q, trial.assembly)) continue;
      trial.position_mm = *at;
      if (noise_mm > 0.0) {
        for (double& each : *trial.position_mm) each += noise(random_);
      }
      trials.push_back(std::move(trial));
    }
    return trials;
  }

  geometry::Rig rig_;
  VectorXd truth_;
  std::mt19937_64 random_{14};
};

TEST_P(EveryRobotFit, TruthHasNoResidualAndAPerfectStartStays) {
  const ObservationSpace space = position_space(measured(0.0), rig_);
  EXPECT_LT(space.rmse(truth_), 1e-10);
  const SpaceFit fit = fit_space(space, settings(Loss::kSquare, truth_));
  EXPECT_EQ(fit.fit.status, FitStatus::kConverged);
  EXPECT_LT(fit.rmse_mm, 1e-9);
}

TEST_P(EveryRobotFit, NominalRecoversTheTruth) {
  const ObservationSpace space = position_space(measured(kNoise_mm), rig_);
  ASSERT_GT(space.rmse(space.nominal), 10 * kNoise_mm);
  const SpaceFit fit = fit_space(space, settings());
  EXPECT_EQ(fit.fit.status, FitStatus::kConverged);
  EXPECT_LT(std::abs(fit.sigma_mm / kNoise_mm - 1.0), 0.15);
  // chi^2 of the errors in the determined directions: 99.9 % lie below this.
  const VectorXd errors = (fit.v - truth_).cwiseQuotient(fit.fit.scale);
  const Eigen::Index told = fit.fit.singular_values.size() - fit.fit.held;
  const VectorXd along = fit.fit.directions.leftCols(told).transpose() * errors;
  const double chi2 =
      (along.cwiseProduct(fit.fit.singular_values.head(told)) / kNoise_mm).squaredNorm();
  const auto n = static_cast<double>(told);
  EXPECT_LT(chi2, n + 3.1 * std::sqrt(2 * n) + 10.0);
  // Other poses are met as well as these.
  const ObservationSpace fresh = position_space(measured(0.0), rig_);
  EXPECT_LT(fresh.rmse(fit.v), kNoise_mm);
}

// An instrument on its tripod: the frame is anywhere, one row in twenty is gross.
TEST_P(EveryRobotFit, TheBaseIsFoundInClosedFormFromAnywhere) {
  std::vector<simulation::Trial> trials = measured(kNoise_mm);
  const int axes = rig_.instrument.dimensions;
  geometry::Similarity away = geometry::Similarity::identity(axes);
  if (axes == 3) {
    away.R = geometry::turned_by<double>(Eigen::Vector3d(1.1, -2.0, 0.7));
    away.t = Eigen::Vector3d(2500, -700, 300);
  } else {
    away.R << std::cos(2.3), -std::sin(2.3), std::sin(2.3), std::cos(2.3);
    away.t = Eigen::Vector2d(250, -70);
  }
  for (simulation::Trial& trial : trials) *trial.position_mm = away(*trial.position_mm);
  for (std::size_t i = 0; i < trials.size(); i += 20) (*trials[i].position_mm)[0] += 40.0;
  const geometry::Tool tool(rig_);
  Eigen::MatrixXd nominal(axes, kSamples);
  Eigen::MatrixXd seen(axes, kSamples);
  std::vector<geometry::JointPose> poses;
  for (int i = 0; i < kSamples; ++i) {
    const simulation::Trial& trial = trials[static_cast<std::size_t>(i)];
    nominal.col(i) = *tool.position(rig_.robot.nominal, trial.q, trial.assembly);
    seen.col(i) = *trial.position_mm;
    if (i % 4 == 0) poses.push_back({trial.q, trial.assembly});
  }
  const auto found = geometry::register_points(nominal, seen);
  ASSERT_TRUE(found);
  const auto moved = geometry::with_base_moved(tool, rig_.robot.nominal, found->X, poses);
  ASSERT_TRUE(moved) << "this kind cannot stand elsewhere";
  rig_.robot.nominal = *moved;
  const SpaceFit fit = fit_space(position_space(trials, rig_), settings(Loss::kCauchy));
  int gross = 0;
  const Eigen::MatrixXd left = position_errors(position_space(trials, rig_), fit.v);
  for (int i = 0; i < kSamples; ++i) {
    if (left.col(i).norm() > 5.0) ++gross;
    if (i % 20 != 0) {
      EXPECT_LT(left.col(i).norm(), 8 * kNoise_mm) << i;
    }
  }
  EXPECT_EQ(gross, (kSamples + 19) / 20);
}

std::vector<const geometry::RobotKind*> every_kind() {
  geometry::spatial_arm();
  return {geometry::robot_kinds().begin(), geometry::robot_kinds().end()};
}
INSTANTIATE_TEST_SUITE_P(
    , EveryRobotFit, ::testing::ValuesIn(every_kind()),
    [](const auto& each) { return std::string(each.param->name); });

}  // namespace
}  // namespace sixdial::calibration
