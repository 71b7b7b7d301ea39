// Sessions of poses: the turn of the tool is found with the rest, and commanded.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <random>

#include "report/documents/calibration_json.h"
#include "report/documents/compensation_json.h"
#include "report/words/compensation_words.h"
#include "report/words/warning_words.h"
#include "session/sample_layout.h"
#include "studies/calibrate.h"
#include "studies/compensate.h"
#include "studies/extended_command.h"
#include "tests/support/calibrated_poses.h"
#include "tests/support/told.h"

namespace sixdial::studies {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;
using Eigen::VectorXd;
using geometry::kDegPerRad;
using ::testing::HasSubstr;
using testing::PoseSession;

class OfPoses : public testing::CalibratedPoses {
 protected:
  /// x, y, z [mm] and the rotation vector [deg] of the true tool at some joint values.
  static std::vector<double> target_at(const VectorXd& q) {
    const geometry::Pose<double> X = poses->at(q);
    const Vector3d turn_deg = kDegPerRad * geometry::rotation_vector(X.R);
    return {X.p[0], X.p[1], X.p[2], turn_deg[0], turn_deg[1], turn_deg[2]};
  }
};

TEST_F(OfPoses, TheProbesFrameIsRegisteredAndTheRestFitted) {
  const Warning* registered = told(*calibrated->warnings, "tool_turn_registered");
  ASSERT_NE(registered, nullptr);
  EXPECT_GT(std::get<double>(registered->parts.at("turn")), 100.0);
  EXPECT_THAT(
      report::warning_line(*registered), HasSubstr("half of the turns fit the nominal robot"));
  EXPECT_TRUE(is_clean(*calibrated->warnings));
  EXPECT_EQ(calibrated->assessment->space, "poses");
  EXPECT_EQ(calibrated->assessment->readings, 360);
  ASSERT_TRUE(calibrated->turn_errors);
  ASSERT_EQ(calibrated->turn_errors->size(), 2U);
  const TurnErrors& g2 = calibrated->turn_errors->at(1);
  EXPECT_EQ(g2.set, "G2");
  EXPECT_EQ(g2.poses, 30);
  EXPECT_GT(g2.before_mean_rad, 5e-4);
  // Three parts of 4e-5 rad: their length is 6.4e-5 rad in the mean.
  EXPECT_LT(g2.mean_rad, 1e-4);
  EXPECT_GT(g2.mean_rad, 4e-5);
  EXPECT_LT(calibrated->method("lm")->g2->mean_mm, 0.05);
}

TEST_F(OfPoses, ParametersAreTheTrueOnesWithinTheirDeviations) {
  int told_of = 0;
  for (std::size_t i = 0; i < calibrated->parameters.size(); ++i) {
    const ParameterRow& row = calibrated->parameters[i];
    if (row.fixed || row.partly_held) continue;
    ++told_of;
    EXPECT_LT(
        std::abs(row.identified - poses->truth[static_cast<Eigen::Index>(i)]), 4.5 * row.sd)
        << row.name;
  }
  EXPECT_GT(told_of, 20);
}

TEST_F(OfPoses, PlaceAndTurnAreReachedAsWellAsIsSaid) {
  const auto model =
      compensation_model(*calibrated, poses->session.rig, CompensateBy::kKinematics);
  const auto nominal =
      compensation_model(*calibrated, poses->session.rig, CompensateBy::kBefore);
  std::mt19937_64 random(9);
  constexpr int kTargets = 20;
  double place = 0.0, said_place = 0.0, turn = 0.0, said_turn = 0.0, before = 0.0;
  for (int i = 0; i < kTargets; ++i) {
    const std::vector<double> figures = target_at(testing::any_open_joints(random));
    const GivenTarget given = given_target(poses->session, figures);
    ASSERT_TRUE(given.turn);
    const CommandedTarget at =
        compensated_target(model, CompensateBy::kKinematics, given, geometry::WorkingMode(0));
    EXPECT_LT(at.closure_mm, 1e-8);
    ASSERT_TRUE(at.closure_rad);
    EXPECT_LT(*at.closure_rad, 1e-10);
    const auto known = target_uncertainty(*calibrated, poses->session.rig, at);
    ASSERT_TRUE(known && known->turn_sd_rad);
    const VectorXd q = Eigen::Map<const VectorXd>(at.theta_rad.data(), 6);
    const geometry::Pose<double> there = poses->at(q);
    place += (there.p - given.p_mm).squaredNorm() / kTargets;
    said_place += std::pow(known->position_sd_mm, 2) / kTargets;
    turn += std::pow(geometry::turn_between(there.R, *given.target().R), 2) / kTargets;
    said_turn += std::pow(*known->turn_sd_rad, 2) / kTargets;
    const CommandedTarget plain =
        compensated_target(nominal, CompensateBy::kBefore, given, geometry::WorkingMode(0));
    EXPECT_FALSE(target_uncertainty(*calibrated, poses->session.rig, plain));
    const VectorXd q_plain = Eigen::Map<const VectorXd>(plain.theta_rad.data(), 6);
    before += (poses->at(q_plain).p - given.p_mm).squaredNorm() / kTargets;
  }
  EXPECT_GT(std::sqrt(before), 0.5);
  EXPECT_LT(std::sqrt(place), 0.05);
  EXPECT_LT(std::sqrt(turn), 1e-4);
  // One session's parameters are off all together: a factor, not a percent.
  EXPECT_LT(place, 6.0 * said_place);
  EXPECT_GT(place, said_place / 30.0);
  EXPECT_LT(turn, 6.0 * said_turn);
  EXPECT_GT(turn, said_turn / 30.0);
}

TEST_F(OfPoses, AnglesMeanWhatTheRigFileSays) {
  session::Session session = poses->session;
  session.rig.instrument.orientation = "intrinsic zyx";
  const GivenTarget given = given_target(session, {500, 200, 300, 90, 20, -30});
  Matrix3d R = Matrix3d::Identity();
  geometry::turn_about<double>(R, 2, 90.0 / kDegPerRad);
  geometry::turn_about<double>(R, 1, 20.0 / kDegPerRad);
  geometry::turn_about<double>(R, 0, -30.0 / kDegPerRad);
  EXPECT_LT(geometry::turn_between(R, *given.target().R), 1e-9);
  EXPECT_EQ(given.turn->orientation, "intrinsic zyx");
}

TEST_F(OfPoses, ThreeFiguresLeaveTheToolTurnedAsItComes) {
  const auto model =
      compensation_model(*calibrated, poses->session.rig, CompensateBy::kKinematics);
  std::mt19937_64 random(4);
  std::vector<double> figures = target_at(testing::any_open_joints(random));
  figures.resize(3);
  const CommandedTarget at = compensated_target(
      model, CompensateBy::kKinematics, given_target(poses->session, figures),
      geometry::WorkingMode(0));
  EXPECT_FALSE(at.turn || at.closure_rad);
  const VectorXd q = Eigen::Map<const VectorXd>(at.theta_rad.data(), 6);
  EXPECT_LT((poses->at(q).p - at.target_mm).norm(), 0.1);
  const auto known = target_uncertainty(*calibrated, poses->session.rig, at);
  ASSERT_TRUE(known);
  EXPECT_FALSE(known->turn_sd_rad);
}

TEST_F(OfPoses, APlansTurnsAreCommandedNearItsJointValues) {
  std::mt19937_64 random(21);
  session::Plan plan;
  for (int i = 0; i < 4; ++i) {
    const VectorXd q = testing::any_open_joints(random);
    const std::vector<double> figures = target_at(q);
    session::PlanPoint point;
    point.set = "G1";
    point.point = i;
    point.target_mm = Vector3d(figures.data());
    point.target_turn_rad = Vector3d(figures.data() + 3) / kDegPerRad;
    point.q = q;
    point.q[5] += 0.01;
    plan.points.push_back(point);
  }
  const geometry::Rig& rig = poses->session.rig;
  const session::Plan read =
      session::parse_plan(session::plan_csv(plan, session::layout_of(rig)), "plan.csv", rig);
  check_commands_turns(poses->session, read);
  const auto model = compensation_model(*calibrated, rig, CompensateBy::kKinematics);
  const session::Plan commanded = compensated_plan(read, model, rig);
  for (std::size_t i = 0; i < 4; ++i) {
    const geometry::Pose<double> there = poses->at(commanded.points[i].q);
    const Vector3d turn = *plan.points[i].target_turn_rad;
    EXPECT_LT((there.p - plan.points[i].target_mm).norm(), 0.1);
    EXPECT_LT(geometry::turn_between(there.R, geometry::turned_by<double>(turn)), 2e-4);
    EXPECT_LT((commanded.points[i].q - plan.points[i].q).norm(), 0.05);
    EXPECT_EQ(commanded.points[i].target_turn_rad, read.points[i].target_turn_rad);
  }
}

/// A cause at joint 2 beside the calibrated arm, as a diagnosis would hand it over.
ExtendedFit with_gain_at_joint_2(const CalibrationResult& found, double gain) {
  const VectorXd v = found.identified();
  ExtendedFit fit{.model = {v.begin(), v.end()}};
  if (gain != 0.0) fit.effects.push_back({.id = {"joint_gain", "joint2"}, .x = {gain}});
  const VectorXd nominal = found.nominal();
  fit.nominal = std::vector<double>(nominal.begin(), nominal.end());
  fit.measured_joints = found.measured_joints;
  const Eigen::Index n = v.size();
  const Eigen::Index all = n + (gain != 0.0 ? 1 : 0);
  fit.covariance = Eigen::MatrixXd::Zero(all, all);
  fit.covariance->topLeftCorner(n, n) = found.identification.covariance;
  if (all > n) (*fit.covariance)(n, n) = 1e-8;
  return fit;
}

TEST_F(OfPoses, CausesMoveAndTurnTheCommand) {
  const geometry::Rig& rig = poses->session.rig;
  constexpr double kGain = 2e-3;
  const ExtendedCommand command(with_gain_at_joint_2(*calibrated, kGain), rig);
  std::mt19937_64 random(17);
  for (int i = 0; i < 5; ++i) {
    const GivenTarget given =
        given_target(poses->session, target_at(testing::any_open_joints(random)));
    const auto found = command.solve(given.target(), geometry::WorkingMode(0), {});
    ASSERT_TRUE(found) << found.error().message;
    // The joint that is told q stands at q (1 + gain): the calibrated arm is at the target
    // there.
    VectorXd stands = found->q;
    stands[1] *= 1.0 + kGain;
    std::vector<geometry::Pose<double>> X(rig.robot.model->frames.size());
    ASSERT_TRUE(
        rig.robot.model->forward(calibrated->identified(), stands, rig.robot.assembly, X));
    EXPECT_LT((X[0].p - given.p_mm).norm(), 1e-6);
    EXPECT_LT(geometry::turn_between(X[0].R, *given.target().R), 1e-8);
  }
}

TEST_F(OfPoses, AnExtendedModelKnowsItsTargetsByTheSameLaw) {
  const geometry::Rig& rig = poses->session.rig;
  std::mt19937_64 random(18);
  const GivenTarget given =
      given_target(poses->session, target_at(testing::any_open_joints(random)));
  const auto uncertainty = [&](const ExtendedFit& fit) {
    const ExtendedCommand command(fit, rig);
    const auto found = command.solve(given.target(), geometry::WorkingMode(0), {});
    return command
        .uncertainty(
            commanded_target(
                found, CompensateBy::kExtended, given, geometry::WorkingMode(0),
                *rig.robot.model),
            {})
        .value();
  };
  const TargetUncertainty alone = uncertainty(with_gain_at_joint_2(*calibrated, 0.0));
  CalibrationResult plain = *calibrated;
  plain.assessment.reset();  // without what it says of smooth errors
  const auto model = compensation_model(plain, rig, CompensateBy::kKinematics);
  const auto same = target_uncertainty(
      plain, rig,
      compensated_target(model, CompensateBy::kKinematics, given, geometry::WorkingMode(0)));
  ASSERT_TRUE(same);
  EXPECT_LT(std::abs(alone.position_sd_mm / same->position_sd_mm - 1.0), 1e-4);
  EXPECT_LT(std::abs(*alone.turn_sd_rad / *same->turn_sd_rad - 1.0), 1e-4);
  // A gain that is known to 1e-4 only: the place is less well known.
  const TargetUncertainty with_cause = uncertainty(with_gain_at_joint_2(*calibrated, 1e-3));
  EXPECT_GT(with_cause.position_sd_mm, 1.2 * alone.position_sd_mm);
  ExtendedFit early = with_gain_at_joint_2(*calibrated, 1e-3);
  early.covariance.reset();
  const ExtendedCommand command(early, rig);
  const auto found = command.solve(given.target(), geometry::WorkingMode(0), {});
  EXPECT_FALSE(command.uncertainty(
      commanded_target(
          found, CompensateBy::kExtended, given, geometry::WorkingMode(0), *rig.robot.model),
      {}));
}

TEST_F(OfPoses, DocumentAndWordsSayBothWithTheirUnits) {
  const auto model =
      compensation_model(*calibrated, poses->session.rig, CompensateBy::kKinematics);
  std::mt19937_64 random(2);
  const GivenTarget given =
      given_target(poses->session, target_at(testing::any_open_joints(random)));
  CommandedTarget at =
      compensated_target(model, CompensateBy::kKinematics, given, geometry::WorkingMode(0));
  at.uncertainty = target_uncertainty(*calibrated, poses->session.rig, at);
  const Json json = report::to_json(at);
  EXPECT_EQ(json["turn"]["orientation"], "rotation vector");
  EXPECT_EQ(json["joints"][3], "q4_rad");
  EXPECT_GT(json["uncertainty"]["turn_sd_rad"], 0.0);
  EXPECT_EQ(report::to_json(report::commanded_target_from_json(json)), json);
  const std::string text = report::compensation_text(at);
  EXPECT_THAT(text, HasSubstr("q6 "));
  EXPECT_THAT(text, HasSubstr(") mm turned by ("));
  EXPECT_THAT(text, HasSubstr(") deg, rotation vector"));
  EXPECT_THAT(text, HasSubstr("expanded uncertainty, k = 2"));
  const CalibrationResult again = report::calibration_from_json(report::to_json(*calibrated));
  EXPECT_EQ(again.turn_errors->at(1).mean_rad, calibrated->turn_errors->at(1).mean_rad);
}

/// The message of what is refused.
template <typename Function>
std::string refused(const Function& function) {
  try {
    function();
  } catch (const StudyError& error) {
    return std::string(error.what()) + " " + error.hint();
  }
  return "";
}

TEST_F(OfPoses, ATurnThatNothingTellsOfIsRefusedWithTheReason) {
  const std::vector<double> six{500, 0, 300, 10, 20, 30};
  session::Session positions = poses->session;
  positions.rig.instrument.kind = "position";
  EXPECT_THAT(
      refused([&] { static_cast<void>(given_target(positions, six)); }),
      HasSubstr("kind = \"position\""));
  session::Session delta = poses->session;
  delta.rig.robot.model = geometry::find_robot_kind("linear_delta")->example();
  delta.rig.robot.nominal = delta.rig.robot.model->nominal;
  EXPECT_THAT(
      refused([&] { static_cast<void>(given_target(delta, six)); }),
      HasSubstr("cannot turn its tool any way"));
  const PoseSession point = testing::pose_session({.tool_is_frame = false});
  EXPECT_THAT(
      refused([&] { static_cast<void>(given_target(point.session, six)); }),
      HasSubstr("tool = \"frame\""));
  session::Session lost = poses->session;
  for (session::Sample& sample : lost.samples) {
    session::set_turn(sample, session::layout_of(lost.rig), std::nullopt);
  }
  EXPECT_THAT(
      refused([&] { static_cast<void>(given_target(lost, six)); }),
      HasSubstr("no measured turn of the session is used"));
  EXPECT_THAT(
      refused([&] {
        static_cast<void>(given_target(poses->session, {500, 0}));
      }),
      HasSubstr("x,y,z in mm"));
  EXPECT_THAT(
      refused([&] {
        static_cast<void>(given_target(poses->session, {1, 2, 3, 4, 5}));
      }),
      HasSubstr("5 figures"));
}

TEST(TurnsOfASession, AnglesOfAnotherMeaningAreToldAndNotFitted) {
  PoseSession made = testing::pose_session({.probe_rad = {0.1, 0.2, 0.3}});
  const session::SampleLayout layout = session::layout_of(made.session.rig);
  for (session::Sample& sample : made.session.samples) {
    const Vector3d w = *session::turn_of(sample, layout);
    // Written as turns about z, y and x in turn, read as a rotation vector.
    const Vector3d angles = geometry::turned_by<double>(w).eulerAngles(2, 1, 0);
    session::set_turn(sample, layout, angles);
  }
  const CalibrationResult result = calibrate(made.session, {.method = "lm"});
  const Warning* warning = told(*result.warnings, "turns_fit_nowhere");
  ASSERT_NE(warning, nullptr);
  EXPECT_EQ(std::get<std::string>(warning->parts.at("better")), "intrinsic zyx");
  EXPECT_THAT(report::warning_line(*warning), HasSubstr("orientation = \"intrinsic zyx\""));
  EXPECT_THAT(report::warning_line(*warning), HasSubstr("half of them are off by"));
  EXPECT_FALSE(is_clean(*result.warnings));
  EXPECT_FALSE(result.turn_errors);
  EXPECT_EQ(result.assessment->space, "positions");
  EXPECT_EQ(result.assessment->readings, 3 * result.assessment->samples);
  EXPECT_LT(result.method("lm")->g2->mean_mm, 0.06);  // the positions are as good as ever
}

TEST(TurnsOfASession, ASlipOfOneTurnIsLeftOut) {
  PoseSession made = testing::pose_session();
  const session::SampleLayout layout = session::layout_of(made.session.rig);
  session::set_turn(made.session.samples[7], layout, Vector3d(1.0, -2.0, 0.5));
  const CalibrationResult result = calibrate(made.session, {.method = "lm"});
  const Warning* warning = told(*result.warnings, "far_turn");
  ASSERT_NE(warning, nullptr);
  EXPECT_EQ(warning->where.rows, 1);
  EXPECT_EQ(result.turn_errors->at(0).poses, 59);
  EXPECT_LT(result.turn_errors->at(1).mean_rad, 1e-4);
}

TEST(TurnsOfASession, ATrackerThatStandsElsewhereHasItsTurnsInItsOwnFrame) {
  PoseSession made = testing::pose_session();
  // The instrument's frame is turned by 100 degrees and stands a metre and a half away.
  testing::seen_from(
      made.session, geometry::turned_by<double>(Vector3d(0.3, 0.4, 1.7)),
      Vector3d(1500, -200, 300));
  const CalibrationResult result = calibrate(made.session, {.method = "lm"});
  ASSERT_TRUE(result.frame);
  EXPECT_LT(result.turn_errors->at(1).mean_rad, 1e-4);
  // Targets are meant in the rig file's frame, turns as well.
  const geometry::Pose<double> X = made.at(testing::open_joints());
  const Vector3d turn_deg = kDegPerRad * geometry::rotation_vector(X.R);
  const GivenTarget given = given_target(
      made.session, {X.p[0], X.p[1], X.p[2], turn_deg[0], turn_deg[1], turn_deg[2]});
  const auto model = compensation_model(result, made.session.rig, CompensateBy::kKinematics);
  const CommandedTarget at =
      compensated_target(model, CompensateBy::kKinematics, given, geometry::WorkingMode(0));
  const VectorXd there = Eigen::Map<const VectorXd>(at.theta_rad.data(), 6);
  // The frame was found from the nominal robot: as good as that is.
  EXPECT_LT((made.at(there).p - X.p).norm(), 10.0);
  EXPECT_LT(geometry::turn_between(made.at(there).R, X.R), 0.02);
}

TEST(TurnsOfASession, GoBackToTheRigFilesFrameWithTheirPositions) {
  PoseSession made = testing::pose_session();
  const session::Session filed = made.session;
  testing::seen_from(
      made.session, geometry::turned_by<double>(Vector3d(0.3, 0.4, 1.7)),
      Vector3d(1500, -200, 300));
  const PlausibleSession judged = plausible(made.session);
  ASSERT_TRUE(judged.frame);
  const session::Session back = in_rig_frame(judged, made.session.rig);
  const session::SampleLayout layout = session::layout_of(made.session.rig);
  for (std::size_t i = 0; i < back.samples.size(); ++i) {
    const auto R = [&](const session::Session& of) {
      return geometry::turned_by<double>(*session::turn_of(of.samples[i], layout));
    };
    // As far as the nominal robot is from the true one.
    EXPECT_LT(geometry::turn_between(R(back), R(filed)), 0.02);
    EXPECT_LT(
        (*session::position_of(back.samples[i], 0) - *session::position_of(filed.samples[i], 0))
            .norm(),
        20.0);
  }
}

TEST(TurnsOfASession, AToolThatIsAPointIsCalibratedByItsPositions) {
  const PoseSession made = testing::pose_session({.tool_is_frame = false});
  const CalibrationResult result = calibrate(made.session, {.method = "lm"});
  EXPECT_NE(told(*result.warnings, "turns_not_explained"), nullptr);
  EXPECT_TRUE(is_clean(*result.warnings));
  EXPECT_EQ(result.assessment->space, "positions");
  EXPECT_FALSE(result.turn_errors);
  EXPECT_LT(result.method("lm")->g2->mean_mm, 0.06);
}

}  // namespace
}  // namespace sixdial::studies
