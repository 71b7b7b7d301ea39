// An arm without any instrument, as a person does it: a plan and its folder, session.csv filled
// in by hand (here by the simulated arm), calibrated, judged.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>

#include "mock_devices/arm_in_sockets.h"
#include "session/csv.h"
#include "session/plan.h"
#include "session/plan_sheet.h"
#include "session/rig_file.h"
#include "tests/support/command_line.h"
#include "tests/support/paths.h"
#include "tests/support/rig_for_tests.h"

namespace sixdial::cli {
namespace {

using testing::Outcome;
using testing::sixdial;
using testing::TempDirectory;

using ::testing::HasSubstr;
using ::testing::Not;

const std::string kArm = test_paths::source_dir() + "/examples/sockets/arm.toml";

class PlanSockets : public ::testing::Test {
 protected:
  std::vector<std::string> plan(std::vector<std::string> more) const {
    std::vector<std::string> words{"plan", "sockets", "--rig", kArm,  "--at", "260",
                                   "-90",  "40",      "--at",  "260", "90",   "40"};
    words.insert(words.end(), more.begin(), more.end());
    return words;
  }
  [[nodiscard]] std::string file(const std::string& name) const {
    return (directory_.path() / name).string();
  }
  TempDirectory directory_;
};

TEST_F(PlanSockets, TellsThePlanTheTablesAndWhatTheyBuy) {
  const Outcome planned =
      sixdial(plan({"--count", "6", "--g2", "2", "--distance", "206", "-o", file("p.csv")}));
  EXPECT_EQ(planned.code, 0) << planned.err;
  EXPECT_THAT(planned.err, HasSubstr("16 points in"));
  EXPECT_THAT(planned.err, HasSubstr("distance_mm = { \"S1\" = 206.0 }"));
  EXPECT_THAT(planned.err, HasSubstr("12 poses of each socket: the tool is known to"));
  EXPECT_THAT(
      session::read_file(file("p.csv")),
      ::testing::StartsWith("set,point,repeat,socket,target_x_mm"));
  const Outcome json = sixdial(plan({"--count", "6", "--json"}));
  EXPECT_EQ(json.code, 0) << json.err;
  EXPECT_TRUE(json.json()["scale_is_open"]);
  EXPECT_THAT(json.json()["rig_toml"].get<std::string>(), HasSubstr("kind = \"socket\""));
}

TEST_F(PlanSockets, OneSocketOrAnImpossiblePlaceIsAnErrorWithAWayOut) {
  const Outcome one = sixdial({"plan", "sockets", "--rig", kArm, "--at", "260", "0", "40"});
  EXPECT_EQ(one.code, 2);
  EXPECT_THAT(one.err, HasSubstr("print a second one"));
  EXPECT_EQ(sixdial({"plan", "sockets", "--rig", kArm, "--at", "260", "0"}).code, 2);
  const Outcome far = sixdial(
      {"plan", "sockets", "--rig", kArm, "--at", "260", "0", "40", "--at", "2600", "0", "40"});
  EXPECT_EQ(far.code, 5) << far.err;
  EXPECT_THAT(far.err, HasSubstr("does not reach it"));
}

/// Joint values as the simulated arm reads them.
void fill(const std::string& folder, std::uint64_t seed) {
  const geometry::Rig rig = session::read_rig_file(folder + "/rig.toml");
  session::Plan plan = session::read_plan(folder + "/plan.csv", rig);
  std::vector<mock_devices::SocketVisit> visits;
  for (const session::PlanPoint& each : plan.points) visits.push_back({each.socket, each.q});
  const auto read = mock_devices::seated(mock_devices::arm_of_rig(rig, seed), rig, visits);
  for (std::size_t i = 0; i < read.size(); ++i) plan.points[i].q = read[i];
  session::write_file(folder + "/session.csv", session::filled_session(plan, rig));
}

TEST_F(PlanSockets, AFolderIsFilledInAndCalibrates) {
  const std::string folder = file("monday");
  const Outcome planned =
      sixdial(plan({"--count", "20", "--g2", "5", "--distance", "206", "--bundle", folder}));
  ASSERT_EQ(planned.code, 0) << planned.err;
  EXPECT_THAT(planned.err, HasSubstr("sixdial calibrate"));
  // The rig file as it was written, and the sockets below.
  EXPECT_THAT(
      session::read_file(folder + "/rig.toml"),
      ::testing::StartsWith(session::read_file(kArm)));
  EXPECT_THAT(
      session::read_file(folder + "/poses.csv"),
      ::testing::StartsWith("set,point,repeat,socket,q1_deg"));
  // As long as nothing is filled in, nothing is calibrated by it.
  const Outcome empty = sixdial({"calibrate", folder, "-q"});
  EXPECT_NE(empty.code, 0);
  EXPECT_THAT(empty.err, HasSubstr("q1_deg"));
  // And nobody loses what is filled in.
  const Outcome again = sixdial(plan({"--count", "6", "--bundle", folder}));
  EXPECT_NE(again.code, 0);
  EXPECT_THAT(again.err, HasSubstr("nothing is written over it"));

  fill(folder, 3);
  const Outcome found =
      sixdial({"calibrate", folder, "-q", "--method", "lm", "-o", file("c.json")});
  EXPECT_THAT(found.err, Not(HasSubstr("error:")));
  const Json document = Json::parse(session::read_file(file("c.json")));
  // Poses that were not fitted: the nominal robot misses the sockets by much more.
  const Json& methods = document.at("methods");
  ASSERT_EQ(methods.size(), 2U) << found.out;  // before, and least squares
  const double before_mm = methods.at(0).at("g2").at("mean_mm").get<double>();
  const double after_mm = methods.at(1).at("g2").at("mean_mm").get<double>();
  EXPECT_LT(after_mm, 0.5 * before_mm) << found.out;
  EXPECT_THAT(found.out, HasSubstr("samples determine"));
}

}  // namespace
}  // namespace sixdial::cli
