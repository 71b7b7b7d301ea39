// What units and frames of measured positions do to a session, and that every study is told:
// drawn variants of each, made by the mock rig.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "geometry/tool.h"
#include "geometry/units.h"
#include "studies/calibrate.h"
#include "studies/compare.h"
#include "studies/compensate.h"
#include "studies/next_plan.h"
#include "tests/studies/drawn_sessions.h"
#include "tests/support/test_arms.h"

namespace sixdial::studies {
namespace {

// ---- Units of positions

TEST(UnitOfPositions, IsNamedAndNothingIsCalibrated) {
  struct Case {
    const char* name;
    double mm;
  };
  for (const Case& unit :
       {Case{"inches", 25.4}, Case{"metres", 1000.0}, Case{"centimetres", 10.0},
        Case{"micrometres", 1e-3}}) {
    for (std::uint64_t seed = 1; seed <= 3; ++seed) {
      const session::Session right = by_positions(seed);
      const auto judged =
          plausible(changed(right, [&](const Vector2d& p) -> Vector2d { return p / unit.mm; }));
      const Warning* warning = told(judged.warnings, "position_unit");
      ASSERT_NE(warning, nullptr) << unit.name << ": " << codes_text(judged.warnings);
      EXPECT_EQ(text_of(*warning, "unit"), unit.name);
      EXPECT_DOUBLE_EQ(figure_of(*warning, "factor"), unit.mm);
      EXPECT_FALSE(is_clean(judged.warnings));
      EXPECT_TRUE(forbids_commands(judged.warnings));
      // What follows is at least of the right size.
      EXPECT_LT(apart_mm(judged.session, right), 1e-9);
    }
  }
}

TEST(UnitOfPositions, OfOneCoordinateAloneIsNamed) {
  for (std::uint64_t seed = 1; seed <= 3; ++seed) {
    const session::Session right = by_positions(seed);
    const auto judged = plausible(changed(right, [](const Vector2d& p) -> Vector2d {
      return {p.x(), p.y() / 25.4};
    }));
    const Warning* warning = told(judged.warnings, "position_unit");
    ASSERT_NE(warning, nullptr) << codes_text(judged.warnings);
    EXPECT_EQ(text_of(*warning, "columns"), "y");
    EXPECT_EQ(text_of(*warning, "unit"), "inches");
    EXPECT_LT(apart_mm(judged.session, right), 1e-9);
  }
}

TEST(UnitOfPositions, AndTheFrameAndTheHandednessAtOnce) {
  Drawn drawn(5);
  for (std::uint64_t seed = 1; seed <= 4; ++seed) {
    const Change frame = rigid(drawn.within(-kPi, kPi), {200.0, -150.0});
    const auto judged = plausible(changed(by_positions(seed), [&](const Vector2d& p) {
      const Vector2d there = frame(p);
      return Vector2d(there.y() / 25.4, there.x() / 25.4);
    }));
    EXPECT_NE(told(judged.warnings, "position_unit"), nullptr) << codes_text(judged.warnings);
    const bool mirrored = told(judged.warnings, "frame_mirrored") != nullptr ||
                          told(judged.warnings, "axis_reversed") != nullptr ||
                          told(judged.warnings, "columns_exchanged") != nullptr;
    EXPECT_TRUE(mirrored) << codes_text(judged.warnings);
  }
}

// ---- Frames

TEST(Frame, IsRegisteredBeforeAnySearchAndTheLinksAreTheSame) {
  Drawn drawn(11);
  for (const double turn_deg : {0.0, 12.0, 90.0, -137.0, 180.0}) {
    const session::Session right = by_positions(7);
    const Vector2d shift(drawn.within(300, 600), drawn.within(-500, -200));
    const session::Session turned =
        changed(right, rigid(turn_deg * geometry::kRadPerDeg, shift));
    const CalibrationRequest request{.method = "lm", .seed = 3, .threads = 1};
    const CalibrationResult before = calibrate(right, request);
    const CalibrationResult after = calibrate(turned, request);
    ASSERT_TRUE(after.warnings);
    const Warning* warning = told(*after.warnings, "frame_registered");
    ASSERT_NE(warning, nullptr) << codes_text(*after.warnings);
    EXPECT_EQ(warning->severity, Severity::kNote);
    EXPECT_NEAR(std::remainder(figure_of(*warning, "turn") - turn_deg, 360.0), 0.0, 2.0);
    EXPECT_NEAR(after.rmse_mm, before.rmse_mm, 1e-6);
    for (std::size_t i = 0; i < before.parameters.size(); ++i) {
      const ParameterRow& here = before.parameters[i];
      const ParameterRow& there = after.parameters[i];
      const bool of_the_base = here.name == "x0" || here.name == "y0" || here.name == "alpha";
      if (of_the_base) continue;
      EXPECT_NEAR(there.identified, here.identified, 1e-4) << here.name << " at " << turn_deg;
      EXPECT_NEAR(there.sd, here.sd, 1e-3 * here.sd + 1e-9) << here.name;
    }
    const double alpha = after.parameters[7].identified - before.parameters[7].identified;
    EXPECT_NEAR(std::remainder(alpha - turn_deg * geometry::kRadPerDeg, 2 * kPi), 0.0, 1e-6);
    // "Before" is the robot's error, not the frame's.
    EXPECT_LT(after.method("before")->g2->mean_mm, 5.0);
  }
}

TEST(Frame, EveryMethodStartsThere) {
  const session::Session turned =
      changed(by_positions(9), rigid(100.0 * geometry::kRadPerDeg, {-250.0, 400.0}));
  const ComparisonResult result = compare(
      turned, {.methods = {"before", "lse", "lm", "ekf", "ekf_dqpso"},
               .seed = 1,
               .threads = 1,
               .qpso1_iterations = 20,
               .qpso2_iterations = 60});
  for (const ComparedRow& row : result.methods) {
    ASSERT_TRUE(row.g2) << row.id;
    EXPECT_LT(row.g2->mean_mm, row.id == "before" ? 5.0 : 0.1) << row.id;
  }
}

TEST(Frame, GrossRowsDoNotTurnIt) {
  Drawn drawn(13);
  for (std::uint64_t seed = 1; seed <= 4; ++seed) {
    session::Session session = changed(by_positions(seed), rigid(2.0, {350.0, -220.0}));
    for (std::size_t i = 0; i < session.samples.size(); i += 6) {
      const Vector2d slip(drawn.within(-300, 300), drawn.within(20, 200));
      const Vector2d at = *session::position_of(session.samples[i], session.rig.dials.size());
      session::set_position(session.samples[i], session.rig.dials.size(), at + slip);
    }
    const auto judged = plausible(session);
    const Warning* warning = told(judged.warnings, "frame_registered");
    ASSERT_NE(warning, nullptr);
    EXPECT_NEAR(figure_of(*warning, "turn"), 2.0 * geometry::kDegPerRad, 2.0);
  }
}

/// Positions of an arm that the program does not know, in a plane or in space.
session::Session of_arm(
    const geometry::RobotKind& kind, int axes, const geometry::Similarity& X) {
  session::Session session;
  session.name = "arm";
  session.rig.robot.model = kind.example();
  session.rig.robot.nominal = session.rig.robot.model->nominal;
  session.rig.robot.assembly =
      static_cast<geometry::Assembly>(session.rig.robot.model->assemblies.front().number);
  session.rig.instrument = {.kind = "position", .sd_mm = 0.003, .dimensions = axes};
  session.rig.dials.clear();
  const geometry::RobotModel& robot = *session.rig.robot.model;
  const geometry::Tool tool(session.rig);
  std::mt19937_64 engine(19);
  std::normal_distribution<double> noise_mm(0.0, 0.003);
  Drawn drawn(23);
  Eigen::VectorXd truth = session.rig.robot.nominal;
  for (Eigen::Index i = 0; i < truth.size(); ++i) {
    truth[i] += drawn.within(-0.4, 0.4) * robot.parameters[static_cast<std::size_t>(i)].change;
  }
  for (int point = 0; point < 120; ++point) {
    session::Sample sample;
    sample.set = point < 80 ? "G1" : "G2";
    sample.point = point;
    sample.q.resize(robot.joint_count());
    for (Eigen::Index i = 0; i < sample.q.size(); ++i) {
      const auto& joint = robot.joints[static_cast<std::size_t>(i)];
      sample.q[i] = drawn.within(joint.low, joint.high);
    }
    Eigen::VectorXd at = X(*tool.position(truth, sample.q, session.rig.robot.assembly));
    for (double& each : at) each += noise_mm(engine);
    session::set_position(sample, 0, at);
    session.samples.push_back(std::move(sample));
  }
  return session;
}

TEST(Frame, OfAnyKindOfRobotInThePlaneAndInSpace) {
  struct Case {
    const geometry::RobotKind& kind;
    int axes;
  };
  for (const Case& each : {Case{geometry::planar_arm(), 2}, Case{geometry::spatial_arm(), 3}}) {
    geometry::Similarity X = geometry::Similarity::identity(each.axes);
    const CalibrationRequest request{.method = "lm", .seed = 3, .threads = 1};
    const CalibrationResult here = calibrate(of_arm(each.kind, each.axes, X), request);
    EXPECT_TRUE(here.warnings->empty()) << codes_text(*here.warnings);
    X.R.topLeftCorner<2, 2>() = Eigen::Rotation2Dd(2.5).toRotationMatrix();
    if (each.axes == 3) {
      X.R = Eigen::AngleAxisd(2.5, Eigen::Vector3d(1, -2, 0.5).normalized()).toRotationMatrix();
    }
    X.t.setConstant(1500.0);
    const CalibrationResult there = calibrate(of_arm(each.kind, each.axes, X), request);
    EXPECT_NE(told(*there.warnings, "frame_registered"), nullptr)
        << codes_text(*there.warnings);
    // Directions that the poses leave open are held elsewhere: second order, a part of the
    // noise.
    EXPECT_NEAR(there.rmse_mm, here.rmse_mm, 0.05 * here.rmse_mm);
    EXPECT_LT(there.method("lm")->g2->mean_mm, 0.02);
    EXPECT_NEAR(
        there.method("before")->g2->mean_mm, here.method("before")->g2->mean_mm,
        here.method("before")->g2->mean_mm);
  }
}

TEST(Frame, OfTheInstrumentsOwnLeavesCommandsAndPlansWhereTheyWere) {
  const session::Session right = by_positions(25);
  const session::Session turned = changed(right, rigid(kPi / 2, {400.0, 100.0}));
  const CalibrationRequest request{.method = "lm", .seed = 1, .threads = 1};
  const auto model = [&](const session::Session& session) {
    return compensation_model(
        calibrate(session, request), session.rig, CompensateBy::kKinematics);
  };
  const Vector2d target(22.0, 36.0);
  const geometry::WorkingMode mode = right.rig.robot.working_mode;
  const auto here = compensated_target(model(right), CompensateBy::kKinematics, target, mode);
  const auto there = compensated_target(model(turned), CompensateBy::kKinematics, target, mode);
  for (std::size_t joint = 0; joint < 2; ++joint) {
    // The frame is where the nominal robot fits it best: a millimetre of 60 mm.
    EXPECT_NEAR(there.theta_rad[joint], here.theta_rad[joint], 0.04);
  }
  const NextPlan plan = next_plan(turned, {.points = 6});
  EXPECT_EQ(plan.figures.samples, next_plan(right, {.points = 6}).figures.samples);
  for (const session::PlanPoint& point : plan.plan.points) {
    EXPECT_GT(point.target_mm.x(), 10.0);
    EXPECT_LT(point.target_mm.x(), 46.0);
    EXPECT_GT(point.target_mm.y(), 24.0);
    EXPECT_LT(point.target_mm.y(), 72.0);
  }
}

TEST(Frame, OfARobotBesideItsPlaceMovesTheBaseAndLeavesTheTargets) {
  // Where the rig file has the base 7 mm beside where it stands.
  session::Session session = by_dials(21);
  session.rig.robot.nominal[*session.rig.robot.model->find_parameter("x0")] += 7.0;
  const auto judged = plausible(session);
  const Warning* warning = told(judged.warnings, "base_registered");
  ASSERT_NE(warning, nullptr) << codes_text(judged.warnings);
  EXPECT_EQ(warning->severity, Severity::kNote);
  EXPECT_FALSE(judged.frame);
  for (std::size_t i = 0; i < session.samples.size(); ++i) {
    EXPECT_EQ(judged.session.samples[i].target_mm, session.samples[i].target_mm);
  }
}

TEST(Frame, ThatIsMirroredIsNamed) {
  Drawn drawn(17);
  for (std::uint64_t seed = 1; seed <= 3; ++seed) {
    const session::Session right = by_positions(seed);
    struct Case {
      const char* code;
      Change change;
    };
    const double turn = drawn.within(0.5, 1.0);
    const std::vector<Case> cases{
        {"columns_exchanged",
         [](const Vector2d& p) -> Vector2d {
           return {p.y(), p.x()};
         }},
        {"axis_reversed",
         [](const Vector2d& p) -> Vector2d {
           return {p.x(), -p.y()};
         }},
        {"axis_reversed",
         [](const Vector2d& p) -> Vector2d {
           return {-p.x(), p.y()};
         }},
        {"frame_mirrored", [&](const Vector2d& p) -> Vector2d {
           return rigid(turn, {100.0, 200.0})({p.x(), -p.y()});
         }}};
    for (const Case& each : cases) {
      const auto judged = plausible(changed(right, each.change));
      const Warning* warning = told(judged.warnings, each.code);
      ASSERT_NE(warning, nullptr) << each.code << ": " << codes_text(judged.warnings);
      EXPECT_TRUE(forbids_commands(judged.warnings));
      EXPECT_LT(figure_of(*warning, "miss"), figure_of(*warning, "now") / 3.0);
    }
  }
}

}  // namespace
}  // namespace sixdial::studies
