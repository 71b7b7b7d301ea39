// What becomes of measured turns of a tool: where the probe's frame sits, turns that slipped,
// what is said of them.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <string>
#include <vector>

#include "studies/calibrate.h"
#include "studies/plausibility.h"
#include "tests/support/pose_session.h"

namespace sixdial::studies {
namespace {

using Eigen::Vector3d;
using Eigen::VectorXd;
using testing::PoseSession;

bool told(const std::vector<Warning>& warnings, std::string_view code) {
  return std::ranges::find(warnings, code, &Warning::code) != warnings.end();
}

TEST(TheProbesFrame, IsATurnOfTheToolAndOfNoLinkWhereTheLastJointRests) {
  // A turn of link 5 about x then turns the tool as its own frame does: neither is told apart
  // by these poses, and the file is right about the link.
  const PoseSession made = testing::pose_session({.off = 0.0, .last_joint_rests = true});
  const geometry::Robot& filed = made.session.rig.robot;
  const PlausibleSession judged = plausible(made.session);
  ASSERT_TRUE(told(judged.warnings, "tool_turn_registered"));
  const VectorXd& registered = judged.session.rig.robot.nominal;
  double of_tool_rad = 0.0;
  for (Eigen::Index i = 0; i < registered.size(); ++i) {
    const geometry::ParameterInfo& info = filed.model->parameters[static_cast<std::size_t>(i)];
    const double change = std::abs(registered[i] - filed.nominal[i]);
    if (info.name.starts_with("tool_r")) {
      of_tool_rad = std::max(of_tool_rad, change);
    } else {
      EXPECT_LE(change, 1e-6 * info.change) << info.name;
    }
  }
  EXPECT_GT(of_tool_rad, 1.0);
  // What no pose tells stays as the file has it, and no link is called far from the file.
  const CalibrationResult result = calibrate(made.session, {.method = "lm"});
  EXPECT_FALSE(told(*result.warnings, "far_angle"));
  EXPECT_LT(result.method("lm")->g2->mean_mm, 0.06);
  EXPECT_LT(result.turn_errors->at(1).mean_rad, 1e-4);
}

}  // namespace
}  // namespace sixdial::studies
