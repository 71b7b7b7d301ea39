// What can be done with a session and why the rest cannot; what every client is told when one
// of them changes something; the collector's own judgement in the live readings.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "mock_devices/iso_time.h"
#include "mock_devices/mock_rig.h"
#include "session/rig_file.h"
#include "tests/support/job_answers.h"
#include "tests/support/paths.h"
#include "tests/support/rig_for_tests.h"
#include "tests/support/simulated.h"

namespace sixdial::service {
namespace {

using testing::finished;
using ::testing::HasSubstr;
using testing::LineClient;
using testing::RunningService;

Json choices(LineClient& client, const std::string& session) {
  return client.call("session.choices", {{"session", session}})["result"];
}

session::Session simulated(int points) {
  const mock_devices::World world = testing::simple_world(4);
  session::PlanOptions options;
  options.seed = 9;
  session::Session session =
      testing::measured(world, session::plan_random(world.rig, points, options).value());
  session.name = "monday";
  return session;
}

TEST(Choices, FollowTheSessionFromNothingToItsReport) {
  RunningService running;
  LineClient client = running.client();
  client.call(
      "session.create",
      {{"name", "empty"}, {"rig_toml", session::write_rig(geometry::default_rig())}});
  const Json none = choices(client, "empty")["choices"];
  EXPECT_EQ(none["start"], "there is no plan yet");
  EXPECT_EQ(none["undo"], "nothing is measured yet");
  EXPECT_EQ(none["calibrate"], "nothing is measured yet");
  EXPECT_EQ(none["report"], "calibrate or diagnose first");

  db::Store& store = running.service().store();
  store.import_session(simulated(2));
  const Json few = choices(client, "monday")["choices"];
  EXPECT_EQ(few["calibrate"], "2 positions of set G1, at least 3 are needed");
  EXPECT_THAT(few["diagnose"].get<std::string>(), HasSubstr("at least 21 are needed"));
  EXPECT_TRUE(few["undo"].is_null());
  // The words are true: the job itself refuses, too.
  const Json job = client.call("calibrate.start", {{"session", "monday"}})["result"];
  EXPECT_EQ(finished(client, job)["state"], "failed");
}

TEST(Choices, AReportIsOfTheSamplesThatThereAre) {
  RunningService running;
  LineClient client = running.client();
  running.service().store().import_session(simulated(16));
  EXPECT_TRUE(choices(client, "monday")["choices"]["diagnose"].is_null());
  const auto run = [&](const std::string& method, Json params) {
    params["session"] = "monday";
    const Json job = client.call(method, params)["result"];
    const Json ended = finished(client, job);
    EXPECT_EQ(ended["state"], "done") << ended;
  };
  // A diagnosis alone is worth a page.
  run("diagnose.start", {{"bootstrap", 0}, {"gain", false}});
  EXPECT_EQ(choices(client, "monday")["report_of"], "diagnosis");
  EXPECT_TRUE(choices(client, "monday")["choices"]["report"].is_null());
  run("calibrate.start", {{"particles", 10},
                          {"qpso1_iterations", 5},
                          {"qpso2_iterations", 5},
                          {"anfis_epochs", 2}});
  EXPECT_EQ(choices(client, "monday")["report_of"], "calibration");
  client.call("session.undo", {{"session", "monday"}});
  const Json after = choices(client, "monday");
  EXPECT_TRUE(after["report_of"].is_null());
  EXPECT_EQ(
      after["choices"]["report"], "samples have changed since: calibrate or diagnose again");
  const Json refused = client.call(
      "report.write",
      {{"session", "monday"}, {"path", (running.directory() / "report").string()}});
  EXPECT_EQ(testing::error_code_of(refused), "bad_data");  // the words are true
}

TEST(SessionEvents, TellEveryClientOfSessionsMadeAndSamplesWithdrawn) {
  RunningService running;
  LineClient watcher = running.client(), client = running.client();
  watcher.call("events.subscribe", {{"topics", {"session"}}});
  client.call(
      "session.create",
      {{"name", "new"}, {"rig_toml", session::write_rig(geometry::default_rig())}});
  Json event = watcher.read()["params"];
  EXPECT_EQ(event["topic"], "session");
  EXPECT_EQ(event["data"], (Json{{"type", "created"}, {"session", "new"}}));
  EXPECT_TRUE(client.call("session.undo", {{"session", "new"}})["result"]["undone"].is_null());
  client.call(
      "session.import", {{"path", test_paths::test_data() + "/session_00"}, {"name", "one"}});
  EXPECT_EQ(
      watcher.read()["params"]["data"]["type"], "imported");  // an undo of nothing is none
  client.call("session.undo", {{"session", "one"}});
  event = watcher.read()["params"]["data"];
  EXPECT_EQ(event["type"], "undone");
  EXPECT_EQ(event["session"], "one");
  EXPECT_EQ(event["samples"], 149);
}

TEST(LiveReadings, CarryTheCollectorsJudgementAndTheEstimateFollowsAnUndo) {
  mock_devices::MockRigOptions options;
  options.world.rig = geometry::default_rig();
  options.world.robot.parameters = geometry::table_2_robot();
  options.clock_speed = 2.0;
  mock_devices::MockRig mock(options);
  mock.start();
  ServiceOptions service_options;
  service_options.clock_speed = options.clock_speed;
  service_options.clock_start = session::from_iso8601(mock_devices::iso8601(mock.utc_ms()));
  RunningService running({}, service_options);
  LineClient client = running.client();
  client.call(
      "session.create",
      {{"name", "live"}, {"rig_toml", session::write_rig(mock.connected_rig("modbus-tcp"))}});
  session::PlanOptions plan;
  plan.seed = 5;
  LineClient watcher = running.client();
  watcher.call("events.subscribe", {{"topics", {"live", "collect", "sample"}}});
  client.call(
      "collect.start",
      {{"session", "live"},
       {"plan_csv", session::plan_csv(
                        session::plan_random(geometry::default_rig(), 12, plan).value(),
                        session::layout_of(geometry::default_rig()))}});
  int moving = 0, judged = 0, samples = 0;
  for (Json data = Json::object(); data.value("state", "") != "done";) {
    const Json params = watcher.read()["params"];
    data = params.value("data", Json::object());
    ASSERT_NE(data.value("state", ""), "failed") << data;
    if (params.value("topic", "") == "sample") {
      ++samples;
      EXPECT_EQ(data["doubt"], "");
    }
    if (params.value("topic", "") != "live") continue;
    const Json& settle = data["settle"];
    if (data["stage"] == "moving") {
      ++moving;
      EXPECT_TRUE(settle["spread_mm"].is_null());
      EXPECT_TRUE(settle["settled"].is_null());
    } else if (settle["spread_mm"].is_number()) {
      ++judged;
      EXPECT_TRUE(data["dials"].contains(settle["dial"].get<std::string>()));
      if (settle["settled"] == true) {
        EXPECT_LE(settle["spread_mm"], settle["limit_mm"]);
      }
      if (settle["spread_mm"] > settle["limit_mm"]) {
        EXPECT_EQ(settle["settled"], false);
      }
    }
  }
  EXPECT_EQ(samples, 12);
  EXPECT_GT(moving, 0);
  EXPECT_GT(judged, 0);
  EXPECT_EQ(client.call("collect.status")["result"]["estimate"]["samples"], 12);
  client.call("session.undo", {{"session", "live"}});
  EXPECT_EQ(client.call("collect.status")["result"]["estimate"]["samples"], 11);
}

}  // namespace
}  // namespace sixdial::service
