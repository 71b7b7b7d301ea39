// Place and turn of an arm's tool commanded from the command line, from a folder as a tracker's
// user has it.
#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <fstream>

#include "session/bundle.h"
#include "session/csv.h"
#include "tests/support/command_line.h"
#include "tests/support/paths.h"
#include "tests/support/pose_session.h"
#include "tests/support/rig_for_tests.h"

namespace sixdial::cli {
namespace {

using ::testing::HasSubstr;
using ::testing::Not;
using testing::Outcome;
using testing::sixdial;
using testing::TempDirectory;

class PoseCommand : public ::testing::Test {
 protected:
  PoseCommand() {
    session::write_bundle(made_.session, folder());
    const Outcome calibrated =
        sixdial({"calibrate", folder(), "-q", "--method", "lm", "-o", result()});
    EXPECT_EQ(calibrated.code, 0) << calibrated.err;
    EXPECT_THAT(calibrated.out, HasSubstr("turn of the tool, 30 poses of G2"));
  }
  [[nodiscard]] std::string folder() const { return (directory_.path() / "poses").string(); }
  [[nodiscard]] std::string result() const { return (directory_.path() / "r.json").string(); }
  [[nodiscard]] Outcome compensate(std::vector<std::string> more) const {
    std::vector<std::string> words{"compensate", folder(), "-q", "--calibration", result()};
    if (std::ranges::find(more, "--model") == more.end()) {
      words.insert(words.end(), {"--model", "kinematics"});
    }
    words.insert(words.end(), more.begin(), more.end());
    return sixdial(words);
  }
  /// Two points, the first with a turn.
  [[nodiscard]] std::string plan_with_turns() const {
    const std::string plan = (directory_.path() / "plan.csv").string();
    std::ofstream(plan) << "set,point,target_x_mm,target_y_mm,target_z_mm,target_rx_deg,"
                           "target_ry_deg,target_rz_deg\n"
                           "G1,0,-600,-300,400,90,20,10\nG1,1,-620,-280,410,,,\n";
    return plan;
  }

