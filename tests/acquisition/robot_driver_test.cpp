// What a rig file may say of the robot's connection.
#include "acquisition/robot_driver.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <fstream>
#include <set>
#include <sstream>

#include "geometry/rig.h"
#include "tests/support/paths.h"

namespace sixdial::acquisition {
namespace {

using testing::HasSubstr;

const std::vector<RobotJoint> kJoints{{"q1", true}, {"q2", true}, {"slide", false}};

std::string refusal(std::string_view text) {
  const auto parsed = parse_robot_connection(text, kJoints);
  return parsed ? "" : parsed.error();
}

TEST(RobotDrivers, EachHasWhatPeopleAndTheServiceAskOfIt) {
  std::set<std::string_view> schemes;
  for (const RobotDriver* driver : robot_drivers()) {
    EXPECT_TRUE(schemes.insert(driver->scheme).second) << driver->scheme;
    EXPECT_TRUE(driver->form.starts_with(driver->scheme)) << driver->form;
    EXPECT_FALSE(driver->in_words.empty()) << driver->scheme;
    EXPECT_NE(driver->parse, nullptr) << driver->scheme;
    EXPECT_THAT(robot_forms(), HasSubstr(std::string(driver->form)));
    EXPECT_THAT(robot_table(), HasSubstr(std::string(driver->form)));
  }
}

TEST(RobotDrivers, TheTableOfTheDevicesPageIsTheirs) {
  std::stringstream page;
  page << std::ifstream(test_paths::source_dir() + "/doc/devices.md").rdbuf();
  EXPECT_THAT(page.str(), HasSubstr(robot_table())) << "make it anew: sixdiald --print-robots";
}

TEST(RobotDrivers, TheSchemeNamesTheRow) {
  EXPECT_TRUE(parse_robot_connection("manual", kJoints)->driver->by_hand);
  EXPECT_EQ(
      parse_robot_connection("modbus-tcp://10.0.0.7:502?unit=2", kJoints)->driver->scheme,
      "modbus-tcp");
}

TEST(RobotDrivers, ARefusalSaysWhatWouldBeRight) {
  EXPECT_THAT(refusal("serial:/dev/ttyUSB0"), HasSubstr("manual"));
  EXPECT_THAT(refusal("modbus-tpc://h:1"), HasSubstr("did you mean 'modbus-tcp'"));
  EXPECT_THAT(refusal("modbus-tcp://h?index=1"), HasSubstr("index"));
  EXPECT_THAT(refusal("modbus-tcp:h:1"), HasSubstr("modbus-tcp://HOST:PORT"));
  EXPECT_THAT(refusal("manual:x"), HasSubstr("nothing follows"));
  EXPECT_THAT(refusal(""), HasSubstr("empty"));
}

TEST(RobotDrivers, TheJointsAreThoseOfTheRig) {
  const std::vector<RobotJoint> joints = joints_of(geometry::default_rig());
  EXPECT_EQ(joints, (std::vector<RobotJoint>{{"theta1", true}, {"theta2", true}}));
}

}  // namespace
}  // namespace sixdial::acquisition
