// Klipper's API server: messages typed from its page docs/API_Server.md, and a machine that
// shuts down.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>
#include <thread>

#include "acquisition/robot_driver.h"
#include "acquisition/robots/klipper/message.h"
#include "acquisition/robots/klipper/robot.h"
#include "tests/acquisition/axis_twin.h"

namespace sixdial::acquisition {
namespace {

using namespace std::chrono_literals;
using test::refusal;
using testing::ElementsAre;
using testing::HasSubstr;
using Json = nlohmann::json;

TEST(KlipperMessages, RequestsAreThoseOfItsPage) {
  const auto request = [](std::string text) {
    EXPECT_EQ(text.back(), '\x03');
    text.pop_back();
    return Json::parse(text);
  };
  EXPECT_EQ(
      request(klipper_script_request(123, "G1 X200\nM400")),
      Json::parse(
          R"({"id": 123, "method": "gcode/script", "params": {"script": "G1 X200\nM400"}})"));
  const Json info = request(klipper_info_request(7));
  EXPECT_EQ(info.at("method"), "info");
  EXPECT_EQ(info.at("id"), 7);
  EXPECT_TRUE(info.at("params").at("client_info").is_object());
  const Json query = request(klipper_status_request(8));
  EXPECT_EQ(query.at("method"), "objects/query");
  EXPECT_EQ(
      query.at("params").at("objects").at("webhooks"),
      Json::parse(R"(["state","state_message"])"));
  EXPECT_EQ(
      query.at("params").at("objects").at("motion_report"),
      Json::parse(R"(["live_position","live_velocity"])"));
}

TEST(KlipperMessages, AnswersOfItsPageAreRead) {
  const auto ready = parse_klipper(
      R"j({"id": 123, "result": {"state_message": "Printer is ready", "klipper_path":
          "/home/pi/klipper", "config_file": "/home/pi/printer.cfg", "software_version":
          "v0.8.0-823-g883b1cb6", "hostname": "octopi",
          "cpu_info": "4 core ARMv7 Processor rev 4 (v7l)", "state": "ready",
          "python_path": "/home/pi/klippy-env/bin/python", "log_file": "/tmp/klippy.log"}})j");
  ASSERT_TRUE(ready);
  EXPECT_EQ(ready->id, 123);
  EXPECT_EQ(ready->status.state, "ready");
  const auto refused = parse_klipper(
      R"({"id": 123, "error": {"message": "Must home axis first: 200.000 0.000 0.000 [0.000]",
          "error": "WebRequestError"}})");
  ASSERT_TRUE(refused);
  EXPECT_EQ(refused->error, "Must home axis first: 200.000 0.000 0.000 [0.000]");
  const auto told = parse_klipper(
      R"({"id": 124, "result": {"status": {"webhooks": {"state": "ready", "state_message":
          "Printer is ready"}, "toolhead": {"position": [0.0, 0.0, 0.0, 0.0], "homed_axes": "xy"},
          "motion_report": {"live_position": [1.5, -2, 3e1, 0], "live_velocity": 12.5},
          "gcode_move": {"position": [2, 3, 4, 0], "gcode_position": [1, 3, 4, 0]}},
          "eventtime": 3051555.377933684}})");
  ASSERT_TRUE(told);
  EXPECT_EQ(told->status.homed, "xy");
  EXPECT_THAT(told->status.live, ElementsAre(1.5, -2.0, 30.0, 0.0));
  EXPECT_EQ(told->status.velocity, 12.5);
  EXPECT_THAT(told->status.commanded, ElementsAre(1.0, 3.0, 4.0, 0.0));
  const auto unasked =
      parse_klipper(R"({"params": {"response": "ok B:22.8 /0.0 T0:22.4 /0.0"}, "key": 345})");
  ASSERT_TRUE(unasked);
  EXPECT_FALSE(unasked->id);
}

TEST(KlipperMessages, WhatIsCutOrOfAnotherShapeIsNone) {
  const std::string whole =
      R"({"id":1,"result":{"status":{"motion_report":{"live_position":[1,2,3,0]}}}})";
  ASSERT_TRUE(parse_klipper(whole));
  for (std::size_t size = 0; size < whole.size(); ++size) {
    EXPECT_FALSE(parse_klipper(whole.substr(0, size))) << size;
  }
  for (const char* const text :
       {R"({"id":1})", R"([])", R"("ready")", R"({"id":1,"result":7})",
        R"({"id":1,"result":{"status":{"motion_report":{"live_position":[1,2]}}}})",
        R"({"id":1,"result":{"status":{"motion_report":{"live_position":[1,null,3]}}}})",
        R"({"id":1,"result":{"status":{"motion_report":{"live_position":[1,2,1e300]}}}})",
        R"({"id":1,"result":{"status":{"motion_report":{"live_velocity":"fast"}}}})",
        R"({"id":1,"result":{"status":{"webhooks":{"state":1}}}})", R"({"id":1,"error":"no"})",
        "ok", "<Idle|MPos:0,0,0>"}) {
    EXPECT_FALSE(parse_klipper(text)) << text;
  }
}

class KlipperTest : public testing::Test {
 protected:
  void start(mock_devices::KlipperMachine machine = {}) {
    twin_ = std::make_unique<test::KlipperTwin>(std::move(machine), folder_.path("klippy_uds"));
  }
  std::unique_ptr<RobotPort> robot(const std::string& options = "?feed=60000") {
    return test::opened(twin_->connection(options), clock_);
  }
  test::TemporaryFolder folder_;
  SystemClock clock_;
  std::unique_ptr<test::KlipperTwin> twin_;
};

