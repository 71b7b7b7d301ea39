// From a bundle to a stored result and a report: with and without a service, the same figures.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <fstream>
#include <sstream>

#include "report/documents/calibration_json.h"
#include "report/report_run.h"
#include "report/words/calibration_words.h"
#include "session/bundle.h"
#include "studies/calibrate.h"
#include "tests/support/paths.h"
#include "tests/support/rig_for_tests.h"

namespace sixdial::studies {
namespace {

using testing::error_code_of;
using testing::eventually;
using testing::LineClient;
using testing::RunningService;
using testing::TempDirectory;

// A norm of two coordinates against the same norm taken elsewhere: rounding only.
constexpr double kSameError_mm = 1e-12;
// Session 00 has noise of 0.002 mm a dial and no other cause: mean errors of about that size.
constexpr double kNoiseOnly_mm = 0.006;

const std::filesystem::path kBundle =
    std::filesystem::path(test_paths::test_data()) / "session_00";

CalibrationRequest quick() {
  CalibrationRequest request;
  request.seed = 7;
  request.particles = 20;
  request.qpso1_iterations = 10;
  request.qpso2_iterations = 60;
  request.anfis_epochs = 20;
  return request;
}

Json quick_params(const std::string& session) {
  return {{"session", session},     {"seed", 7},
          {"particles", 20},        {"qpso1_iterations", 10},
          {"qpso2_iterations", 60}, {"anfis_epochs", 20}};
}

/// What the calibration found, without clocks and names.
Json figures(Json document) {
  document.erase("created_utc");
  document.erase("seconds");
  document.erase("stages");
  document["inputs"].erase("session");
  for (Json& method : document["methods"]) method.erase("seconds");
  return document;
}

const Json& method_of(const Json& document, const std::string& id) {
  for (const Json& method : document["methods"]) {
    if (method["id"] == id) return method;
  }
  throw std::runtime_error("no method " + id);
}

Json whole_result(LineClient& client, std::int64_t result) {
  std::string text;
  for (;;) {
    const Json page =
        client.call("result.get", {{"result", result}, {"offset", text.size()}})["result"];
    text += page["text"].get<std::string>();
    if (page["next_offset"].is_null()) return Json::parse(text);
  }
}

TEST(Calibration, ABundleGivesItsNoiseAsErrorAndTheInputsOfTheResult) {
  const session::Session session = session::read_bundle(kBundle);
  std::vector<std::string> stages;
  const Json document =
      report::to_json(calibrate(session, quick(), [&](const Progress& progress) {
        if (stages.empty() || stages.back() != progress.stage) stages.push_back(progress.stage);
      }));
  EXPECT_EQ(document["schema"], "sixdial.calibration");
  EXPECT_GT(method_of(document, "before")["g2"]["mean_mm"], 1.0);
  EXPECT_LT(method_of(document, "ekf_dqpso")["g2"]["mean_mm"], kNoiseOnly_mm);
  EXPECT_LT(method_of(document, "ekf_dqpso+anfis")["g2"]["mean_mm"], kNoiseOnly_mm);
  EXPECT_EQ(document["inputs"]["seed"], 7);
  EXPECT_EQ(document["inputs"]["rig_hash"], "sha256:" + session::rig_sha256(session));
  EXPECT_EQ(document["inputs"]["data_hash"], "sha256:" + session::data_sha256(session));
  EXPECT_EQ(document["inputs"]["settings"]["qpso2"]["iterations"], 60);
  EXPECT_THAT(stages, ::testing::IsSupersetOf({"qpso1", "qpso2"}));
}

TEST(Calibration, ResidualsOfThePointsAreTheErrorsOfTableSix) {
  const Json document = report::to_json(calibrate(session::read_bundle(kBundle), quick()));
  const std::size_t methods = document["methods"].size();
  ASSERT_GE(methods, 4U);
  for (std::size_t m = 0; m < methods; ++m) {
    double sum_mm = 0.0;
    double max_mm = 0.0;
    int count = 0;
    for (const Json& point : document["points"]) {
      if (point["set"] != "G2") continue;
      const Json& residual = point["residual_mm"][m];
      const double error_mm = std::hypot(residual[0].get<double>(), residual[1].get<double>());
      sum_mm += error_mm;
      max_mm = std::max(max_mm, error_mm);
      ++count;
    }
    EXPECT_EQ(count, 50);
    const Json& row = document["methods"][m];
    EXPECT_NEAR(sum_mm / count, row["g2"]["mean_mm"].get<double>(), kSameError_mm) << row["id"];
    EXPECT_NEAR(max_mm, row["g2"]["max_mm"].get<double>(), kSameError_mm) << row["id"];
  }
}

TEST(Calibration, TheTableOnTheScreenHasThePapersRowsInItsOrder) {
  const std::string text =
      report::table_6_text(calibrate(session::read_bundle(kBundle), quick()));
  const std::size_t before = text.find("before calibration");
  const std::size_t dqpso = text.find("EKF-DQPSO ");
  const std::size_t anfis = text.find("EKF-DQPSO + ANFIS");
  EXPECT_LT(before, dqpso);
  EXPECT_LT(dqpso, anfis);
  EXPECT_NE(anfis, std::string::npos);
}

TEST(Calibration, TooFewSamplesAreRefusedInWords) {
  session::Session session = session::read_bundle(kBundle);
  session.samples.resize(2);
  try {
    static_cast<void>(calibrate(session, quick()));
    FAIL() << "two samples were calibrated";
  } catch (const StudyError& error) {
    EXPECT_EQ(error.code(), StudyErrorCode::kBadData);
  }
}

TEST(Calibration, TheServiceAndABundleGiveTheSameFigures) {
  RunningService running;
  LineClient client = running.client();
  client.call("session.import", {{"path", kBundle.string()}, {"name", "here"}});
  Json params = quick_params("here");
  params["threads"] = 2;
  const Json job = client.call("calibrate.start", params)["result"];
  EXPECT_EQ(job["kind"], "calibration");
  const Json ended = client.call("job.wait", {{"job", job["job"]}})["result"];
  ASSERT_EQ(ended["state"], "done") << ended;
  const Json stored = whole_result(client, ended["result"].get<std::int64_t>());
  CalibrationRequest alone = quick();
  alone.threads = 1;
  EXPECT_EQ(
      figures(stored),
      figures(Json::parse(
          report::to_json(calibrate(session::read_bundle(kBundle), alone)).dump())));
}

TEST(Calibration, AResultOutlivesTheServiceAndMakesTheSameReport) {
  TempDirectory directory;
  service::ServiceOptions options;
  options.database = directory.path() / "kept.db";
  std::int64_t job = 0;
  {
    RunningService running({}, options);
    LineClient client = running.client();
    client.call("session.import", {{"path", kBundle.string()}, {"name", "here"}});
    job = client.call("calibrate.start", quick_params("here"))["result"]["job"];
    ASSERT_EQ(client.call("job.wait", {{"job", job}})["result"]["state"], "done");
  }
  RunningService running({}, options);
  LineClient client = running.client();
  const Json old = client.call("job.status", {{"job", job}})["result"];
  EXPECT_EQ(old["state"], "done");
  EXPECT_EQ(old["session"], "here");
  ASSERT_EQ(old["result"], 1);
  const auto folder = directory.path() / "report";
  const Json answer =
      client.call("report.write", {{"session", "here"}, {"path", folder.string()}});
  ASSERT_TRUE(answer.contains("result")) << answer;
  for (const Json& file : answer["result"]["files"]) {
    EXPECT_GT(std::filesystem::file_size(folder / file.get<std::string>()), 0U) << file;
  }
  std::ifstream html(folder / "report.html");
  std::stringstream page;
  page << html.rdbuf();
  const Json document = whole_result(client, 1);
  EXPECT_THAT(
      page.str(),
      ::testing::HasSubstr(document["inputs"]["data_hash"].get<std::string>().substr(7, 16)));
  // The bundle in the report is the bundle that came in.
  EXPECT_EQ(
      session::data_sha256(session::read_bundle(folder / "bundle")),
      session::data_sha256(session::read_bundle(kBundle)));
}

TEST(Calibration, AReportFromOtherDataThanTheResultsIsRefused) {
  session::Session session = session::read_bundle(kBundle);
  const CalibrationResult result = calibrate(session, quick());
  const report::ReportData data = report::report_data(result, session, "somebody");
  EXPECT_EQ(data.points.size(), 150U);
  EXPECT_EQ(data.parameters.size(), 10U);
  session.samples.pop_back();
  EXPECT_THROW(static_cast<void>(report::report_data(result, session, "somebody")), StudyError);
  EXPECT_THROW(
      static_cast<void>(report::calibration_from_json({{"schema", "other"}})), StudyError);
}

TEST(Calibration, IsCancelledAsAJob) {
  RunningService running;
  LineClient client = running.client();
  client.call("session.import", {{"path", kBundle.string()}, {"name", "here"}});
  const Json job = client.call(
      "calibrate.start",
      {{"session", "here"}, {"particles", 1000}, {"qpso1_iterations", 100'000}})["result"];
  ASSERT_TRUE(eventually([&] {
    const Json status = client.call("job.status", {{"job", job["job"]}})["result"];
    return status["progress"]["done"] > 0;
  }));
  client.call("job.cancel", {{"job", job["job"]}});
  const Json ended = client.call("job.wait", {{"job", job["job"]}})["result"];
  EXPECT_EQ(ended["state"], "cancelled");
  EXPECT_TRUE(ended["result"].is_null());
  EXPECT_EQ(client.call("result.list", {{"session", "here"}})["result"]["results"].size(), 0U);
  EXPECT_EQ(error_code_of(client.call("result.get", {{"session", "here"}})), "not_found");
}

}  // namespace
}  // namespace sixdial::studies