  TempDirectory directory_;
  testing::PoseSession made_ = testing::pose_session();
  const std::string pose_ = "-600,-300,400,90,20,10";  // within reach, however turned
};

TEST_F(PoseCommand, SixFiguresArePlaceAndTurn) {
  const geometry::Pose<double> X = made_.at(testing::open_joints());
  const Eigen::Vector3d turn_deg = geometry::kDegPerRad * geometry::rotation_vector(X.R);
  const std::string place = fmt::format("{:.6f},{:.6f},{:.6f}", X.p[0], X.p[1], X.p[2]);
  const std::string pose =
      fmt::format("{},{:.6f},{:.6f},{:.6f}", place, turn_deg[0], turn_deg[1], turn_deg[2]);
  const Outcome shown = compensate({"--target", pose});
  ASSERT_EQ(shown.code, 0) << shown.err;
  EXPECT_THAT(shown.out, HasSubstr("deg, rotation vector"));
  EXPECT_THAT(shown.out, HasSubstr("the model knows the place to 0.0"));
  const Outcome json = compensate({"--target", pose, "--json"});
  const std::vector<double> commanded = json.json()["theta_rad"];
  const geometry::Pose<double> there =
      made_.at(Eigen::Map<const Eigen::VectorXd>(commanded.data(), 6));
  EXPECT_LT((there.p - X.p).norm(), 0.1);
  EXPECT_LT(geometry::turn_between(there.R, X.R), 2e-4);
  EXPECT_FALSE(compensate({"--target", place, "--json"}).json().contains("turn"));
}

TEST_F(PoseCommand, APlanWithTurnsComesBackWithThem) {
  const Outcome shown = compensate({"--plan", plan_with_turns()});
  ASSERT_EQ(shown.code, 0) << shown.err;
  EXPECT_THAT(shown.out, HasSubstr("target_rz_deg,q1_rad"));
  EXPECT_THAT(shown.out, HasSubstr("400.000000,90.000000000,20.000000000,10.000000000,"));
  EXPECT_THAT(shown.out, HasSubstr("410.000000,,,,"));
}

TEST_F(PoseCommand, ACalibrationWithoutTurnsCommandsPlacesOnly) {
  Json stored = Json::parse(session::read_file(result()));
  EXPECT_EQ(stored.erase("turn_errors"), 1U);  // as of a version that fitted positions only
  const std::string early = (directory_.path() / "early.json").string();
  session::write_file(early, stored.dump());
  const auto by = [&](const std::string& model, std::vector<std::string> more) {
    more.insert(
        more.begin(), {"compensate", folder(), "-q", "--calibration", early, "--model", model});
    return sixdial(more);
  };
  for (const Outcome& refused :
       {by("kinematics", {"--target", pose_}), by("full", {"--target", pose_}),
        by("kinematics", {"--plan", plan_with_turns()}), by("before", {"--target", pose_}),
        by("before", {"--plan", plan_with_turns()})}) {
    EXPECT_EQ(refused.code, 5);
    EXPECT_THAT(refused.err, HasSubstr("the calibration was made without turns of the tool"));
    EXPECT_THAT(refused.err, HasSubstr("sixdial calibrate SESSION"));
  }
  EXPECT_EQ(by("kinematics", {"--target", "-600,-300,400"}).code, 0);
}

TEST_F(PoseCommand, TheNominalRobotOfACalibrationWithTurnsTurnsTheProbe) {
  const Outcome by_nominal = compensate({"--model", "before", "--target", pose_, "--json"});
  ASSERT_EQ(by_nominal.code, 0) << by_nominal.err;
  const std::vector<double> q = by_nominal.json()["theta_rad"];
  const geometry::Pose<double> there = made_.at(Eigen::Map<const Eigen::VectorXd>(q.data(), 6));
  const Eigen::Vector3d asked = geometry::kRadPerDeg * Eigen::Vector3d(90, 20, 10);
  EXPECT_LT(geometry::turn_between(there.R, geometry::turned_by<double>(asked)), 0.05);
}

TEST_F(PoseCommand, ADiagnosisWithoutTurnsCommandsPlacesOnly) {
  const std::string file = (directory_.path() / "d.json").string();
  const Outcome diagnosed =
      sixdial({"diagnose", folder(), "-q", "--bootstrap", "0", "--no-gain", "-o", file});
  ASSERT_EQ(diagnosed.code, 0) << diagnosed.err;
  const auto extended = [&](const std::string& of, std::vector<std::string> more) {
    more.insert(
        more.begin(),
        {"compensate", folder(), "-q", "--diagnosis-file", of, "--model", "extended"});
    return sixdial(more);
  };
  const Outcome shown = extended(file, {"--target", pose_});
  ASSERT_EQ(shown.code, 0) << shown.err;
  EXPECT_THAT(shown.out, HasSubstr("deg, rotation vector"));
  Json stored = Json::parse(session::read_file(file));
  EXPECT_EQ(stored["extended_model"]["turns"], true);
  const std::string early = (directory_.path() / "early.json").string();
  for (const bool said : {false, true}) {
    stored["extended_model"].erase("turns");
    if (said) stored["extended_model"]["turns"] = false;
    session::write_file(early, stored.dump());
    for (const Outcome& refused :
         {extended(early, {"--target", pose_}),
          extended(early, {"--plan", plan_with_turns()})}) {
      EXPECT_EQ(refused.code, 5);
      EXPECT_THAT(refused.err, HasSubstr("the diagnosis was made without turns of the tool"));
    }
  }
  EXPECT_EQ(extended(early, {"--target", "-600,-300,400"}).code, 0);
}

TEST_F(PoseCommand, WhatCannotBeIsSaid) {
  const Outcome five = compensate({"--target", "1,2,3,4,5"});
  EXPECT_EQ(five.code, 2);
  EXPECT_THAT(five.err, HasSubstr("x,y,z,rx,ry,rz"));
  const Outcome word = compensate({"--target", "1,zwei,3"});
  EXPECT_EQ(word.code, 2);
  EXPECT_THAT(word.err, HasSubstr("'zwei'"));
  const Outcome side = compensate({"--target", "1,2,3", "--approach", "1,2"});
  EXPECT_EQ(side.code, 2);
  const std::string bundle = test_paths::test_data() + std::string("/sessions/00");
  const Outcome plane = sixdial(
      {"compensate", bundle, "-q", "--calibration-method", "lm", "--target", "28,48,0,0,0,0"});
  EXPECT_NE(plane.code, 0);
  EXPECT_THAT(plane.err, HasSubstr("cannot turn its tool any way"));
}

TEST_F(PoseCommand, WhatCannotBeIsSaidBeforeAnythingIsFitted) {
  const std::string bundle = test_paths::test_data() + std::string("/sessions/00");
  for (const char* const model : {"recommended", "extended", "kinematics"}) {
    const Outcome sides = sixdial(
        {"compensate", bundle, "--model", model, "--target", "28,48", "--approach",
         "1,-1,1,1"});
    EXPECT_EQ(sides.code, 2);
    EXPECT_THAT(sides.err, HasSubstr("given for joint 4; this robot has 2 joints"));
    EXPECT_THAT(sides.err, Not(HasSubstr("making the ")));
    const Outcome plane =
        sixdial({"compensate", bundle, "--model", model, "--target", "1,2,3"});
    EXPECT_EQ(plane.code, 2);
    EXPECT_THAT(plane.err, HasSubstr("works in the plane"));
    EXPECT_THAT(plane.err, Not(HasSubstr("making the ")));
  }
  const std::string plan = (directory_.path() / "turned.csv").string();
  std::ofstream(plan) << "set,point,target_x_mm,target_y_mm,target_rx_deg\nG1,0,28,48,5\n";
  const Outcome planned = sixdial({"compensate", bundle, "--plan", plan});
  EXPECT_NE(planned.code, 0);
  EXPECT_THAT(planned.err, HasSubstr("measures no turn of the tool"));
  EXPECT_THAT(planned.err, Not(HasSubstr("making the ")));
  const Outcome fewer = compensate({"--target", "-600,-300,400", "--approach", "1,0"});
  EXPECT_EQ(fewer.code, 0) << fewer.err;
}

}  // namespace
}  // namespace sixdial::cli