TEST_F(KlipperTest, AMoveIsGivenInPiecesAndEndsWithM400) {
  start();
  const auto port = robot("?feed=600");
  ASSERT_TRUE(port->move_to(Eigen::Vector3d(0, 0, 10), 30s, {}));  // a second: four pieces
  twin_->socket().with([&](double) {
    EXPECT_THAT(
        twin_->api.scripts(), ElementsAre(
                                  "M400\nG90", "G1 X0 Y0 Z2.5 F600", "G1 X0 Y0 Z5 F600",
                                  "G1 X0 Y0 Z7.5 F600", "G1 X0 Y0 Z10 F600", "M400"));
  });
}

TEST_F(KlipperTest, AMachineThatIsNotReadyIsToldInItsWords) {
  start(
      {.state = "startup",
       .state_message = "Printer is not ready\nThe klippy host software "
                        "is attempting to connect."});
  const auto state = robot()->state({});
  ASSERT_FALSE(state);
  EXPECT_EQ(state.error().kind, RobotFaultKind::kController);
  EXPECT_THAT(state.error().detail, HasSubstr("startup"));
  EXPECT_THAT(state.error().detail, HasSubstr("Printer is not ready The klippy host"));
}

TEST_F(KlipperTest, AShutdownOnTheWayEndsTheMoveAtOnce) {
  start();
  const auto port = robot("?feed=60");
  std::jthread person = twin_->once_beyond(0.2, [&] {
    twin_->socket().with([&](double time_s) {
      twin_->api.shut_down("Lost communication with MCU 'mcu'", time_s);
    });
  });
  const auto began = std::chrono::steady_clock::now();
  const auto ended = port->move_to(Eigen::Vector3d(0, 0, 100), 600s, {});
  EXPECT_LT(std::chrono::steady_clock::now() - began, test::kInTime);
  ASSERT_FALSE(ended);
  EXPECT_EQ(ended.error().kind, RobotFaultKind::kController);
  EXPECT_THAT(ended.error().detail, HasSubstr("Lost communication"));
  EXPECT_THAT(ended.error().detail, HasSubstr("FIRMWARE_RESTART"));
  EXPECT_EQ(port->state({}).error().kind, RobotFaultKind::kController);
  EXPECT_FALSE(port->move_to(Eigen::Vector3d(0, 0, 1), 10s, {}));
}

TEST_F(KlipperTest, AnAxisThatWasNotHomedIsNamed) {
  start({.homed = "xy"});
  const auto refused = robot()->move_to(Eigen::Vector3d(0, 0, 1), 10s, {});
  ASSERT_FALSE(refused);
  EXPECT_EQ(refused.error().kind, RobotFaultKind::kController);
  EXPECT_THAT(refused.error().detail, HasSubstr("axis Z (q3) is not homed"));
}

TEST_F(KlipperTest, BesideAPrintNothingIsMoved) {
  start({.print_state = "printing"});
  const auto port = robot();
  EXPECT_TRUE(port->state({}));
  const auto refused = port->move_to(Eigen::Vector3d(0, 0, 1), 10s, {});
  ASSERT_FALSE(refused);
  EXPECT_EQ(refused.error().kind, RobotFaultKind::kController);
  EXPECT_THAT(refused.error().detail, HasSubstr("come to its end"));
  twin_->socket().with([&](double) { EXPECT_TRUE(twin_->api.scripts().empty()); });
}

TEST_F(KlipperTest, ASocketThatSaysSomethingElseIsNoKlipper) {
  // The same bytes on a Unix socket as a G-code machine prints.
  class Chatter final : public mock_devices::SocketMachine {
   public:
    void connected(int, double) override {}
    void receive(int, std::string_view, double) override { says_ = true; }
    std::string due(int, double) override {
      return std::exchange(says_, false) ? "ok\x03" : std::string();
    }
    void gone(int) override {}

   private:
    bool says_ = false;
  } chatter;
  const mock_devices::MachineSocket socket(chatter, {.unix_socket = folder_.path("chatter")});
  const auto state = test::opened("klipper:" + folder_.path("chatter"), clock_)->state({});
  ASSERT_FALSE(state);
  EXPECT_EQ(state.error().kind, RobotFaultKind::kLink);
  EXPECT_THAT(state.error().detail, HasSubstr("no message of Klipper"));
}

TEST(KlipperConnection, ARefusalSaysWhatWouldBeRight) {
  EXPECT_EQ(refusal("klipper:/run/klippy.sock"), "");
  EXPECT_EQ(refusal("klipper:/run/klippy.sock?axes=X,Y,Z&feed=1200&arrived=0.1"), "");
  EXPECT_THAT(refusal("klipper:klippy.sock"), HasSubstr("klipper:/run/klipper/klippy.sock"));
  EXPECT_THAT(refusal("klipper:"), HasSubstr("whole path"));
  EXPECT_THAT(refusal("klipper:/s?axes=X,Y,A"), HasSubstr("none of the axes XYZ"));
  EXPECT_THAT(refusal("klipper:/s?dialect=klipper"), HasSubstr("unknown key"));
  const std::vector<RobotJoint> six(6, RobotJoint{"q", true});
  EXPECT_THAT(
      parse_robot_connection("klipper:/s", six).error(), HasSubstr("this robot has 6 joints"));
}

}  // namespace
}  // namespace sixdial::acquisition
