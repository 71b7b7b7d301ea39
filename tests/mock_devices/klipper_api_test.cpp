// The mock machine that Klipper moves, spoken to by hand.
#include "mock_devices/klipper_api.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

namespace sixdial::mock_devices {
namespace {

using Json = nlohmann::json;
using testing::HasSubstr;

class KlipperApiTest : public testing::Test {
 protected:
  void say(const std::string& text, double time_s) { api_.receive(1, text + "\x03", time_s); }
  std::vector<Json> heard(double time_s) {
    std::vector<Json> all;
    std::string text = api_.due(1, time_s);
    for (std::size_t end = text.find('\x03'); end != std::string::npos;
         end = text.find('\x03')) {
      all.push_back(Json::parse(text.substr(0, end)));
      text.erase(0, end + 1);
    }
    EXPECT_EQ(text, "");
    return all;
  }
  KlipperApi api_{{}};
  KlipperApiTest() { api_.connected(1, 0.0); }
};

TEST_F(KlipperApiTest, AnswersInfoAndQueriesOfTheFieldsThatWereAskedFor) {
  say(R"({"id": 123, "method": "info", "params": {}})", 0.0);
  say(R"({"id": 124, "method": "objects/query",
          "params": {"objects": {"toolhead": ["position"], "webhooks": null, "nobody": null}}})",
      0.0);
  const std::vector<Json> said = heard(0.0);
  ASSERT_EQ(said.size(), 2u);
  EXPECT_EQ(said[0]["result"]["state_message"], "Printer is ready");
  EXPECT_EQ(
      said[1]["result"]["status"],
      Json::parse(R"({"webhooks": {"state": "ready", "state_message": "Printer is ready"},
                      "toolhead": {"position": [0.0, 0.0, 0.0, 0.0]}, "nobody": {}})"));
}

TEST_F(KlipperApiTest, M400IsAnsweredWhenTheMoveHasEndedAndQueriesAreMeanwhile) {
  say(R"({"id": 1, "method": "gcode/script", "params": {"script": "G1 X10 F600\nM400"}})", 0.0);
  EXPECT_TRUE(heard(0.0).empty());
  EXPECT_NEAR(api_.position(0.5)[0], 5.0, 1e-9) << "10 mm/s";
  say(R"({"id": 2, "method": "objects/query", "params": {"objects": {"motion_report": null}}})",
      0.5);
  const std::vector<Json> meanwhile = heard(0.5);
  ASSERT_EQ(meanwhile.size(), 1u);
  EXPECT_EQ(meanwhile[0]["result"]["status"]["motion_report"]["live_velocity"], 10.0);
  EXPECT_TRUE(heard(0.9).empty());
  const std::vector<Json> done = heard(1.0);
  ASSERT_EQ(done.size(), 1u);
  EXPECT_EQ(done[0], Json::parse(R"({"id": 1, "result": {}})"));
}

TEST_F(KlipperApiTest, MovesFurtherAheadThanItPlansAreTakenLater) {
  say(R"({"id": 1, "method": "gcode/script", "params": {"script": "G1 X50 F600"}})", 0.0);
  say(R"({"id": 2, "method": "gcode/script", "params": {"script": "G1 X60"}})", 0.0);
  EXPECT_EQ(heard(0.0).size(), 1u);
  EXPECT_TRUE(heard(2.9).empty());
  EXPECT_EQ(heard(3.1).size(), 1u) << "2 s before the end of the first";
}

TEST_F(KlipperApiTest, ErrorsAreObjectsAndAShutdownEndsEverything) {
  say(R"({"id": 3, "method": "gcode/script", "params": {"script": "G1 X200"}})", 0.0);
  say(R"({"id": 4, "method": "dance"})", 0.0);
  const std::vector<Json> wrong = heard(0.0);
  ASSERT_EQ(wrong.size(), 2u);
  EXPECT_EQ(wrong[0]["error"]["error"], "WebRequestError") << wrong[0];
  EXPECT_THAT(wrong[1]["error"]["message"].get<std::string>(), HasSubstr("out of range"));
  say(R"({"id": 5, "method": "gcode/script", "params": {"script": "G1 X100 F600\nM400"}})",
      1.0);
  EXPECT_TRUE(heard(1.0).empty());
  say(R"({"id": 6, "method": "emergency_stop"})", 2.0);
  const std::vector<Json> ended = heard(2.0);
  ASSERT_EQ(ended.size(), 2u);
  EXPECT_THAT(ended[0]["error"]["message"].get<std::string>(), HasSubstr("Shutdown"));
  EXPECT_NEAR(api_.position(9.0)[0], 10.0, 1e-9) << "it stands";
}

TEST_F(KlipperApiTest, WithoutAnIdNothingIsAnswered) {
  say(R"({"method": "info"})", 0.0);
  say("no JSON at all", 0.0);
  EXPECT_TRUE(heard(0.0).empty());
}

}  // namespace
}  // namespace sixdial::mock_devices
