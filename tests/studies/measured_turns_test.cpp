// What becomes of measured turns of a tool: where the probe's frame sits, turns that slipped,
// what is said of them.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <memory>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "geometry/units.h"
#include "report/words/calibration_words.h"
#include "report/words/warning_words.h"
#include "session/sample_layout.h"
#include "session/trials.h"
#include "studies/calibrate.h"
#include "studies/compensate.h"
#include "studies/plausibility.h"
#include "studies/plausibility_of_fit.h"
#include "studies/slipped_turns.h"
#include "tests/support/pose_session.h"
#include "tests/support/told.h"

namespace sixdial::studies {
namespace {

using Eigen::Vector3d;
using Eigen::VectorXd;
using ::testing::HasSubstr;
using testing::PoseSession;

/// The turn of one sample is another one by `off_deg` about an axis that lies anyhow.
void slip(session::Session& session, std::size_t row, double off_deg) {
  const session::SampleLayout layout = session::layout_of(session.rig);
  session::Sample& sample = session.samples[row];
  const Vector3d off = geometry::kRadPerDeg * off_deg * Vector3d(0.6, -0.48, 0.64);
  const Eigen::Matrix3d R =
      geometry::turned_by<double>(off) * geometry::turned_by<double>(*turn_of(sample, layout));
  session::set_turn(sample, layout, geometry::rotation_vector(R));
}

TEST(TheProbesFrame, IsATurnOfTheToolAndOfNoLinkWhereTheLastJointRests) {
  // A turn of link 5 about x then turns the tool as its own frame does: neither is told apart
  // by these poses, and the file is right about the link.
  const PoseSession made = testing::pose_session({.off = 0.0, .last_joint_rests = true});
  const geometry::Robot& filed = made.session.rig.robot;
  const PlausibleSession judged = plausible(made.session);
  ASSERT_NE(told(judged.warnings, "tool_turn_registered"), nullptr);
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
  EXPECT_EQ(told(*result.warnings, "far_angle"), nullptr);
  EXPECT_LT(result.method("lm")->g2->mean_mm, 0.06);
  EXPECT_LT(result.turn_errors->at(1).mean_rad, 1e-4);
}

/// An arm whose parameters turn its tool's frame by half a radian about each axis at most.
struct NarrowTool {
  static VectorXd limited(
      const geometry::RobotModel& robot, std::span<const double> v, VectorXd* slope = nullptr) {
    constexpr double kMost_rad = 0.5;
    VectorXd to = Eigen::Map<const VectorXd>(v.data(), std::ssize(v));
    if (slope != nullptr) slope->setOnes(to.size());
    for (const char* const name : {"tool_rx", "tool_ry", "tool_rz"}) {
      const auto found = robot.find_parameter(name);
      EXPECT_TRUE(found) << name;
      if (!found) continue;
      const double part = std::tanh(to[*found] / kMost_rad);
      to[*found] = kMost_rad * part;
      if (slope != nullptr) (*slope)[*found] = 1.0 - part * part;
    }
    return to;
  }
  static geometry::Reached forward(
      const geometry::RobotModel& robot, std::span<const double> v, std::span<const double> q,
      geometry::Assembly assembly, std::span<geometry::Pose<double>> X) {
    const VectorXd to = limited(robot, v);
    return geometry::serial.forward(
        robot, std::span<const double>(to.data(), v.size()), q, assembly, X);
  }
  static geometry::Reached derivative(
      const geometry::RobotModel& robot, std::span<const double> v, std::span<const double> q,
      geometry::Assembly assembly, geometry::Frames& at) {
    VectorXd slope;
    const VectorXd to = limited(robot, v, &slope);
    const auto reached = geometry::serial.forward_derivative(
        robot, std::span<const double>(to.data(), v.size()), q, assembly, at);
    for (auto& by_v : at.by_v) by_v = by_v * slope.asDiagonal();
    return reached;
  }
};

TEST(TheProbesFrame, ThatNoParametersReachIsADoubt) {
  static const geometry::RobotKind narrow = [] {
    geometry::RobotKind kind = geometry::serial;
    kind.name = "narrow";
    kind.forward = NarrowTool::forward;
    kind.forward_derivative = NarrowTool::derivative;
    return kind;
  }();
  for (const double probe_rad : {0.2, 1.9}) {
    PoseSession made = testing::pose_session({.probe_rad = {0.0, 0.1, probe_rad}});
    geometry::Robot& robot = made.session.rig.robot;
    geometry::RobotModel model = *robot.model;
    model.kind = &narrow;
    robot.model = std::make_shared<geometry::RobotModel>(std::move(model));
    const PlausibleSession judged = plausible(made.session);
    const Warning* warning = told(judged.warnings, "tool_turn_not_set");
    EXPECT_EQ(warning != nullptr, probe_rad > 1.0);
    EXPECT_EQ(told(judged.warnings, "tool_turn_registered") != nullptr, probe_rad < 1.0);
    EXPECT_EQ(is_clean(judged.warnings), probe_rad < 1.0);
    if (warning == nullptr) continue;
    EXPECT_LT(std::abs(std::get<double>(warning->parts.at("turn")) - 109.0), 1.0);
    EXPECT_THAT(report::warning_line(*warning), HasSubstr("cannot be set to that"));
    EXPECT_EQ(judged.session.rig.robot.nominal, robot.nominal);
    // Nor is a turn commanded by that nominal robot.
    CalibrationResult result;
    result.turn_errors = {TurnErrors{}};
    for (const bool stored : {true, false}) {
      if (stored)
        result.warnings = judged.warnings;
      else
        result.warnings.reset();
      EXPECT_THROW(check_knows_turns(result, CompensateBy::kBefore, made.session), StudyError);
    }
  }
}

TEST(SlippedTurns, OfTwoDegreesIsLeftOutAndBendsNothing) {
  PoseSession made = testing::pose_session();
  slip(made.session, 7, 2.0);
  const CalibrationResult result = calibrate(made.session, {.method = "lm"});
  const Warning* warning = told(*result.warnings, "slipped_turn");
  ASSERT_NE(warning, nullptr);
  EXPECT_EQ(warning->where.rows, 1);
  EXPECT_EQ(warning->where.named.at(0).point, 7);
  EXPECT_LT(std::abs(std::get<double>(warning->parts.at("most")) - 2.0), 0.02);
  EXPECT_THAT(
      report::warning_line(*warning), HasSubstr("1 turn of the tool in G1 is off by up to 2 "));
  EXPECT_TRUE(is_clean(*result.warnings));
  EXPECT_EQ(result.assessment->readings, 60 * 6 - 3);  // its position counts
  EXPECT_EQ(result.turn_errors->at(0).poses, 59);
  EXPECT_LT(result.turn_errors->at(1).mean_rad, 1e-4);
  for (std::size_t i = 0; i < result.parameters.size(); ++i) {
    const ParameterRow& row = result.parameters[i];
    if (row.fixed || row.partly_held) continue;
    EXPECT_LT(std::abs(row.identified - made.truth[static_cast<Eigen::Index>(i)]), 4.5 * row.sd)
        << row.name;
  }
}

TEST(SlippedTurns, AreFoundBesideEachOtherAndNoneWhereNoneIs) {
  PoseSession made = testing::pose_session();
  const CalibrationResult right = calibrate(made.session, {.method = "lm"});
  EXPECT_EQ(told(*right.warnings, "slipped_turn"), nullptr);
  EXPECT_EQ(right.turn_errors->at(0).poses, 60);
  const std::string line = report::turn_lines(right).at(0);
  EXPECT_THAT(line, HasSubstr("60 poses of G1: off by"));
  EXPECT_THAT(line, HasSubstr("deg before (the frame of the tool was found first), 0.0"));
  const std::vector<double> off_deg{0.1, 3.0, 0.4, 3.0, 1.0};
  for (std::size_t i = 0; i < off_deg.size(); ++i) slip(made.session, 11 * i, off_deg[i]);
  const CalibrationResult result = calibrate(made.session, {.method = "lm"});
  const Warning* warning = told(*result.warnings, "slipped_turn");
  ASSERT_NE(warning, nullptr);
  EXPECT_EQ(warning->where.rows, 5);
  EXPECT_EQ(result.turn_errors->at(0).poses, 55);
  const CalibrationResult kept =
      calibrate(made.session, {.method = "lm", .keep_gross_errors = true});
  EXPECT_EQ(told(*kept.warnings, "slipped_turn"), nullptr);
  EXPECT_EQ(kept.turn_errors->at(0).poses, 60);
  EXPECT_GT(kept.turn_errors->at(1).mean_rad, 3.0 * result.turn_errors->at(1).mean_rad);
}

TEST(SlippedTurns, ThatAreNoAccidentsAreADoubt) {
  PoseSession made = testing::pose_session();
  for (std::size_t row = 0; row < 60; row += 4) slip(made.session, row, 2.0);
  const CalibrationResult result = calibrate(made.session, {.method = "lm"});
  const Warning* warning = told(*result.warnings, "slipped_turns");
  ASSERT_NE(warning, nullptr);
  EXPECT_GT(warning->where.rows, 9);
  EXPECT_FALSE(is_clean(*result.warnings));
  EXPECT_EQ(result.turn_errors->at(0).poses, 60);
}

TEST(SlippedTurns, ThatAreTwoOfSixAreNoAccidents) {
  PoseSession made = testing::pose_session({.g1 = 40});
  const session::SampleLayout layout = session::layout_of(made.session.rig);
  for (std::size_t row = 6; row < 40; ++row) {
    session::set_turn(made.session.samples[row], layout, std::nullopt);
  }
  PoseSession once = made;
  for (const std::size_t row : {0U, 3U}) slip(made.session, row, 2.0);
  const CalibrationResult result = calibrate(made.session, {.method = "lm"});
  EXPECT_EQ(told(*result.warnings, "slipped_turn"), nullptr);
  ASSERT_NE(told(*result.warnings, "slipped_turns"), nullptr);
  EXPECT_FALSE(is_clean(*result.warnings));
  EXPECT_EQ(result.turn_errors->at(0).poses, 6);
  slip(once.session, 2, 2.0);
  const CalibrationResult single = calibrate(once.session, {.method = "lm"});
  ASSERT_NE(told(*single.warnings, "slipped_turn"), nullptr);
  EXPECT_EQ(single.turn_errors->at(0).poses, 5);
}

TEST(FarTurns, AreAccidentsUpToALimit) {
  EXPECT_TRUE(may_be_accidents(1, 5));
  EXPECT_FALSE(may_be_accidents(1, 4));  // three turns alone are not used either
  EXPECT_FALSE(may_be_accidents(2, 13));
  EXPECT_TRUE(may_be_accidents(2, 14));
  EXPECT_TRUE(may_be_accidents(15, 100));
  EXPECT_FALSE(may_be_accidents(16, 100));
}

TEST(FarTurns, ThatAreNoAccidentsAreADoubtAndStay) {
  // The probe came off after 60 rows, and was put back turned by ten degrees.
  PoseSession made = testing::pose_session({.g1 = 60, .g2 = 40});
  const session::SampleLayout layout = session::layout_of(made.session.rig);
  for (std::size_t row = 60; row < 100; ++row) {
    session::Sample& sample = made.session.samples[row];
    const Vector3d on_flange = 10.0 * geometry::kRadPerDeg * Vector3d(0.6, -0.48, 0.64);
    const Eigen::Matrix3d R = geometry::turned_by<double>(*turn_of(sample, layout)) *
                              geometry::turned_by<double>(on_flange);
    session::set_turn(sample, layout, geometry::rotation_vector(R));
  }
  const PlausibleSession judged = plausible(made.session);
  EXPECT_EQ(told(judged.warnings, "far_turn"), nullptr);
  const Warning* warning = told(judged.warnings, "far_turns");
  ASSERT_NE(warning, nullptr);
  EXPECT_EQ(warning->severity, Severity::kDoubt);
  EXPECT_EQ(warning->where.rows, 40);
  EXPECT_THAT(report::warning_line(*warning), HasSubstr("The probe was moved on the flange"));
  for (const session::Sample& sample : judged.session.samples) {
    EXPECT_TRUE(session::turn_of(sample, layout));
  }
}

TEST(FewTurns, AreNotUsed) {
  PoseSession made = testing::pose_session();
  const session::SampleLayout layout = session::layout_of(made.session.rig);
  for (std::size_t row = 0; row < made.session.samples.size(); ++row) {
    if (row % 30 == 0) continue;
    session::set_turn(made.session.samples[row], layout, std::nullopt);
  }
  const PlausibleSession judged = plausible(made.session);
  const Warning* warning = told(judged.warnings, "few_turns");
  ASSERT_NE(warning, nullptr);
  EXPECT_EQ(warning->where.rows, 3);
  EXPECT_EQ(warning->severity, Severity::kNote);
  EXPECT_THAT(report::warning_line(*warning), HasSubstr("Only 3 turns of the tool were"));
  for (const session::Sample& sample : judged.session.samples) {
    EXPECT_FALSE(session::turn_of(sample, layout));
  }
}

TEST(TurnsOfOneSet, ThatIsNotFittedMakeNoFitOfTurns) {
  PoseSession made = testing::pose_session();
  const session::SampleLayout layout = session::layout_of(made.session.rig);
  for (session::Sample& sample : made.session.samples) {
    if (sample.set == "G1") session::set_turn(sample, layout, std::nullopt);
  }
  const CalibrationResult result = calibrate(made.session, {.method = "lm"});
  EXPECT_EQ(result.assessment->space, "positions");
  EXPECT_EQ(result.turn_errors->at(0).set, "G2");
  ASSERT_EQ(report::turn_lines(result).size(), 1U);
  EXPECT_THAT(
      report::turn_lines(result)[0], HasSubstr("30 poses of G2, not fitted (G1 has none)"));
  EXPECT_LT(result.method("lm")->g2->mean_mm, 0.06);
  try {
    check_knows_turns(result, CompensateBy::kKinematics, made.session);
    FAIL() << "commanded";
  } catch (const StudyError& error) {
    EXPECT_THAT(error.what(), HasSubstr("made without turns"));
  }
  check_knows_turns(result, CompensateBy::kBefore, made.session);
}

TEST(TooFewPoses, CountTheTurnsThatAreFitted) {
  PoseSession made = testing::pose_session();
  const geometry::Rig& rig = made.session.rig;
  const session::SampleLayout layout = session::layout_of(rig);
  const int parameters = rig.robot.model->parameter_count();
  const int with_turns = (parameters + 5 + 5) / 6;
  const int without = (parameters + 5 + 2) / 3;
  ASSERT_LT(with_turns + 2, without);
  const auto needed = [&](int poses) -> int {
    std::vector<simulation::Trial> trials = session::trials_of(made.session, "G1");
    trials.resize(static_cast<std::size_t>(poses));
    const auto few = too_few_poses(trials, rig, parameters);
    return few ? static_cast<int>(std::get<double>(few->parts.at("needed"))) : 0;
  };
  EXPECT_EQ(needed(with_turns), 0);
  EXPECT_EQ(needed(with_turns - 1), with_turns);
  // A fit of positions needs nearly twice as many, and one turn more helps by one pose at most.
  for (std::size_t i = 1; i < made.session.samples.size(); ++i) {
    session::set_turn(made.session.samples[i], layout, std::nullopt);
  }
  EXPECT_GT(needed(with_turns + 1), with_turns + 1);
  session::set_turn(made.session.samples[0], layout, std::nullopt);
  EXPECT_EQ(needed(without), 0);
  EXPECT_EQ(needed(without - 1), without);
}

}  // namespace
}  // namespace sixdial::studies
