// Plans that ask for turns of a tool whose probe sits turned on the flange, as the rig file
// does not know: a turn means the probe's frame from the plan file to the command.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <cmath>
#include <random>
#include <string>
#include <vector>

#include "geometry/tool.h"
#include "session/csv.h"
#include "session/plan.h"
#include "session/sample_layout.h"
#include "studies/calibrate.h"
#include "studies/compensate.h"
#include "studies/extended_command.h"
#include "tests/support/calibrated_poses.h"

namespace sixdial::studies {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;
using Eigen::VectorXd;
using testing::PoseSession;

constexpr int kPoints = 6;
constexpr double kReached_mm = 0.3;  // the calibrated robot; the wrong frame is off by radians
constexpr double kReached_rad = 6e-4;

class PlansWithTurns : public testing::CalibratedPoses {
 protected:
  static const geometry::Rig& rig() { return poses->session.rig; }
  static calibration::CompensationModel model() {
    return compensation_model(*calibrated, rig(), CompensateBy::kKinematics);
  }

  /// Places and turns that the true robot can take, as a plan file without joint values.
  static std::string plan_file() {
    std::mt19937_64 random(31);
    std::string text =
        "set,point,target_x_mm,target_y_mm,target_z_mm,target_rx_deg,target_ry_deg,"
        "target_rz_deg\n";
    for (int i = 0; i < kPoints; ++i) {
      const geometry::Pose<double> X = poses->at(testing::any_open_joints(random));
      const Vector3d turn_deg = geometry::kDegPerRad * geometry::rotation_vector(X.R);
      text += fmt::format(
          "G1,{},{:.6f},{:.6f},{:.6f},{:.9f},{:.9f},{:.9f}\n", i, X.p[0], X.p[1], X.p[2],
          turn_deg[0], turn_deg[1], turn_deg[2]);
    }
    return text;
  }
  static session::Plan read_by(const geometry::Rig& rig) {
    return session::parse_plan(plan_file(), "plan.csv", rig);
  }

  /// As of a planner that takes the rig file's tool for the probe: the wrist stands otherwise.
  static session::Plan with_other_joints(session::Plan plan) {
    for (session::PlanPoint& point : plan.points) {
      point.q[3] += 0.9;
      point.q[5] -= 1.4;
    }
    return plan;
  }

