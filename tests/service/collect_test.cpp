// Whole collections on the mock rig, through real protocol bytes: live, commanded, stopped,
// killed, gone on with. No acknowledged sample may be missing.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <fstream>
#include <map>
#include <sstream>

#include "session/bundle.h"
#include "session/csv.h"
#include "tests/support/live_rig.h"
#include "tests/support/paths.h"

namespace sixdial::service {
namespace {

using testing::create;
using testing::Daemon;
using testing::error_code_of;
using testing::eventually;
using testing::Key;
using testing::key_of;
using testing::LineClient;
using testing::Rig;
using testing::RunningService;
using testing::start;
using testing::TempDirectory;
using testing::wait_for_end;

// Dials: noise 0.002 mm each, error curve and hysteresis of some um.
constexpr double kSameReading_mm = 0.0005;

TEST(Collect, AWholePlanIsMeasuredStoredAndShown) {
  Rig rig;
  RunningService running({}, rig.service_options());
  LineClient client = running.client();
  ASSERT_EQ(error_code_of(create(client, rig)), "");
  LineClient watcher = running.client();
  watcher.call("events.subscribe", {{"topics", {"sample", "collect", "live"}}});
  const session::Plan plan = Rig::plan(12);
  ASSERT_EQ(start(client, plan)["result"]["total"], 12);
  const Json status = wait_for_end(client);
  EXPECT_EQ(status["state"], "done") << status;
  EXPECT_EQ(status["done"], 12);
  EXPECT_EQ(status["failed"], 0);

  std::map<Key, Json> told;
  bool ended = false;
  while (!ended) {
    const Json note = watcher.read();
    if (note["method"] != "events.event") continue;
    const Json& params = note["params"];
    if (params["topic"] == "sample") told[key_of(params["data"])] = params["data"];
    ended = params["topic"] == "collect" && params["data"]["type"] == "done";
  }
  EXPECT_EQ(told.size(), 12U);
  const session::Session stored =
      running.service().reader().load_session(running.service().reader().find_session("live"));
  ASSERT_EQ(stored.samples.size(), 12U);
  for (const session::Sample& sample : stored.samples) {
    const Json& event = told.at({sample.set, sample.point, sample.repeat});
    EXPECT_TRUE(event["position_mm"].is_array()) << event;
    EXPECT_TRUE(sample.temperature_c.has_value());
    EXPECT_TRUE(sample.target_mm.has_value());
    for (std::size_t i = 0; i < 6; ++i) {
      const Json& shown = event["dials"][stored.rig.dials[i].id]["value_mm"];
      ASSERT_EQ(shown.is_number(), sample.channels[i].value.has_value());
      if (shown.is_number()) {
        EXPECT_NEAR(shown.get<double>(), *sample.channels[i].value, kSameReading_mm);
      }
    }
  }
}

TEST(Collect, GoesOnAtTheNextPointAfterAStop) {
  Rig rig;
  RunningService running({}, rig.service_options());
  LineClient client = running.client();
  create(client, rig);
  LineClient watcher = running.client();
  watcher.call("events.subscribe", {{"topics", {"sample"}}});
  const session::Plan plan = Rig::plan(10);
  start(client, plan);
  for (int i = 0; i < 3; ++i) watcher.read();
  EXPECT_EQ(error_code_of(start(client, plan)), "wrong_state");  // one at a time
  ASSERT_EQ(error_code_of(client.call("collect.stop")), "");
  const Json stopped = wait_for_end(client);
  EXPECT_EQ(stopped["state"], "stopped");
  const std::size_t first = stopped["stored_in_this_run"].get<std::size_t>();
  EXPECT_GE(first, 3U);
  EXPECT_LT(first, 10U);
  std::map<std::string, std::size_t> planned;
  const Json shown = client.call("session.plan", {{"session", "live"}})["result"];
  for (const Json& point : shown["points"]) ++planned[point["state"].get<std::string>()];
  EXPECT_EQ(planned["done"] + planned["suspect"], first);
  EXPECT_EQ(planned["open"], 10 - first);
  ASSERT_EQ(error_code_of(client.call("collect.start", {{"session", "live"}})), "");
  const Json done = wait_for_end(client);
  EXPECT_EQ(done["state"], "done");
  EXPECT_EQ(done["done"], 10);
  EXPECT_EQ(done["stored_in_this_run"].get<std::size_t>(), 10 - first);
}

TEST(Collect, IsPausedGoneOnWithAndRetaken) {
  Rig rig;
  RunningService running({}, rig.service_options());
  LineClient client = running.client();
  create(client, rig);
  start(client, Rig::plan(6));
  client.call("collect.pause");
  ASSERT_TRUE(eventually([&] {
    const std::string state = client.call("collect.status")["result"]["state"];
    return state == "paused" || state == "done";
  }));
  const Json paused = client.call("collect.status")["result"];
  ASSERT_EQ(paused["state"], "paused") << paused;
  const auto before = paused["stored_in_this_run"].get<int>();
  if (before > 0)
    client.call("collect.retake");
  else
    client.call("collect.resume");
  ASSERT_TRUE(eventually([&] {
    Json status = client.call("collect.status")["result"];
    if (status["state"] == "paused") client.call("collect.resume");
    return status["state"] == "done";
  }));
  db::Store& reader = running.service().reader();
  const auto rows = reader.list_samples(reader.find_session("live"));
  EXPECT_EQ(rows.size(), before > 0 ? 7U : 6U);  // a retake is a row of its own
  EXPECT_EQ(reader.load_session(reader.find_session("live")).samples.size(), 6U);
}

TEST(Collect, APointThatWasSkippedIsNotToldAsMeasured) {
  Rig rig;
  RunningService running({}, rig.service_options());
  LineClient client = running.client();
  create(client, rig);
  start(client, Rig::plan(6));
  client.call("collect.pause");
  ASSERT_TRUE(
      eventually([&] { return client.call("collect.status")["result"]["state"] == "paused"; }));
  client.call("collect.skip");
  const Json ended = wait_for_end(client);
  EXPECT_EQ(ended["state"], "done");
  ASSERT_EQ(ended["skipped"], 1) << ended;
  EXPECT_EQ(ended["ended_because"], "the plan is at its end; 1 of its points was skipped");
}

TEST(Collect, APlanThatContradictsWhatIsMeasuredIsRefused) {
  Rig rig;
  RunningService running({}, rig.service_options());
  LineClient client = running.client();
  create(client, rig);
  session::Plan plan = Rig::plan(3);
  start(client, plan);
  ASSERT_EQ(wait_for_end(client)["state"], "done");
  plan.points[1].target_mm.x() += 0.5;
  plan.points[1].q =
      *geometry::inverse(geometry::default_rig().robot.nominal, plan.points[1].target_mm, {});
  EXPECT_EQ(error_code_of(start(client, plan)), "wrong_state");
}

TEST(Collect, ADialThatDoesNotAnswerIsStoredAsSuchAndSaid) {
  Rig rig;
  RunningService running({}, rig.service_options());
  LineClient client = running.client();
  // Dial D's cable leads nowhere.
  session::Session made;
  made.rig = rig.mock().connected_rig("modbus-tcp");
  made.rig.dials[3].connection = "serial:/dev/does-not-exist?dialect=sylvac";
  client.call("session.create", {{"name", "live"}, {"rig_toml", session::write_rig(made.rig)}});
  LineClient watcher = running.client();
  watcher.call("events.subscribe", {{"topics", {"sample"}}});
  start(client, Rig::plan(2));
  EXPECT_EQ(wait_for_end(client)["state"], "done");
  const Json sample = watcher.read()["params"]["data"];
  EXPECT_TRUE(sample["dials"]["D"]["value_mm"].is_null());
  EXPECT_EQ(sample["dials"]["D"]["quality"], "bad");
  EXPECT_FALSE(sample["dials"]["D"]["reason"].get<std::string>().empty());
}

TEST(Collect, GoingDownInTheMiddleKeepsWhatWasAcknowledged) {
  TempDirectory directory;
  Rig rig;
  ServiceOptions options = rig.service_options();
  options.database = directory.path() / "kept.db";
  std::size_t told = 0;
  {
    RunningService running({}, options);
    LineClient client = running.client();
    create(client, rig);
    client.call("events.subscribe", {{"topics", {"sample"}}});
    start(client, Rig::plan(20));
    for (; told < 2; ++told) client.read();
    client.call("shutdown");
    running.stop();
  }
  options.clock_start = session::from_iso8601(rig.now());
  RunningService running({}, options);
  db::Store& reader = running.service().reader();
  EXPECT_GE(reader.done_points(reader.find_session("live")).size(), told);
  LineClient client = running.client();
  client.call("collect.start", {{"session", "live"}});
  const Json done = wait_for_end(client);
  EXPECT_EQ(done["state"], "done") << done;
  EXPECT_EQ(done["done"], 20);
}

/// Every event of a collection up to its end.
std::vector<Json> events_until_the_end(LineClient& watcher) {
  std::vector<Json> events;
  for (;;) {
    const Json note = watcher.read();
    if (note["method"] != "events.event" || note["params"]["topic"] != "collect") continue;
    events.push_back(note["params"]["data"]);
    const std::string type = events.back()["type"];
    if (type == "done" || type == "stopped" || type == "failed") return events;
  }
}

TEST(Collect, TellsWhatIsKnownOfTheRobotWhileThePointsComeIn) {
  Rig rig;
  RunningService running({}, rig.service_options());
  LineClient client = running.client();
  create(client, rig);
  LineClient watcher = running.client();
  watcher.call("events.subscribe", {{"topics", {"collect"}}});
  session::Plan plan = Rig::plan(14);
  const session::Plan g2 = Rig::plan(2, "G2");
  plan.points.insert(plan.points.end(), g2.points.begin(), g2.points.end());
  start(client, plan);
  std::vector<double> worst_mm;
  Json last;
  for (const Json& event : events_until_the_end(watcher)) {
    if (event["type"] == "moving") {
      EXPECT_FALSE(event.contains("estimate"));
    }
    if (event["type"] != "estimate") continue;
    last = event["estimate"];
    worst_mm.push_back(last["position_sd_mm"]["max"].get<double>());
    EXPECT_EQ(last["samples"], worst_mm.size());
    EXPECT_EQ(last["parameters"].size(), 10U);
    if (worst_mm.size() < 5) {
      EXPECT_TRUE(last["condition"].is_null());  // fewer readings than parameters
      EXPECT_FALSE(last["undetermined"].empty());
    }
  }
  ASSERT_EQ(worst_mm.size(), 14U);  // G2 judges, it is not taken in
  EXPECT_GT(worst_mm.front(), 0.5);
  EXPECT_LT(worst_mm.back(), 0.03);
  EXPECT_GT(last["condition"].get<double>(), 50.0);
  const geometry::ParameterVector robot = geometry::table_2_robot();
  // The instant of a reading draws its noise, so no two runs are the same: four standard
  // deviations of noise from 18 residuals are exceeded once in 120 runs, eight in none that
  // anyone will see.
  constexpr double kSigmas = 8.0;
  int far_off = 0;
  for (int i = 0; i < geometry::kParameterCount; ++i) {
    const Json& each = last["parameters"][static_cast<std::size_t>(i)];
    const double off = std::abs(each["value"].get<double>() - robot[i]);
    far_off += off > kSigmas * each["sd"].get<double>() ? 1 : 0;
  }
  EXPECT_EQ(far_off, 0) << last;
  // Who comes later sees it too, and a run that goes on begins with it.
  EXPECT_EQ(client.call("collect.status")["result"]["estimate"], last);
  client.call("collect.start", {{"session", "live"}});
  const Json again = wait_for_end(client);
  EXPECT_EQ(again["stored_in_this_run"], 0);
  EXPECT_EQ(again["estimate"]["samples"], 14);
}

TEST(Collect, EndsByItselfWhenTheUncertaintyIsBelowTheLimitAndSaysSo) {
  constexpr double kLimit_mm = 0.006;
  Rig rig;
  RunningService running({}, rig.service_options());
  LineClient client = running.client();
  create(client, rig);
  session::Plan plan = Rig::plan(100);
  const session::Plan g2 = Rig::plan(3, "G2");
  plan.points.insert(plan.points.end(), g2.points.begin(), g2.points.end());
  LineClient watcher = running.client();
  watcher.call("events.subscribe", {{"topics", {"collect"}}});
  client.call(
      "collect.start",
      {{"session", "live"},
       {"plan_csv", session::plan_csv(plan, session::layout_of(geometry::default_rig()))},
       {"stop_below_mm", kLimit_mm}});
  const Json status = wait_for_end(client);
  EXPECT_EQ(status["state"], "done") << status;
  const auto g1 = status["estimate"]["samples"].get<int>();
  EXPECT_GT(g1, 10) << "the limit, not the least number of samples, ended it";
  EXPECT_LT(g1, 80);
  EXPECT_EQ(status["left_out"], 100 - g1);
  for (const Json& event : events_until_the_end(watcher)) {
    if (event["type"] != "estimate") continue;
    const Json& estimate = event["estimate"];
    if (estimate["samples"] < 10) continue;  // too few to be believed
    EXPECT_EQ(
        estimate["position_sd_mm"]["max"].get<double>() < kLimit_mm, estimate["samples"] == g1)
        << estimate;
  }
  EXPECT_EQ(status["stored_in_this_run"], g1 + 3) << "G2 is measured all the same";
  EXPECT_LT(status["estimate"]["position_sd_mm"]["max"].get<double>(), kLimit_mm);
  EXPECT_THAT(
      status["ended_because"].get<std::string>(), ::testing::HasSubstr("below the 0.006 mm"));
  const Json shown = client.call("session.show", {{"session", "live"}})["result"];
  ASSERT_EQ(shown["collections"].size(), 1U);
  EXPECT_EQ(shown["collections"][0]["ended_because"], status["ended_because"]);
  EXPECT_EQ(shown["samples"], g1 + 3);

  // Without a limit the rest is measured after all.
  client.call("collect.start", {{"session", "live"}});
  client.call("collect.stop");
  EXPECT_EQ(wait_for_end(client)["ended_because"], "stopped by a command");
}

TEST(Collect, APlanInTwoModesPausesBeforeTheLegsAreBroughtOver) {
  Rig rig;
  RunningService running({}, rig.service_options());
  LineClient client = running.client();
  create(client, rig);
  const auto plan = session::plan_random(
      geometry::default_rig(), 3, {.working_modes = {{+1, +1}, {-1, +1}}, .seed = 5});
  start(client, plan.value());
  ASSERT_TRUE(
      eventually([&] { return client.call("collect.status")["result"]["state"] == "paused"; }));
  const Json paused = client.call("collect.status")["result"];
  EXPECT_EQ(paused["stored_in_this_run"], 3);
  EXPECT_EQ(paused["point"]["point"], 3);
  EXPECT_THAT(
      paused["message"].get<std::string>(), ::testing::HasSubstr("bring the legs over"));
  client.call("collect.resume");
  const Json status = wait_for_end(client);
  EXPECT_EQ(status["state"], "done") << status;
  EXPECT_EQ(status["stored_in_this_run"], 6);
  EXPECT_EQ(status["failed"], 0);
}

TEST(Daemon, KilledDuringCollectionItLosesNoAcknowledgedSampleAndCompletes) {
  constexpr int kPoints = 30;
  TempDirectory directory;
  Rig rig;
  std::map<Key, Json> acknowledged;
  int kills = 0;
  bool created = false;
  for (const int until : {1, 5, 11, 18}) {
    Daemon daemon(directory.path(), rig.now());
    LineClient client = daemon.client();
    if (!created) {
      ASSERT_EQ(error_code_of(create(client, rig)), "");
      created = true;
    }
    client.call("events.subscribe", {{"topics", {"sample"}}});
    ASSERT_EQ(error_code_of(start(client, Rig::plan(kPoints))), "");
    while (std::ssize(acknowledged) < until) {
      const Json data = client.read()["params"]["data"];
      acknowledged[key_of(data)] = data;
    }
    EXPECT_TRUE(WIFSIGNALED(daemon.end(SIGKILL)));
    ++kills;
    // What was on its way when it died was acknowledged, too.
    while (const auto line = client.read_line()) {
      const Json note = Json::parse(*line);
      if (note["method"] != "events.event") continue;
      acknowledged[key_of(note["params"]["data"])] = note["params"]["data"];
    }
  }
  EXPECT_EQ(kills, 4);
  Daemon daemon(directory.path(), rig.now());
  LineClient client = daemon.client();
  ASSERT_EQ(error_code_of(client.call("collect.start", {{"session", "live"}})), "");
  const Json done = wait_for_end(client);
  EXPECT_EQ(done["state"], "done") << done;
  EXPECT_EQ(done["done"], kPoints);
  const auto folder = directory.path() / "exported";
  client.call("session.export", {{"session", "live"}, {"path", folder.string()}});
  const session::Session session = session::read_bundle(folder);
  EXPECT_EQ(session.samples.size(), static_cast<std::size_t>(kPoints));
  std::size_t found = 0;
  for (const session::Sample& sample : session.samples) {
    const auto told = acknowledged.find({sample.set, sample.point, sample.repeat});
    if (told == acknowledged.end()) continue;
    ++found;
    for (std::size_t i = 0; i < session.rig.dials.size(); ++i) {
      const Json& shown = told->second["dials"][session.rig.dials[i].id]["value_mm"];
      ASSERT_EQ(shown.is_number(), sample.channels[i].value.has_value());
      if (!shown.is_number()) continue;
      EXPECT_NEAR(shown.get<double>(), *sample.channels[i].value, kSameReading_mm);
    }
  }
  EXPECT_EQ(found, acknowledged.size());
  EXPECT_GE(found, 18U);
  EXPECT_EQ(daemon.end(SIGTERM), 0);  // exit code 0
}

TEST(Daemon, ASignalToEndIsObeyedInTheMiddleOfEverything) {
  TempDirectory directory;
  Rig rig;
  Daemon daemon(directory.path(), rig.now());
  LineClient client = daemon.client();
  create(client, rig);
  // A job that does not end by itself first: a collection begun before it could be at its end
  // while it is still to start.
  const std::string bundle = test_paths::test_data() + "/session_00";
  client.call("session.import", {{"path", bundle}, {"name", "other"}});
  client.call(
      "calibrate.start",
      {{"session", "other"}, {"particles", 2000}, {"qpso1_iterations", 100'000}});
  const auto job_runs = [&] {
    return client.call("job.status", {{"job", 1}})["result"]["state"] == "running";
  };
  ASSERT_TRUE(eventually(job_runs));
  LineClient waiting = daemon.client();
  waiting.send(R"({"jsonrpc":"2.0","id":"wait","method":"job.wait","params":{"job":1}})"
               "\n");
  waiting.call("hello");  // answered after the line before it was taken
  start(client, Rig::plan(200));
  ASSERT_TRUE(eventually(
      [&] { return client.call("collect.status")["result"]["state"] == "running"; }));
  ASSERT_TRUE(job_runs());
  EXPECT_EQ(daemon.end(SIGTERM), 0);
  // The waiting client was told; nothing but files that belong there is left.
  const auto reply = waiting.read_line();
  ASSERT_TRUE(reply.has_value());
  EXPECT_EQ(Json::parse(*reply)["result"]["state"], "cancelled");
  EXPECT_FALSE(std::filesystem::exists(directory.path() / "s"));
}

TEST(Daemon, ASecondOneOnTheSameDatabaseIsRefusedInWords) {
  TempDirectory directory;
  Rig rig;
  Daemon first(directory.path(), rig.now());
  LineClient client = first.client();
  Daemon second(directory.path(), rig.now(), {}, "another");
  const int status = second.ended();
  EXPECT_TRUE(WIFEXITED(status) && WEXITSTATUS(status) == 1) << status;
  const std::string said = session::read_file(second.log().string());
  EXPECT_THAT(said, ::testing::HasSubstr("another Sixdial process"));
  EXPECT_FALSE(std::filesystem::exists(second.socket()));
  EXPECT_EQ(error_code_of(create(client, rig)), "") << "the first goes on";
}

}  // namespace
}  // namespace sixdial::service
