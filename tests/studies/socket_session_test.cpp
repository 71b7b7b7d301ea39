// Sessions of a ball in sockets: nothing but joint values and one distance. Calibrated by the
// same study as any other, the arm of the simulation comes out.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cmath>
#include <random>

#include "geometry/tool.h"
#include "mock_devices/arm_in_sockets.h"
#include "report/documents/calibration_json.h"
#include "session/bundle.h"
#include "session/csv.h"
#include "session/plan_sheet.h"
#include "session/rig_file.h"
#include "studies/calibrate.h"
#include "studies/compare.h"
#include "studies/diagnose.h"
#include "studies/socket_plan.h"
#include "tests/support/paths.h"

namespace sixdial::studies {
namespace {

using Eigen::Index;
using Eigen::Vector3d;

class SocketSession : public ::testing::Test {
 protected:
  SocketSession() {
    const geometry::Rig arm = session::parse_rig(
        session::read_file(test_paths::source_dir() + "/examples/sockets/arm.toml"),
        "arm.toml");
    made_ = socket_plan(
        arm, {.at_mm = {Vector3d(260, -90, 40), Vector3d(260, 90, 140)},
              .count = 20,
              .to_judge = 6,
              .distance_mm = 206.0});
    drawn_ = made_.plan;
    seat_again(4);
  }

  /// Another true arm seats the ball by the same plan.
  void seat_again(unsigned seed) {
    world_ = mock_devices::arm_of_rig(made_.rig, seed);
    made_.plan = drawn_;
    std::vector<mock_devices::SocketVisit> visits;
    for (const session::PlanPoint& each : made_.plan.points) {
      visits.push_back({each.socket, each.q});
    }
    const auto read = mock_devices::seated(world_, made_.rig, visits);
    for (std::size_t i = 0; i < read.size(); ++i) made_.plan.points[i].q = read[i];
  }

  [[nodiscard]] session::Session session() const {
    return session::parse_session(
        session::filled_session(made_.plan, made_.rig), "session.csv",
        session::write_rig(made_.rig), "rig.toml", {.name = "monday"});
  }

  /// How far an arm is from the true one over its joints' ranges, root mean square, each where
  /// its own base is: their frames are brought together.
  [[nodiscard]] double off_mm(const Eigen::VectorXd& v) const {
    const geometry::Robot& robot = made_.rig.robot;
    const geometry::Tool tool(made_.rig);
    std::mt19937_64 engine(12);
    std::uniform_real_distribution<double> share(0.0, 1.0);
    constexpr Index kPoses = 200;
    Eigen::Matrix3Xd is(3, kPoses);
    Eigen::Matrix3Xd said(3, kPoses);
    for (Index i = 0; i < kPoses; ++i) {
      Eigen::VectorXd q(robot.model->joint_count());
      for (Index k = 0; k < q.size(); ++k) {
        const auto& joint = robot.model->joints[static_cast<std::size_t>(k)];
        q[k] = joint.low + share(engine) * (joint.high - joint.low);
      }
      is.col(i) = mock_devices::tool_of_arm(world_, q);
      said.col(i) = *tool.position(v, q, robot.assembly);
    }
    const Eigen::Matrix4d X = Eigen::umeyama(said, is, false);
    const Eigen::Matrix3Xd left =
        ((X.topLeftCorner<3, 3>() * said).colwise() + X.topRightCorner<3, 1>()) - is;
    return std::sqrt(left.squaredNorm() / static_cast<double>(kPoses));
  }

