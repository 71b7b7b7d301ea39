// Curves of joints: found where they are, nothing where there are none.
#include "calibration/joint_curves.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "calibration/rig_spaces.h"
#include "calibration/space_fit.h"
#include "geometry/robots/serial.h"
#include "geometry/tool.h"

namespace sixdial::calibration {
namespace {

using Eigen::VectorXd;

constexpr double kNoise_mm = 0.02;

geometry::Rig arm() {
  geometry::Rig rig;
  rig.robot.model = geometry::find_robot_kind("serial")->example();
  rig.robot.nominal = rig.robot.model->nominal;
  rig.instrument.kind = "position";
  rig.instrument.dimensions = 3;
  return rig;
}

/// Joint 2 errs with two and seven waves, joint 4 has a soft place near 0.5 rad.
VectorXd hidden(const VectorXd& q) {
  VectorXd c = VectorXd::Zero(q.size());
  c[1] = 3e-4 * std::sin(2 * q[1] + 0.3) + 2e-4 * std::cos(7 * q[1]);
  c[3] = 8e-4 * std::exp(-0.5 * std::pow((q[3] - 0.5) / 0.25, 2));
  return c;
}

std::vector<simulation::Trial> measured(
    const geometry::Rig& rig, const VectorXd& truth, int count, bool curves, unsigned seed) {
  std::mt19937_64 random(seed);
  std::normal_distribution<double> noise(0.0, kNoise_mm);
  std::uniform_real_distribution<double> angle(-2.0, 2.0);
  const geometry::Tool tool(rig);
  std::vector<simulation::Trial> trials;
  for (int i = 0; i < count; ++i) {
    simulation::Trial trial;
    trial.sample = trial.point = i;
    trial.q.resize(6);
    for (double& each : trial.q) each = angle(random);
    const VectorXd q = curves ? VectorXd(trial.q + hidden(trial.q)) : trial.q;
    trial.position_mm = *tool.position(truth, q, geometry::Assembly::kLeft);
    for (double& each : *trial.position_mm) each += noise(random);
    trials.push_back(std::move(trial));
  }
  return trials;
}

double mean_error(
    const geometry::Rig& rig, const JointCurveFit& fit,
    const std::vector<simulation::Trial>& trials) {
  const geometry::Tool tool(rig);
  double sum = 0.0;
  for (const simulation::Trial& trial : trials) {
    const auto at =
        tool.position(fit.v, trial.q + fit.curves.at(trial.q), geometry::Assembly::kLeft);
    sum += (*at - *trial.position_mm).norm();
  }
  return sum / static_cast<double>(trials.size());
}

SpaceFit robust_fit(const ObservationSpace& space) {
  SpaceFitSettings settings;
  settings.loss = Loss::kCauchy;
  return fit_space(space, settings);
}

class JointCurvesTest : public ::testing::Test {
 protected:
  JointCurvesTest() : rig_(arm()), truth_(rig_.robot.nominal) {
    std::mt19937_64 random(2);
    std::uniform_real_distribution<double> draw(-0.5, 0.5);
    for (Eigen::Index i = 0; i < truth_.size(); ++i) {
      truth_[i] +=
          draw(random) * rig_.robot.model->parameters[static_cast<std::size_t>(i)].change;
    }
  }
  geometry::Rig rig_;
  VectorXd truth_;
};

TEST_F(JointCurvesTest, AreFoundWhereTheyAre) {
  auto trials = measured(rig_, truth_, 400, true, 5);
  (*trials[17].position_mm)[0] += 30.0;  // a gross row
  const SpaceFit start = robust_fit(position_space(trials, rig_));
  const auto fit = fit_joint_curves(trials, rig_, start.v, {.waves = 20});
  ASSERT_TRUE(fit);
  EXPECT_LT(std::abs(fit->sigma_mm / kNoise_mm - 1.0), 0.15);
  // Length of three coordinates' noise is 1.6 sigma in the mean.
  EXPECT_LT(mean_error(rig_, *fit, measured(rig_, truth_, 300, true, 6)), 1.9 * kNoise_mm);
  EXPECT_GT(fit->curves.size_rad(1), 1.5e-4);
  EXPECT_GT(fit->curves.size_rad(3), 1e-4);
  for (const int joint : {0, 2, 4, 5}) EXPECT_LT(fit->curves.size_rad(joint), 3e-5) << joint;
}

TEST_F(JointCurvesTest, AreNothingWhereThereAreNone) {
  const auto trials = measured(rig_, truth_, 400, false, 7);
  const SpaceFit start = fit_space(position_space(trials, rig_));
  const auto fit = fit_joint_curves(trials, rig_, start.v, {.waves = 20});
  ASSERT_TRUE(fit);
  for (int joint = 0; joint < 6; ++joint) EXPECT_LT(fit->curves.size_rad(joint), 3e-5);
  EXPECT_LT(mean_error(rig_, *fit, measured(rig_, truth_, 300, false, 8)), 1.75 * kNoise_mm);
}

TEST_F(JointCurvesTest, AsksForEnoughRows) {
  const auto trials = measured(rig_, truth_, 8, true, 9);
  EXPECT_FALSE(fit_joint_curves(trials, rig_, rig_.robot.nominal));
}

}  // namespace
}  // namespace sixdial::calibration