  static void expect_reached(const session::Plan& commanded) {
    for (const session::PlanPoint& point : commanded.points) {
      const geometry::Pose<double> there = poses->at(point.q);
      const Matrix3d asked = geometry::turned_by<double>(*point.target_turn_rad);
      EXPECT_LT((there.p - point.target_mm).norm(), kReached_mm);
      EXPECT_LT(geometry::turn_between(there.R, asked), kReached_rad);
    }
  }
};

/// How far these parameters have the tool turned from what the point asks for [rad].
double off_by(
    const geometry::Robot& robot, const VectorXd& v, const VectorXd& q, const Matrix3d& asked) {
  return geometry::turn_between(
      geometry::turn_of_tool(*robot.model, v, q, robot.assembly).value(), asked);
}

TEST_F(PlansWithTurns, AreReadByTheFrameThatTheInstrumentMeasured) {
  const geometry::Rig probes = rig_of_turns(rig(), model()).value();
  const session::Plan read = read_by(probes);
  ASSERT_EQ(read.points.size(), static_cast<std::size_t>(kPoints));
  for (const session::PlanPoint& point : read.points) {
    const Matrix3d asked = geometry::turned_by<double>(*point.target_turn_rad);
    EXPECT_LT(off_by(probes.robot, model().nominal, point.q, asked), 1e-6);
    EXPECT_GT(off_by(rig().robot, rig().robot.nominal, point.q, asked), 1.0);  // the file's
    EXPECT_EQ(near_of(point, model(), rig()), point.q);
  }
  expect_reached(compensated_plan(read, model(), rig()));
  // The same is known before anything is fitted.
  const geometry::Rig before = rig_of_turns(poses->session).value();
  EXPECT_LT((before.robot.nominal - probes.robot.nominal).norm(), 1e-6);
  // Only the tool's frame is another one.
  for (Eigen::Index i = 0; i < rig().robot.nominal.size(); ++i) {
    const geometry::ParameterInfo& info =
        rig().robot.model->parameters[static_cast<std::size_t>(i)];
    if (info.name.starts_with("tool_r")) continue;
    EXPECT_LE(std::abs(probes.robot.nominal[i] - rig().robot.nominal[i]), 1e-6 * info.change)
        << info.name;
  }
}

TEST_F(PlansWithTurns, AreRefusedWhereTheMeasuredFrameCannotBeSet) {
  const testing::TempDirectory directory;
  const std::string path = (directory.path() / "plan.csv").string();
  session::write_file(path, plan_file());
  const auto turned = rig_of_turns(rig(), model());
  EXPECT_EQ(read_plan(path, rig(), turned).points.size(), std::size_t{kPoints});
  // A middle of the measured joint values that the robot cannot take tells no frame.
  calibration::CompensationModel lost = model();
  lost.measured_at.begin()->second.setConstant(std::nan(""));
  EXPECT_FALSE(rig_of_turns(rig(), lost));
  try {
    static_cast<void>(read_plan(path, rig(), std::nullopt));
    FAIL() << "read by another frame";
  } catch (const StudyError& error) {
    EXPECT_NE(std::string(error.what()).find("asks for turns"), std::string::npos);
  }
  session::write_file(
      path, "set,point,target_x_mm,target_y_mm,target_z_mm\nG1,0,-600,-300,400\n");
  EXPECT_EQ(read_plan(path, rig(), std::nullopt).points.size(), 1U);
}

TEST_F(PlansWithTurns, AreNotCommandedNearJointValuesOfAnotherPose) {
  const session::Plan elsewhere =
      with_other_joints(read_by(rig_of_turns(rig(), model()).value()));
  for (const session::PlanPoint& point : elsewhere.points) {
    EXPECT_FALSE(near_of(point, model(), rig()));
  }
  const session::Plan commanded = compensated_plan(elsewhere, model(), rig());
  expect_reached(commanded);
  for (const session::PlanPoint& point : commanded.points) {
    const GivenTarget given{
        point.target_mm, AskedTurn{*point.target_turn_rad, rig().instrument.orientation}};
    const CommandedTarget alone =
        compensated_target(model(), CompensateBy::kKinematics, given, geometry::WorkingMode(0));
    const VectorXd q = Eigen::Map<const VectorXd>(alone.theta_rad.data(), 6);
    EXPECT_LT((point.q - q).norm(), 1e-8);
  }
}

TEST_F(PlansWithTurns, OfAnExtendedModelMeanTheSameFrame) {
  const VectorXd v = calibrated->identified();
  const VectorXd nominal = calibrated->nominal();
  const ExtendedFit fit{
      .model = {v.begin(), v.end()},
      .nominal = std::vector<double>(nominal.begin(), nominal.end()),
      .measured_joints = calibrated->measured_joints,
      .turns = true};
  const ExtendedCommand command(fit, rig());
  const session::Plan read = read_by(rig_of_turns(rig(), command.without_causes()).value());
  expect_reached(extended_plan(read, command, rig()));
  expect_reached(extended_plan(with_other_joints(read), command, rig()));
}

TEST(PlansInAFrameOfTheInstrument, AreReadInTheRigFilesFrameWithTheProbesTurn) {
  PoseSession made = testing::pose_session();
  testing::seen_from(
      made.session, geometry::turned_by<double>(Vector3d(0.3, 0.4, 1.7)),
      Vector3d(1500, -200, 300));
  const CalibrationResult found = calibrate(made.session, {.method = "lm"});
  ASSERT_TRUE(found.frame);
  const geometry::Rig& rig = made.session.rig;
  const auto model = compensation_model(found, rig, CompensateBy::kKinematics);
  const session::Plan read = session::parse_plan(
      "set,point,target_x_mm,target_y_mm,target_z_mm,target_rx_deg,target_ry_deg,"
      "target_rz_deg\nG1,0,-600,-300,400,90,20,10\n",
      "plan.csv", rig_of_turns(rig, model).value());
  const session::PlanPoint& point = read.points.at(0);
  const calibration::ToolTarget there = model.in_frame(target_of(point, rig));
  EXPECT_LT(off_by(rig.robot, model.nominal, point.q, *there.R), 1e-5);
  const auto at = geometry::Tool(rig).position(model.nominal, point.q, rig.robot.assembly);
  ASSERT_TRUE(at);
  EXPECT_LT((*at - there.p_mm).norm(), 1e-3);
  EXPECT_TRUE(near_of(point, model, rig));
}

}  // namespace
}  // namespace sixdial::studies
