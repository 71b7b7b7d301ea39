// Balls in sockets: what is known of the sockets' distance is known to a diagnosis too. It
// tells the common factor of an arm's lengths, and no more surely than it is known itself.
#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "diagnosis/joint_fit.h"
#include "diagnosis/readings.h"
#include "geometry/robots/serial.h"
#include "geometry/tool.h"

namespace sixdial::diagnosis {
namespace {

using Eigen::Index;
using Eigen::Vector3d;
using Eigen::VectorXd;

constexpr double kLarger = 1.005;  // of the true arm, in all its lengths
constexpr double kNoise_mm = 0.02;
constexpr double kApart_mm = 300.0;

geometry::Rig arm_in_sockets(std::optional<double> distance_sd_mm) {
  geometry::Rig rig;
  const auto example = geometry::find_robot_kind("serial")->example();
  rig.robot.model = geometry::serial_model(geometry::serial_robot(*example, example->nominal));
  rig.robot.nominal = rig.robot.model->nominal;
  rig.instrument.kind = "socket";
  rig.instrument.dimensions = 3;
  rig.instrument.sd_mm = kNoise_mm;
  rig.instrument.sockets = {{.name = "S1"}, {.name = "S2"}};
  if (distance_sd_mm) {
    rig.instrument.socket_distances = {{"S1", "S2", kApart_mm, *distance_sd_mm}};
  }
  return rig;
}

/// The nominal arm, its lengths and its tool all larger by the same factor.
std::shared_ptr<const geometry::RobotModel> larger(const geometry::Rig& rig) {
  geometry::SerialRobot arm = geometry::serial_robot(*rig.robot.model, rig.robot.nominal);
  for (geometry::SerialRow& row : arm.rows) {
    row.a_mm *= kLarger;
    row.d_mm *= kLarger;
  }
  arm.tool_mm *= kLarger;
  return geometry::serial_model(arm);
}

std::vector<simulation::Trial> in_sockets(const geometry::Rig& rig, int count) {
  const auto model = larger(rig);
  const std::vector<Vector3d> places{{600, -150, 200}, {600, -150 + kApart_mm, 200}};
  std::mt19937_64 engine(3);
  std::normal_distribution<double> normal(0.0, kNoise_mm);
  std::uniform_real_distribution<double> any(-2.0, 2.0);
  std::vector<simulation::Trial> trials;
  while (std::ssize(trials) < count) {
    const std::size_t socket = trials.size() % 2;
    VectorXd near(model->joint_count());
    for (double& each : near) each = any(engine);
    Vector3d ball = places[socket];
    for (double& each : ball) each += normal(engine);
    geometry::Pose<double> X_WE{.p = ball};
    X_WE.R.setConstant(std::nan(""));
    const auto q = model->kind->inverse(
        *model, {model->nominal.data(), static_cast<std::size_t>(model->nominal.size())}, X_WE,
        {}, {near.data(), static_cast<std::size_t>(near.size())});
    if (!q) continue;
    simulation::Trial& trial = trials.emplace_back();
    trial.sample = trial.point = static_cast<int>(trials.size()) - 1;
    trial.q = *q;
    trial.reading.resize(6);
    for (std::size_t axis = 0; axis < 3; ++axis) trial.reading[3 * socket + axis] = 0.0;
  }
  return trials;
}

/// How much farther the fitted arm reaches than the nominal one, in the mean of many pairs of
/// poses: 1 if it is as large.
double size_of(const geometry::Rig& rig, const VectorXd& v) {
  const geometry::Tool tool(rig);
  std::mt19937_64 engine(8);
  std::uniform_real_distribution<double> any(-2.0, 2.0);
  double ratio = 0.0;
  constexpr int kPairs = 200;
  for (int pair = 0; pair < kPairs; ++pair) {
    VectorXd a(rig.robot.model->joint_count());
    VectorXd b(rig.robot.model->joint_count());
    for (double& each : a) each = any(engine);
    for (double& each : b) each = any(engine);
    const auto apart = [&](const VectorXd& of) {
      return (*tool.position(of, a, rig.robot.assembly) -
              *tool.position(of, b, rig.robot.assembly))
          .norm();
    };
    ratio += apart(v) / apart(rig.robot.nominal) / kPairs;
  }
  return ratio;
}

struct Fitted {
  double size = 0.0, rms_mm = 0.0;
};

Fitted fitted(std::optional<double> distance_sd_mm) {
  const geometry::Rig rig = arm_in_sockets(distance_sd_mm);
  const simulation::ForwardModel model(rig);
  Readings readings(model, in_sockets(rig, 120));
  const JointFit fit = fit_jointly(readings, readings.nominal(), {});
  EXPECT_TRUE(fit.converged);
  return {
      size_of(rig, fit.model.head(rig.robot.nominal.size())),
      std::sqrt(fit.residual_mm.squaredNorm() / static_cast<double>(readings.count()))};
}

TEST(KnownDistance, TellsADiagnosisHowLargeTheArmIs) {
  const Fitted told = fitted(0.05);
  // 0.05 mm of 300, and the noise.
  EXPECT_NEAR(told.size, kLarger, 4e-4);
  EXPECT_LT(told.rms_mm, 1.3 * kNoise_mm);
  // Nothing else does: the arm stays as large as it was thought to be.
  const Fitted untold = fitted(std::nullopt);
  EXPECT_LT(std::abs(untold.size - 1.0), 2e-3);
  EXPECT_LT(untold.rms_mm, 1.3 * kNoise_mm);
}

TEST(KnownDistance, IsNoBetterKnownAfterwards) {
  // The readings say nothing of it: all that they tell is where it puts the scale.
  const geometry::Rig rig = arm_in_sockets(0.05);
  const simulation::ForwardModel model(rig);
  Readings readings(model, in_sockets(rig, 120));
  const JointFit fit = fit_jointly(readings, readings.nominal(), {});
  ASSERT_EQ(fit.known, 1);
  EXPECT_LT(std::abs(fit.u[0] / fit.known_sd_mm), 0.5);  // in its standard deviations
  EXPECT_NEAR(fit.u_sd_mm[0] / fit.known_sd_mm, 1.0, 0.15);
}

}  // namespace
}  // namespace sixdial::diagnosis
