// Base and tool from any start, with gross rows.
#include "geometry/base_and_tool.h"

#include <gtest/gtest.h>

#include <random>

#include "geometry/robot_kind.h"
#include "geometry/robots/serial.h"
#include "geometry/rotation.h"

namespace sixdial::geometry {
namespace {

/// Poses of the last link, without a tool.
std::vector<Pose<double>> poses_of(
    const RobotModel& robot, int count, std::mt19937_64& random) {
  std::vector<Pose<double>> poses;
  for (int i = 0; i < count; ++i) {
    Eigen::VectorXd q(robot.joint_count());
    for (Eigen::Index k = 0; k < q.size(); ++k) {
      q[k] = std::uniform_real_distribution<double>(-2.0, 2.0)(random);
    }
    std::vector<Pose<double>> X(robot.frames.size());
    EXPECT_TRUE(robot.forward(robot.nominal, q, Assembly::kLeft, X));
    poses.push_back(X[0]);
  }
  return poses;
}

TEST(BaseAndTool, AreFoundFromAnyStartWithGrossRows) {
  std::mt19937_64 random(4);
  std::normal_distribution<double> noise(0.0, 1.0);
  std::uniform_real_distribution<double> draw(-1.0, 1.0);
  SerialRobot two;  // a positioner: two axes that meet, nothing else
  two.rows = {{.name = "q1", .alpha_rad = 1.5707963267948966}, {.name = "q2"}};
  const auto six = find_robot_kind("serial")->example();
  for (int trial = 0; trial < 20; ++trial) {
    const auto robot = trial % 2 == 0 ? six : serial_model(two);
    const auto poses = poses_of(*robot, 100, random);
    const Eigen::Matrix3d R = turned_by<double>(
        Eigen::Vector3d(3 * draw(random), 3 * draw(random), 3 * draw(random)));
    const Eigen::Vector3d t(3000 * draw(random), 3000 * draw(random), 1000 * draw(random));
    const Eigen::Vector3d tool(250 * draw(random), 250 * draw(random), 250 * draw(random));
    Eigen::MatrixXd measured(3, 100);
    for (int i = 0; i < 100; ++i) {
      const Pose<double>& X = poses[static_cast<std::size_t>(i)];
      measured.col(i) = R * (X.p + X.R * tool) + t;
      for (double& each : measured.col(i)) each += 0.1 * noise(random);
      if (i % 12 == 5) measured(0, i) += 300.0;
    }
    const auto found = register_base_and_tool(poses, measured);
    ASSERT_TRUE(found);
    EXPECT_LT(found->median, 0.3) << trial;
    for (int i = 0; i < 100; ++i) {
      if (i % 12 == 5) continue;
      const Pose<double>& X = poses[static_cast<std::size_t>(i)];
      EXPECT_LT((found->base(X.p + X.R * found->tool_mm) - measured.col(i)).norm(), 1.0);
    }
  }
}

TEST(BaseAndTool, TooFewPointsSayNothing) {
  const std::vector<Pose<double>> poses(5);
  EXPECT_FALSE(register_base_and_tool(poses, Eigen::MatrixXd::Zero(3, 5)));
}

}  // namespace
}  // namespace sixdial::geometry