  SocketPlan made_;
  session::Plan drawn_;  // before any ball was seated
  mock_devices::ArmWorld world_;
};

TEST_F(SocketSession, IsCalibratedByTheStudyOfAnyOther) {
  const CalibrationResult result = calibrate(session(), {.method = "lm"});
  const MethodRow& before = *result.method("before");
  const MethodRow& after = *result.method("lm");
  EXPECT_GT(before.g2->mean_mm, 1.0);
  // A seat of 0.1 mm in each coordinate, read to 0.0001 degrees.
  EXPECT_LT(after.g2->mean_mm, 0.3);
  EXPECT_EQ(after.g1->points, 40);
  EXPECT_EQ(after.g2->points, 12);
  ASSERT_EQ(std::ssize(result.parameters), made_.rig.robot.nominal.size());
  for (const ParameterRow& row : result.parameters) {
    EXPECT_EQ(row.fixed, row.name.starts_with("base")) << row.name;
  }
  const double promised_mm = made_.figures.stages.at(1).position.mean_mm;
  EXPECT_GT(off_mm(result.nominal()), 1.0);
  EXPECT_LT(off_mm(result.identified()), 2.0 * promised_mm);
  // The sockets' places stand behind the robot's parameters.
  const auto& found = result.assessment->parameters;
  const auto place = std::ranges::find(found, "S2_y", &ParameterRow::name);
  ASSERT_NE(place, found.end());
  EXPECT_LT(std::abs(place->identified - 90.0), 15.0);
  EXPECT_EQ(result.assessment->samples, 40);
  // Each point was measured where its socket is.
  for (const PointResiduals& point : result.points) {
    EXPECT_LT(std::abs(std::abs(point.measured_mm.y()) - 90.0), 15.0);
  }
  const CalibrationResult again = report::calibration_from_json(report::to_json(result));
  EXPECT_EQ(again.parameters.size(), result.parameters.size());
}

TEST_F(SocketSession, ABallThatDidNotSitIsToldAndNotFitted) {
  made_.plan.points[7].q[1] += 0.01;  // three millimetres
  const CalibrationResult result = calibrate(session(), {.method = "lm"});
  ASSERT_TRUE(result.gross_errors);
  ASSERT_EQ(result.gross_errors->found.size(), 1U);
  EXPECT_EQ(result.gross_errors->found[0].sample, 7);
  EXPECT_LT(result.method("lm")->g1->max_mm, 1.0);
}

/// Where the ball is in its socket is the residual itself: a smooth function of the place
/// explained all of it, in every session without any fault.
TEST_F(SocketSession, WithoutAFaultHasNothingThatDependsOnThePlace) {
  for (const unsigned seed : {4U, 5U, 6U}) {
    if (seed != 4U) seat_again(seed);
    const DiagnosisResult result =
        diagnose(session(), {.bootstrap = 0, .with_gain = false, .threads = 1});
    EXPECT_TRUE(result.unexplained.depends_on.empty()) << seed;
    // It had log odds of hundreds, whatever the verdict made of it.
    for (const diagnosis::Dependence& each : result.dependence) {
      EXPECT_NE(each.covariates.front(), "x") << seed;
    }
    for (const FoundCause& each : result.causes) {
      EXPECT_NE(each.standing, Standing::kConfirmed) << seed << ": " << each.id.name();
    }
  }
}

TEST_F(SocketSession, IsComparedToo) {
  const ComparisonResult result = compare(session(), {.methods = {"before", "lm", "tikhonov"}});
  ASSERT_EQ(result.methods.size(), 3U);
  EXPECT_LT(result.methods[1].g2->mean_mm, 0.3);
  EXPECT_NE(result.best, "before");
}

TEST_F(SocketSession, AKnownPlaceTellsWhereTheArmStands) {
  made_.rig.instrument.sockets[0].at_mm = Vector3d(260, -90, 40);
  made_.rig.instrument.sockets[1].at_mm = Vector3d(260, 90, 140);
  made_.rig.instrument.socket_distances.clear();
  const CalibrationResult result = calibrate(session(), {.method = "lm"});
  for (const ParameterRow& row : result.parameters) EXPECT_FALSE(row.fixed) << row.name;
}

}  // namespace
}  // namespace sixdial::studies
