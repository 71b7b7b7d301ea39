// The verdict as a job of the service, and cancelled.
#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <fstream>
#include <map>
#include <random>
#include <set>

#include "report/documents/diagnosis_json.h"
#include "report/report_run.h"
#include "report/sections/sections_of_studies.h"
#include "session/bundle.h"
#include "session/trials.h"
#include "studies/calibrate.h"
#include "studies/diagnose.h"
#include "tests/studies/diagnosis_parts.h"
#include "tests/support/job_answers.h"
#include "tests/support/paths.h"
#include "tests/support/rig_for_tests.h"

namespace sixdial::studies {
namespace {

namespace fs = std::filesystem;
using testing::error_code_of;
using ::testing::HasSubstr;
using testing::LineClient;
using testing::RunningService;

using testing::finished;
using testing::whole_result;

TEST(DiagnosisJob, GivesThroughTheSocketWhatTheBundleGivesHere) {
  RunningService running;
  LineClient client = running.client();
  client.call("session.import", {{"path", (kSessions / "06").string()}, {"name", "demo"}});
  EXPECT_EQ(error_code_of(client.call("diagnose.start", {{"session", "demu"}})), "not_found");
  EXPECT_EQ(
      error_code_of(client.call("diagnose.start", {{"session", "demo"}, {"bootstrap", -1}})),
      "invalid_params");
  EXPECT_EQ(
      error_code_of(client.call(
          "diagnose.report",
          {{"session", "demo"}, {"path", (running.directory() / "none.html").string()}})),
      "not_found");

  const Json done = finished(
      client,
      client.call(
          "diagnose.start",
          {{"session", "demo"}, {"seed", 5}, {"bootstrap", 0}, {"gain", false}})["result"]);
  ASSERT_EQ(done["state"], "done") << done;
  EXPECT_EQ(done["kind"], "diagnosis");
  const Json stored = whole_result(client, done["result"]);
  DiagnosisRequest request;
  request.seed = 5;
  request.bootstrap = 0;
  request.with_gain = false;
  const Json here = report::to_json(diagnose(session_of("06"), request));
  for (const char* key : {"causes", "detection_limits", "extended", "residuals", "verdict"}) {
    EXPECT_EQ(stored[key], here[key]) << key;
  }
  const Json record = client.call("result.get", {{"result", done["result"]}})["result"];
  EXPECT_EQ(record["data_hash"], here["inputs"]["data_hash"]);
  EXPECT_EQ(record["rig_hash"], here["inputs"]["rig_hash"]);
  EXPECT_EQ(record["seed"], 5);
  EXPECT_EQ(record["summary"]["verdict"], here["verdict"]);

  const fs::path page = running.directory() / "diagnosis.html";
  EXPECT_EQ(
      client.call(
          "diagnose.report",
          {{"session", "demo"}, {"path", page.string()}})["result"]["result"],
      done["result"]);
  EXPECT_GT(fs::file_size(page), 50'000U);
  EXPECT_EQ(
      error_code_of(
          client.call("diagnose.report", {{"session", "demo"}, {"path", "page.html"}})),
      "invalid_params");

  // The report of a calibration shows it too.
  const Json calibrated = finished(
      client, client.call(
                  "calibrate.start", {{"session", "demo"},
                                      {"particles", 10},
                                      {"qpso1_iterations", 5},
                                      {"qpso2_iterations", 20},
                                      {"anfis_epochs", 5}})["result"]);
  ASSERT_EQ(calibrated["state"], "done") << calibrated;
  const Json written = client.call(
      "report.write",
      {{"session", "demo"}, {"path", (running.directory() / "report").string()}})["result"];
  EXPECT_EQ(written["diagnosis"], done["result"]);
  EXPECT_THAT(written["files"], ::testing::Contains("diagnosis.json"));
  std::ifstream html(running.directory() / "report" / "report.html");
  const std::string text((std::istreambuf_iterator<char>(html)), {});
  EXPECT_THAT(text, HasSubstr("State of the robot"));
  EXPECT_THAT(text, HasSubstr("Eccentricity of joint 2"));
}

TEST(DiagnosisJob, CancelledItLeavesNoResult) {
  RunningService running;
  LineClient client = running.client();
  client.call("session.import", {{"path", (kSessions / "17").string()}, {"name", "demo"}});
  const Json job = client.call("diagnose.start", {{"session", "demo"}})["result"];
  client.call("job.cancel", {{"job", job["job"]}});
  EXPECT_EQ(finished(client, job)["state"], "cancelled");
  EXPECT_TRUE(client.call("result.list", {{"session", "demo"}})["result"]["results"].empty());
}

}  // namespace
}  // namespace sixdial::studies
