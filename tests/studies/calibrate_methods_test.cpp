// What wins in `compare` can be used: any identifier with any residual model, from a session to
// a commanded plan, a validation on the (mocked) robot and a report.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <fstream>
#include <sstream>

#include "report/documents/calibration_json.h"
#include "report/documents/validation_json.h"
#include "report/report_run.h"
#include "report/verdict.h"
#include "report/words/calibration_words.h"
#include "report/words/validation_words.h"
#include "session/bundle.h"
#include "studies/calibrate.h"
#include "studies/compare.h"
#include "studies/method_name.h"
#include "studies/validate.h"
#include "tests/support/paths.h"
#include "tests/support/pose_session.h"
#include "tests/support/rig_for_tests.h"
#include "tests/support/simulated.h"

namespace sixdial::studies {
namespace {

using testing::error_code_of;
using ::testing::HasSubstr;
using testing::LineClient;
using testing::RunningService;
using testing::TempDirectory;

const std::filesystem::path kBundle =
    std::filesystem::path(test_paths::test_data()) / "session_00";

CalibrationRequest quick(const std::string& method) {
  CalibrationRequest request;
  request.method = method;
  request.seed = 7;
  request.particles = 20;
  request.qpso1_iterations = 10;
  request.qpso2_iterations = 40;
  return request;
}

class AnyMethod : public ::testing::TestWithParam<const char*> {};

TEST_P(AnyMethod, IsCalibratedCommandedValidatedAndReported) {
  const std::string method = GetParam();
  const auto world = testing::simple_world(5);
  session::Plan poses = session::plan_random(world.rig, 90, {.seed = 11}).value();
  for (std::size_t i = 60; i < poses.points.size(); ++i) poses.points[i].set = "G2";
  const session::Session session = testing::measured(world, poses);
  // As it is stored: what is used later comes from the document.
  const CalibrationResult result = report::calibration_from_json(
      Json::parse(report::to_json(calibrate(session, quick(method))).dump()));

  const session::Plan plan = validation_plan(session, result, {});
  ASSERT_EQ(plan.points.size(), 90U);  // 30 targets in three ways
  const session::Session measured = testing::measured(world, plan);
  const ValidationResult validated = validation_result(session, result, measured, {});
  ASSERT_EQ(validated.methods.size(), 3U);
  EXPECT_GT(validated.methods[0].errors->mean_mm, 1.0);
  const double full_mm = validated.methods[2].errors->mean_mm;
  EXPECT_LT(full_mm, 0.1);
  ASSERT_TRUE(validated.methods[2].predicted);
  EXPECT_EQ(validated.methods[2].predicted->mean_mm, result.method(method)->g2->mean_mm);
  EXPECT_EQ(
      validated.methods[1].predicted->mean_mm,
      result.method(without_residual_model(method))->g2->mean_mm);
  EXPECT_THAT(report::validation_text(validated), HasSubstr("after " + method_name(method)));
  EXPECT_EQ(report::to_json(validated)["inputs"]["calibration_method"], method);

  const report::ReportData data = report::report_data(result, session, "somebody");
  ASSERT_TRUE(report::result_index(data));
  EXPECT_EQ(data.methods[*report::result_index(data)].id, method);
  EXPECT_EQ(report::verdict(data).state, report::CalibrationState::kCalibrated);
  const auto section =
      std::ranges::find(data.sections, std::string("residual_model"), &report::Section::id);
  EXPECT_EQ(section != data.sections.end(), result.residual_model.has_value());
  TempDirectory directory;
  const auto files =
      report::write_report(result, session, "somebody", directory.path() / "report");
  std::ifstream page(directory.path() / "report" / "report.html");
  std::stringstream text;
  text << page.rdbuf();
  EXPECT_THAT(text.str(), HasSubstr(method_name(method)));
  EXPECT_THAT(report::table_6_text(result), HasSubstr(method_name(method)));
}

INSTANTIATE_TEST_SUITE_P(
    , AnyMethod, ::testing::Values("lm", "lm+gp", "ekf+rbf", "lse+bpnn"), [](const auto& each) {
      std::string name = each.param;
      for (char& letter : name) letter = letter == '+' ? '_' : letter;
      return name;
    });

TEST(CalibrationMethod, FindsTheSameFiguresAsTheComparison) {
  const session::Session session = session::read_bundle(kBundle);
  CompareRequest all;
  all.methods = {"before", "lm", "lm+gp"};
  const ComparisonResult compared = compare(session, all);
  const CalibrationResult result = calibrate(session, quick("lm+gp"));
  ASSERT_EQ(result.methods.size(), compared.methods.size());
  for (std::size_t i = 0; i < result.methods.size(); ++i) {
    EXPECT_EQ(result.methods[i].id, compared.methods[i].id);
    EXPECT_EQ(result.methods[i].g2->mean_mm, compared.methods[i].g2->mean_mm);
  }
  EXPECT_NEAR(result.above_minimum_mm, 0.0, 1e-12);
}

TEST(CalibrationMethod, AnUnknownOneIsRefusedWithTheNearest) {
  const session::Session session = session::read_bundle(kBundle);
  for (const char* method : {"lm+gq", "best", "before"}) {
    try {
      static_cast<void>(calibrate(session, quick(method)));
      ADD_FAILURE() << method << " was calibrated with";
    } catch (const StudyError& error) {
      EXPECT_EQ(error.code(), StudyErrorCode::kInvalidParams) << method;
      EXPECT_FALSE(error.hint().empty()) << method;
    }
  }
}

TEST(CalibrationMethod, HasARowWithATitleForEachPart) {
  for (const auto* each : calibration::all_identifiers()) EXPECT_FALSE(each->title.empty());
  for (const auto* each : calibration::all_residual_models()) {
    EXPECT_FALSE(each->title.empty());
  }
  EXPECT_EQ(method_name("ekf_dqpso+anfis"), "EKF-DQPSO + ANFIS");
  EXPECT_EQ(method_name("before"), "before calibration");
}

TEST(CalibrationMethod, IsTakenByTheServiceFromCalibrationToReport) {
  RunningService running;
  LineClient client = running.client();
  client.call("session.import", {{"path", kBundle.string()}, {"name", "here"}});
  EXPECT_EQ(
      error_code_of(client.call("calibrate.start", {{"session", "here"}, {"method", "lm+gq"}})),
      "invalid_params");
  const Json job =
      client.call("calibrate.start", {{"session", "here"}, {"method", "lm+gp"}})["result"];
  const Json ended = client.call("job.wait", {{"job", job["job"]}})["result"];
  ASSERT_EQ(ended["state"], "done") << ended;
  const Json summary = client.call("result.get", {{"session", "here"}})["result"]["summary"];
  EXPECT_EQ(summary["result_method"], "lm+gp");
  EXPECT_FALSE(summary["residual_model"].contains("values"));
  const auto angles = [&](const char* by) {
    return client.call(
        "compensate.target", {{"session", "here"},
                              {"x_mm", 28.0},
                              {"y_mm", 48.0},
                              {"by", by}})["result"]["theta_rad"];
  };
  EXPECT_NE(angles("full"), angles("kinematics"));
  const Json in_space = client.call(
      "compensate.target",
      {{"session", "here"}, {"x_mm", 28.0}, {"y_mm", 48.0}, {"z_mm", 0.0}});
  EXPECT_EQ(in_space["error"]["data"]["at"]["param"], "z_mm") << in_space;
  TempDirectory directory;
  const Json answer = client.call(
      "report.write", {{"session", "here"}, {"path", (directory.path() / "r").string()}});
  ASSERT_TRUE(answer.contains("result")) << answer;
}

TEST(CompensateTarget, OfARobotInSpaceNeedsZ) {
  const TempDirectory directory;
  const auto folder = directory.path() / "poses";
  session::write_bundle(testing::pose_session().session, folder);
  RunningService running;
  LineClient client = running.client();
  client.call("session.import", {{"path", folder.string()}, {"name", "arm"}});
  const Json job =
      client.call("calibrate.start", {{"session", "arm"}, {"method", "lm"}})["result"];
  ASSERT_EQ(client.call("job.wait", {{"job", job["job"]}})["result"]["state"], "done");
  Json target{{"session", "arm"}, {"x_mm", -600.0}, {"y_mm", -300.0}, {"by", "kinematics"}};
  const Json refused = client.call("compensate.target", target);
  EXPECT_EQ(error_code_of(refused), "invalid_params");
  EXPECT_EQ(refused["error"]["data"]["at"]["param"], "z_mm") << refused;
  EXPECT_THAT(refused.dump(), ::testing::Not(HasSubstr("rx,ry,rz")));
  target["z_mm"] = 400.0;
  const Json there = client.call("compensate.target", target);
  ASSERT_TRUE(there.contains("result")) << there;
  EXPECT_LT(there["result"]["closure_mm"], 1e-9);
}

}  // namespace
}  // namespace sixdial::studies
