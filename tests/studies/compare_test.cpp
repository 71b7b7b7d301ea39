// All methods on one session: any combination, either space, as one document.
#include "studies/compare.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <filesystem>

#include "calibration/comparison.h"
#include "calibration/random.h"
#include "report/documents/comparison_json.h"
#include "report/report_run.h"
#include "report/words/calibration_words.h"
#include "report/words/comparison_words.h"
#include "session/bundle.h"
#include "studies/assessment.h"
#include "studies/calibrate.h"
#include "studies/error.h"
#include "tests/support/paths.h"
#include "tests/support/rig_for_tests.h"

namespace sixdial::studies {
namespace {

using testing::LineClient;
using testing::RunningService;

const std::filesystem::path kBundle =
    std::filesystem::path(test_paths::test_data()) / "session_00";

CompareRequest quick() {
  CompareRequest request;
  request.particles = 20;
  request.qpso1_iterations = 6;
  request.qpso2_iterations = 60;
  request.anfis_epochs = 20;
  request.bpnn_epochs = 100;
  request.threads = 1;
  return request;
}

std::vector<std::string> every_combination() {
  std::vector<std::string> methods{"before"};
  for (const auto* identifier : calibration::all_identifiers()) {
    methods.emplace_back(identifier->name);
    for (const auto* model : calibration::all_residual_models()) {
      methods.push_back(std::string(identifier->name) + "+" + std::string(model->name));
    }
  }
  return methods;
}

void expect_figures(const std::optional<calibration::ErrorStats>& set, int points) {
  ASSERT_TRUE(set);
  EXPECT_GT(set->mean_mm, 0.0);
  EXPECT_GT(set->std_mm, 0.0);
  EXPECT_GE(set->max_mm, set->mean_mm);
  EXPECT_GE(set->rmse_mm, set->mean_mm);
  EXPECT_EQ(set->count, points);
  EXPECT_EQ(set->unreachable, 0);
}

void expect_row(const ComparedRow& method, const std::string& id, std::size_t parameters) {
  SCOPED_TRACE(id);
  EXPECT_EQ(method.id, id);
  EXPECT_FALSE(method.name.empty());
  EXPECT_FALSE(method.description.empty());
  expect_figures(method.g1, 100);
  expect_figures(method.g2, 50);
  EXPECT_EQ(method.g1_errors_mm.size(), 100U);
  EXPECT_EQ(method.g2_errors_mm.size(), 50U);
  EXPECT_GE(method.seconds(), 0.0);
  if (id == "before") {
    EXPECT_FALSE(method.identifier);
    EXPECT_FALSE(method.robot);
    EXPECT_GT(method.g2->mean_mm, 1.0);
    return;
  }
  const std::size_t plus = id.find('+');
  EXPECT_EQ(method.identifier, id.substr(0, plus));
  ASSERT_TRUE(method.robot);
  EXPECT_EQ(method.robot->parameters.size(), parameters);
  for (const auto& [name, parameter] : method.robot->parameters) {
    EXPECT_TRUE(std::isfinite(parameter.value)) << name;
    EXPECT_GT(parameter.sd, 0.0) << name;
  }
  EXPECT_LT(method.g2->mean_mm, 0.1);
  if (plus == std::string::npos) {
    EXPECT_FALSE(method.residual_model);
    EXPECT_FALSE(method.residual);
    return;
  }
  EXPECT_EQ(method.residual_model, id.substr(plus + 1));
  ASSERT_TRUE(method.residual);
  EXPECT_TRUE(method.residual->effective_parameters.allFinite());
  EXPECT_FALSE(method.residual->note.empty());
}

TEST(Compare, AnyCombinationInEitherSpaceIsAResultOfTheSameShape) {
  const session::Session session = session::read_bundle(kBundle);
  for (const char* space : {"positions", "dials"}) {
    SCOPED_TRACE(space);
    CompareRequest request = quick();
    request.space = space;
    request.methods = every_combination();
    const ComparisonResult result = compare(session, request);
    EXPECT_EQ(result.choices.space, space);
    EXPECT_EQ(result.inputs.data_hash, "sha256:" + session::data_sha256(session));
    ASSERT_EQ(result.methods.size(), request.methods.size());
    for (std::size_t i = 0; i < request.methods.size(); ++i) {
      expect_row(
          result.methods[i], request.methods[i], std::string_view(space) == "dials" ? 11 : 10);
    }
    // the best one is the least mean on G2
    const auto least = std::ranges::min_element(
        result.methods, {}, [](const ComparedRow& method) { return method.g2->mean_mm; });
    EXPECT_EQ(result.best, least->id);
    EXPECT_THAT(
        report::precision_line(*result.precision, result.choices.space),
        ::testing::HasSubstr(
            std::string_view(space) == "dials" ? "this fit of the raw readings"
                                               : "as this one of positions"));
    // what comes out of a file is what went in
    const Json document = report::to_json(result);
    EXPECT_EQ(document["schema"], "sixdial.comparison");
    EXPECT_EQ(document["schema_version"], kComparisonSchemaVersion);
    for (const char* key : {"assessment", "precision", "gross_errors"}) {
      EXPECT_TRUE(document[key].is_object()) << key;
    }
    EXPECT_EQ(document["assessment"]["space"], space);
    EXPECT_EQ(Json::parse(document.dump()), document);
    EXPECT_EQ(report::to_json(report::comparison_from_json(document)), document);
    const std::string text = report::comparison_text(result);
    for (const std::string& id : request.methods) EXPECT_NE(text.find(id), std::string::npos);
  }
}

TEST(Compare, WithoutMethodsTakesTheTwelveOfTheIssueInTheirOrder) {
  const ComparisonResult result = compare(session::read_bundle(kBundle), quick());
  std::vector<std::string> ids;
  for (const ComparedRow& method : result.methods) ids.push_back(method.id);
  EXPECT_EQ(
      ids, std::vector<std::string>(
               calibration::kComparedMethods.begin(), calibration::kComparedMethods.end()));
}

TEST(Compare, AMethodThatDoesNotExistIsRefusedWithTheNearest) {
  CompareRequest request = quick();
  request.methods = {"lm", "ekf+gpp"};
  try {
    static_cast<void>(compare(session::read_bundle(kBundle), request));
    FAIL() << "ekf+gpp was compared";
  } catch (const StudyError& error) {
    EXPECT_EQ(error.code(), StudyErrorCode::kInvalidParams);
    EXPECT_THAT(error.what(), ::testing::HasSubstr("gpp"));
  }
}

TEST(Compare, TheServiceAndABundleGiveTheSameFigures) {
  RunningService running;
  LineClient client = running.client();
  client.call("session.import", {{"path", kBundle.string()}, {"name", "here"}});
  const Json job = client.call(
      "compare.start",
      {{"session", "here"}, {"methods", {"lm", "lm+gp"}}, {"space", "dials"}})["result"];
  const Json ended = client.call("job.wait", {{"job", job["job"]}})["result"];
  ASSERT_EQ(ended["state"], "done") << ended;
  std::string text;
  for (Json next = 0; !next.is_null();) {
    const Json page =
        client.call("result.get", {{"result", ended["result"]}, {"offset", next}})["result"];
    text += page["text"].get<std::string>();
    next = page["next_offset"];
  }
  const Json stored = Json::parse(text);
  CompareRequest request;
  request.methods = {"lm", "lm+gp"};
  request.space = "dials";
  const Json alone = report::to_json(compare(session::read_bundle(kBundle), request));
  for (std::size_t i = 0; i < 2; ++i) {
    for (const char* key : {"g1_errors_mm", "g2_errors_mm", "parameters"}) {
      EXPECT_EQ(stored["methods"][i][key], alone["methods"][i][key]) << key;
    }
  }
}

/// Session 00's rig with both motors on one axis and links of four lengths, positions by some
/// other instrument.
session::Session coaxial_session() {
  session::Session session = session::read_bundle(kBundle);
  geometry::ParameterVector nominal;
  nominal << 60, 65, 58, 62, 0, 0, 0, 0, 0, 0;
  geometry::ParameterVector robot = nominal;
  robot.head<4>() << 60.2, 64.9, 58.3, 61.8;
  robot[geometry::kX0] = 0.4;
  robot[geometry::kOffset1] = 0.005;
  session.rig.robot.nominal = nominal;
  session.rig.robot.working_mode = {+1, -1};
  calibration::RandomSequence random(5, 1);
  for (session::Sample& sample : session.samples) {
    const Eigen::Vector2d target(random.uniform(-20, 20), random.uniform(60, 90));
    sample.q = geometry::inverse(nominal, target, {+1, -1}).value();
    sample.target_mm = target;
    const auto assembly = geometry::assembly_at(nominal, sample.q, target).value();
    const auto pose = geometry::forward(robot, sample.q, assembly).value();
    for (session::ChannelValue& dial : sample.channels) dial = {};
    session::set_position(
        sample, session.rig.dials.size(),
        Eigen::Vector2d(pose.p_WE + 0.003 * Eigen::Vector2d(random.normal(), random.normal())));
  }
  return session;
}

constexpr const char* kCommonTurn = "alpha rises while dtheta1 and dtheta2 fall";

void expect_common_turn(const std::vector<HeldRow>& held) {
  ASSERT_EQ(held.size(), 1U);
  EXPECT_THAT(held[0].words, ::testing::StartsWith(kCommonTurn));
  EXPECT_THAT(held[0].words, ::testing::HasSubstr("common shift"));
}

TEST(Compare, TheConfoundingOfACoaxialRobotIsNamedWithItsDistanceFittedToo) {
  const session::Session session = coaxial_session();
  for (const bool fixed : {false, true}) {
    SCOPED_TRACE(fixed ? "d fixed" : "d free");
    CompareRequest request = quick();
    request.methods = {"before", "lse", "lm", "tikhonov", "ekf", "ekf_dqpso", "lm+gp"};
    if (fixed) request.fix = {"d"};
    const ComparisonResult compared = compare(session, request);
    expect_common_turn(compared.assessment.identifiability.held);
    const std::string screen =
        ::testing::PrintToString(report::assessment_lines(compared.assessment));
    EXPECT_THAT(screen, ::testing::HasSubstr(kCommonTurn));
    for (const ComparedRow& method : compared.methods) {
      ASSERT_TRUE(method.g2) << method.id;
      EXPECT_EQ(method.g2->unreachable, 0) << method.id;
      if (method.id == "lm") {
        EXPECT_LT(method.g2->mean_mm, 0.006);
      }
    }
    CalibrationRequest calibration;
    calibration.particles = 30;
    calibration.qpso1_iterations = 20;
    calibration.qpso2_iterations = 200;
    calibration.anfis_epochs = 20;
    if (fixed) calibration.fix = {"d"};
    const CalibrationResult calibrated = calibrate(session, calibration);
    expect_common_turn(calibrated.identification.held);
    expect_common_turn(calibrated.assessment->identifiability.held);
    EXPECT_LT(calibrated.above_minimum_mm, 1e-6);
    const report::ReportData report = report::report_data(calibrated, session, "somebody");
    ASSERT_EQ(report.unidentifiable.size(), 1U);
    EXPECT_THAT(report.unidentifiable[0], ::testing::StartsWith(kCommonTurn));
  }
}

}  // namespace
}  // namespace sixdial::studies
