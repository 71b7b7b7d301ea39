// A real sixdiald at a mock rig: what happens to the robot when someone stops it, when its
// controller falls silent, on a first pass, and when a person moves it; and the dials while
// nothing is collected.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "geometry/units.h"
#include "session/csv.h"
#include "tests/support/live_rig.h"

namespace sixdial::service {
namespace {

using testing::create;
using testing::Daemon;
using testing::error_code_of;
using testing::eventually;
using ::testing::HasSubstr;
using testing::LineClient;
using testing::Rig;
using testing::start;
using testing::TempDirectory;
using testing::wait_for_end;

class Safety : public ::testing::Test {
 protected:
  Json status(LineClient& client) { return client.call("collect.status")["result"]; }
  /// True once the collection pauses for this reason.
  bool paused_for(LineClient& client, const std::string& reason) {
    return eventually([&] {
      const Json now = status(client);
      return now["state"] == "paused" && now["pause_reason"] == reason;
    });
  }
  /// The first event of this type; others go by.
  static Json event_of(LineClient& watcher, const std::string& topic, const std::string& type) {
    for (;;) {
      const Json params = watcher.read()["params"];
      if (params["topic"] == topic && params["data"]["type"] == type) return params["data"];
    }
  }

  TempDirectory directory_;
  Rig rig_;
  Daemon daemon_{directory_.path(), rig_.now()};
};

TEST_F(Safety, StopRobotPausesAndTheSamePointIsMeasuredAfterwards) {
  LineClient client = daemon_.client();
  ASSERT_EQ(error_code_of(create(client, rig_)), "");
  LineClient watcher = daemon_.client();
  watcher.call("events.subscribe", {{"topics", {"collect"}}});
  ASSERT_EQ(error_code_of(start(client, Rig::plan(12))), "");
  (void)event_of(watcher, "collect", "moving");
  const Json told = client.call("robot.stop");
  ASSERT_EQ(error_code_of(told), "") << told;
  EXPECT_EQ(told["result"]["told"], true);
  ASSERT_TRUE(eventually([&] { return status(client)["state"] == "paused"; }))
      << status(client);
  ASSERT_TRUE(eventually([&] {
    if (status(client)["state"] == "paused") client.call("collect.resume");
    return status(client)["state"] == "done";
  }));
  EXPECT_EQ(client.call("session.show", {{"session", "live"}})["result"]["samples"], 12);
  EXPECT_EQ(error_code_of(client.call("robot.stop")), "wrong_state") << "whose robot?";
  EXPECT_EQ(error_code_of(client.call("robot.stop", {{"session", "live"}})), "");
}

TEST_F(Safety, ASilentControllerIsToldAtOnceAndPauses) {
  LineClient client = daemon_.client();
  ASSERT_EQ(error_code_of(create(client, rig_)), "");
  LineClient watcher = daemon_.client();
  watcher.call("events.subscribe", {{"topics", {"live"}}});
  ASSERT_EQ(error_code_of(start(client, Rig::plan(200))), "");
  EXPECT_EQ(event_of(watcher, "live", "dials")["robot_silent_s"], 0.0);
  rig_.mock().stop();
  // The dials are gone as well: where they are missed first, the next try asks the robot.
  for (;;) {
    const Json live = event_of(watcher, "live", "dials");
    if (live["robot_silent_s"].get<double>() > 0.0) break;
    const Json now = status(client);
    if (now["state"] == "paused" && now["pause_reason"] != "robot")
      client.call("collect.resume");
  }
  ASSERT_TRUE(paused_for(client, "robot"));
  EXPECT_THAT(
      status(client)["trouble"].get<std::string>(), HasSubstr("controller does not answer"));
  const Json refused = client.call("robot.stop");
  EXPECT_EQ(error_code_of(refused), "device");
  EXPECT_THAT(refused["error"]["data"]["hint"].get<std::string>(), HasSubstr("emergency stop"));
}

TEST_F(Safety, AFirstPassAsksBeforeItMovesAndStoresNothing) {
  LineClient client = daemon_.client();
  ASSERT_EQ(error_code_of(create(client, rig_)), "");
  const std::string plan =
      session::plan_csv(Rig::plan(40), session::layout_of(geometry::default_rig()));
  ASSERT_EQ(
      error_code_of(client.call(
          "collect.start", {{"session", "live"}, {"plan_csv", plan}, {"first_pass", true}})),
      "");
  ASSERT_TRUE(paused_for(client, "first_move"));
  EXPECT_EQ(rig_.mock().robot().moves_started, 0) << "nothing has moved";
  EXPECT_THAT(status(client)["message"].get<std::string>(), HasSubstr("emergency stop"));
  client.call("collect.resume");
  ASSERT_TRUE(eventually([&] {
    if (status(client)["state"] == "paused") client.call("collect.resume");
    return status(client)["state"] == "done";
  })) << status(client);
  const Json ended = status(client);
  EXPECT_LE(ended["total"], 8);
  EXPECT_GE(ended["total"], 4);
  EXPECT_EQ(ended["stored_in_this_run"], 0);
  EXPECT_THAT(ended["ended_because"].get<std::string>(), HasSubstr("nothing was stored"));
  EXPECT_EQ(client.call("session.show", {{"session", "live"}})["result"]["samples"], 0);
  EXPECT_EQ(client.call("session.show", {{"session", "live"}})["result"]["plan_points"], 40)
      << "the whole plan is there to be measured";
}

TEST_F(Safety, AFirstPassStopsAtADialThatStandsElsewhere) {
  LineClient client = daemon_.client();
  geometry::Rig moved = rig_.mock().connected_rig("modbus-tcp");
  moved.dials[2].geometry.position_mm.y() += 9.0;  // the file is wrong about C
  ASSERT_EQ(
      error_code_of(client.call(
          "session.create", {{"name", "live"}, {"rig_toml", session::write_rig(moved)}})),
      "");
  const std::string plan =
      session::plan_csv(Rig::plan(40), session::layout_of(geometry::default_rig()));
  client.call("collect.start", {{"session", "live"}, {"plan_csv", plan}, {"first_pass", true}});
  ASSERT_TRUE(paused_for(client, "first_move"));
  client.call("collect.resume");
  ASSERT_TRUE(paused_for(client, "store")) << status(client);
  EXPECT_THAT(
      status(client)["message"].get<std::string>(),
      HasSubstr("first pass: dial C does not show what the rig file"));
  client.call("collect.stop");
  EXPECT_EQ(wait_for_end(client)["state"], "stopped");
}

TEST_F(Safety, DialsAreShownWhileNothingIsCollectedAndLetGoWhenACollectionBegins) {
  LineClient client = daemon_.client();
  ASSERT_EQ(error_code_of(create(client, rig_)), "");
  LineClient watcher = daemon_.client();
  watcher.call("events.subscribe", {{"topics", {"live"}}});
  ASSERT_EQ(error_code_of(client.call("dials.watch", {{"session", "live"}})), "");
  Json live = event_of(watcher, "live", "dials");
  EXPECT_EQ(live["stage"], "watching");
  EXPECT_EQ(live["dials"].size(), 6U);
  EXPECT_TRUE(live["check"].is_null());
  ASSERT_EQ(error_code_of(client.call("dials.check", {{"do", "start"}})), "");
  do live = event_of(watcher, "live", "dials");
  while (!live["check"].is_object());
  EXPECT_EQ(live["check"]["asked"], "A");
  ASSERT_EQ(error_code_of(start(client, Rig::plan(4))), "");
  EXPECT_EQ(error_code_of(client.call("dials.watch", {{"session", "live"}})), "wrong_state");
  EXPECT_EQ(wait_for_end(client)["state"], "done");
  EXPECT_EQ(error_code_of(client.call("dials.watch", {{"session", "live"}, {"for_s", 5}})), "");
  EXPECT_EQ(client.call("dials.stop")["result"]["watching"], false);
}

TEST_F(Safety, ARobotMovedByHandIsToldInDegreesWhichWayAndAsksStrangeFiguresBack) {
  LineClient client = daemon_.client();
  geometry::Rig by_hand = rig_.mock().connected_rig("modbus-tcp");
  by_hand.robot.connection = "manual";
  client.call("session.create", {{"name", "live"}, {"rig_toml", session::write_rig(by_hand)}});
  session::PlanOptions options;
  options.approach = session::ApproachRule::kAlternate;
  const session::Plan plan = session::plan_random(geometry::default_rig(), 3, options).value();
  ASSERT_EQ(
      error_code_of(client.call(
          "collect.start",
          {{"session", "live"},
           {"plan_csv", session::plan_csv(plan, session::layout_of(by_hand))}})),
      "");
  ASSERT_TRUE(eventually([&] { return status(client)["move"].is_object(); }));
  const Json asked = status(client);
  const double first_rad = asked["move_to"][0]["value"].get<double>();
  const double second_rad = asked["move_to"][1]["value"].get<double>();
  EXPECT_EQ(asked["move"]["joints"][0]["unit"], "deg");
  EXPECT_NEAR(
      asked["move"]["joints"][0]["to"].get<double>(), first_rad * geometry::kDegPerRad, 1e-9);
  EXPECT_TRUE(asked["move"]["joints"][0]["first"].is_number()) << "a side is asked for";
  const auto words = asked["move"]["words"].get<std::string>();
  EXPECT_THAT(words, HasSubstr("Move the tool to x "));
  EXPECT_THAT(words, HasSubstr("without turning back"));
  // Degrees where radians are meant.
  const Json strange = client.call(
      "collect.moved",
      {{"theta1_rad", first_rad * geometry::kDegPerRad}, {"theta2_rad", second_rad}});
  EXPECT_EQ(error_code_of(strange), "invalid_params");
  EXPECT_THAT(
      strange["error"]["data"]["hint"].get<std::string>(), HasSubstr("looks like degrees"));
  EXPECT_TRUE(status(client)["move"].is_object()) << "it is still asked for";
  EXPECT_EQ(
      error_code_of(client.call(
          "collect.moved",
          {{"theta1_rad", first_rad + 0.5}, {"theta2_rad", second_rad}, {"confirm", true}})),
      "");
  // The next one is told from where the person said that it stands.
  ASSERT_TRUE(eventually([&] {
    const Json now = status(client);
    return now["move"].is_object() && now["move"]["joints"][0]["from"].is_number();
  })) << status(client);
  EXPECT_NEAR(
      status(client)["move"]["joints"][0]["from"].get<double>(),
      (first_rad + 0.5) * geometry::kDegPerRad, 1e-9);
  EXPECT_THAT(status(client)["move"]["words"].get<std::string>(), HasSubstr("clockwise by "));
}

}  // namespace
}  // namespace sixdial::service
