// The model that is given to other programs is the one that commands: of a calibration, of a
// diagnosis with its causes, of an arm that sags under its weight.
#include "studies/exported_model.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "studies/calibrate.h"
#include "studies/compensate.h"
#include "studies/extended_command.h"
#include "tests/simulation/law_rigs.h"
#include "tests/studies/diagnosis_parts.h"

namespace sixdial::studies {
namespace {

constexpr double kSame_mm = 1e-12;

TEST(ExportedModel, OfACalibrationIsTheRobotThatItCommandsBy) {
  const session::Session session = session_of("00");
  const CalibrationResult result = calibrate(session, {.method = "lm+gp"});
  const ExportedModel model = exported_model(result, session);
  const auto kinematics = compensation_model(result, session.rig, CompensateBy::kKinematics);
  const auto full = compensation_model(result, session.rig, CompensateBy::kFull);
  EXPECT_EQ(model.inputs.data_hash, result.inputs.data_hash);
  EXPECT_GT(model.poses.size(), 100U);
  double learned_mm = 0.0;
  for (const ModelPose& pose : model.poses) {
    const auto ours = tool_pose(model, pose);
    const auto plain = calibration::modelled_position(kinematics, pose.q, pose.assembly);
    const auto more = calibration::modelled_position(full, pose.q, pose.assembly);
    ASSERT_TRUE(ours && plain && more);
    EXPECT_LT((ours->p.head<2>() - *plain).norm(), kSame_mm);
    learned_mm += (*more - *plain).norm() / static_cast<double>(model.poses.size());
  }
  EXPECT_EQ(model.learned_by, "gp");
  EXPECT_NEAR(learned_part(model).mean_mm, learned_mm, kSame_mm);
}

TEST(ExportedModel, OfADiagnosisIsTheModelThatItCommandsBy) {
  const session::Session session = session_of("01");
  const DiagnosisResult result = quick_result(session);
  const ExportedModel model = exported_model(result, session);
  ASSERT_EQ(model.effects.size(), 1U);
  const ExtendedCommand command(result.extended_fit, session.rig);
  for (const int side : {-1, 1}) {
    for (const ModelPose& each : model.poses) {
      const std::vector<double> sides(2, side);
      const auto ours = tool_pose(model, commanded_pose(model, each.q, each.assembly, sides));
      const auto theirs = command.position(each.q, each.assembly, {.approach = {side, side}});
      ASSERT_TRUE(ours && theirs);
      ASSERT_LT((ours->p.head<2>() - *theirs).norm(), kSame_mm);
    }
  }
  // Without its one cause it is off by half the backlash's turn.
  ExportedModel without = model;
  without.effects.clear();
  const MissBetween miss = miss_between(model, without);
  EXPECT_GT(miss.mean_mm, 0.005);
  EXPECT_GT(miss.max_mm, miss.mean_mm);
  EXPECT_EQ(miss.poses, static_cast<int>(model.poses.size()));
}

// Commands of an arm know what it weighs at each pose.
TEST(ExportedModel, AnArmThatSagsIsCommandedSo) {
  const geometry::Rig rig = simulation::law_rig(simulation::LawRig::kArm);
  const simulation::Effect* sag = simulation::find_effect("joint_gravity_compliance");
  const simulation::ForwardModel base(rig);
  const simulation::ModelVector nominal = base.nominal();
  ExtendedFit fit{.model = {nominal.begin(), nominal.end()}};
  const ExtendedCommand stiff(fit, rig);
  for (const simulation::Place& place : sag->places(rig)) {
    fit.effects.push_back({.id = {std::string(sag->cause), place.name}, .x = {3e-4, 5e-4}});
  }
  ASSERT_GE(fit.effects.size(), 3U);
  const ExtendedCommand soft(fit, rig);
  Eigen::VectorXd stretched(6);
  stretched << 0.3, 0.1, -0.2, 0.1, 0.4, 0.2;
  const auto high = stiff.position(stretched, geometry::Assembly::kLeft, {});
  const auto low = soft.position(stretched, geometry::Assembly::kLeft, {});
  ASSERT_TRUE(high && low);
  EXPECT_LT(low->z(), high->z() - 0.5);  // [mm]
}

}  // namespace
}  // namespace sixdial::studies
