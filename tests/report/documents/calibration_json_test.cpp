// A calibration of an earlier version is read whole and written as it was; any method's result
// goes through its document.
#include "report/documents/calibration_json.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>

#include "report/documents/summary.h"
#include "session/bundle.h"
#include "studies/calibrate.h"
#include "studies/compensate.h"
#include "studies/error.h"
#include "tests/report/documents/stored_document.h"

namespace sixdial::report {
namespace {

using ::testing::HasSubstr;

std::string refused(const Json& document) {
  try {
    static_cast<void>(calibration_from_json(document));
  } catch (const studies::StudyError& error) {
    EXPECT_EQ(error.code(), studies::StudyErrorCode::kBadData);
    return error.what();
  }
  return "";
}

TEST(CalibrationDocument, IsReadAndWrittenAsItWas) {
  const Json stored = stored_document("calibration.json");
  const studies::CalibrationResult result = calibration_from_json(stored);
  EXPECT_EQ(result.inputs.seed, 7U);
  EXPECT_EQ(result.result_method, studies::kPaperMethod);
  EXPECT_EQ(result.settings.profile, calibration::Profile::kPaper);
  EXPECT_EQ(result.settings.qpso2.iterations, 10);
  ASSERT_EQ(result.parameters.size(), 10U);
  EXPECT_EQ(result.identified()[3], stored["parameters"][3]["identified"]);
  EXPECT_EQ(result.points.size(), 30U);
  ASSERT_TRUE(result.networks);
  EXPECT_EQ(result.networks->x.samples, stored["anfis"]["x"]["samples"]);
  ASSERT_TRUE(result.assessment);
  EXPECT_EQ(result.assessment->samples, 24);
  EXPECT_FALSE(result.residual_model);
  expect_same_document(to_json(result), stored);
}

TEST(CalibrationDocument, OfAnEarlyVersionHasNoAssessment) {
  Json document = stored_document("calibration.json");
  for (const char* key : {"assessment", "precision", "gross_errors"}) document.erase(key);
  for (const char* axis : {"x", "y"}) document["anfis"][axis].erase("samples");
  const studies::CalibrationResult result = calibration_from_json(document);
  EXPECT_FALSE(result.assessment);
  EXPECT_FALSE(result.gross_errors);
  EXPECT_EQ(result.networks->x.samples, 0);
  expect_same_document(to_json(result), document);
}

TEST(CalibrationDocument, SaysWhichKeyIsMissingOrWrong) {
  const Json stored = stored_document("calibration.json");
  EXPECT_EQ(refused(stored), "");
  Json document = stored;
  document["parameters"][2].erase("sd");
  EXPECT_THAT(refused(document), HasSubstr("parameters[2].sd is missing"));
  document = stored;
  document["assessment"]["noise"]["source"] = "rumour";
  EXPECT_THAT(refused(document), HasSubstr("assessment.noise.source is \"rumour\""));
  document = stored;
  document["inputs"]["settings"]["qpso1"]["particles"] = "many";
  EXPECT_THAT(refused(document), HasSubstr("inputs.settings.qpso1.particles"));
  document = stored;
  document["anfis"]["x"]["consequents"].erase(0);
  EXPECT_THAT(refused(document), HasSubstr("consequents"));
  document = stored;
  document["schema_version"] = kAnyMethodSchemaVersion + 1;
  EXPECT_THAT(refused(document), HasSubstr("version"));
  document["schema"] = "sixdial.comparison";
  EXPECT_THAT(refused(document), HasSubstr("sixdial.comparison"));
  EXPECT_THAT(refused(Json::array()), HasSubstr("sixdial.calibration"));
}

class CalibrationByMethod : public ::testing::TestWithParam<const char*> {};

TEST_P(CalibrationByMethod, GoesThroughItsDocumentToTheSameRobotBitForBit) {
  const session::Session session =
      session::read_bundle(std::filesystem::path(test_paths::test_data()) / "session_00");
  studies::CalibrationRequest request;
  request.method = GetParam();
  request.qpso1_iterations = 10;
  request.qpso2_iterations = 40;
  const studies::CalibrationResult result = studies::calibrate(session, request);
  EXPECT_EQ(result.result_method, GetParam());
  ASSERT_NE(result.method(result.result_method), nullptr);
  EXPECT_LT(result.method(result.result_method)->g2->mean_mm, 0.1);
  const Json document = Json::parse(to_json(result).dump());
  EXPECT_EQ(document["schema_version"], kAnyMethodSchemaVersion);
  EXPECT_FALSE(document_summary(document).dump().size() > 60'000);
  const studies::CalibrationResult loaded = calibration_from_json(document);
  expect_same_document(to_json(loaded), document);

  const auto now =
      studies::compensation_model(result, session.rig, studies::CompensateBy::kFull);
  const auto later =
      studies::compensation_model(loaded, session.rig, studies::CompensateBy::kFull);
  EXPECT_EQ(now.v, later.v);
  const bool has_model = result.result_method.find('+') != std::string::npos;
  ASSERT_EQ(static_cast<bool>(now.correction), has_model);
  const std::size_t kinematic = 1;
  const std::size_t full = result.methods.size() - 1;
  for (const studies::PointResiduals& point : loaded.points) {
    if (!has_model) break;
    const auto& q_rad = session.samples[static_cast<std::size_t>(point.sample)].q;
    EXPECT_EQ(now.correction(q_rad), later.correction(q_rad));
    // What the model adds is what it takes from the residuals of the parameters alone.
    const Eigen::Vector2d learned =
        point.residual_mm.at(kinematic).value() - point.residual_mm.at(full).value();
    EXPECT_LT((later.correction(q_rad) - learned).norm(), 1e-12);
  }
}

TEST_P(CalibrationByMethod, RefusesADamagedResidualModelByName) {
  const session::Session session =
      session::read_bundle(std::filesystem::path(test_paths::test_data()) / "session_00");
  studies::CalibrationRequest request;
  request.method = GetParam();
  request.qpso1_iterations = 5;
  request.qpso2_iterations = 10;
  studies::CalibrationResult result = studies::calibrate(session, request);
  if (!result.residual_model) {
    EXPECT_EQ(result.result_method.find('+'), std::string::npos);
    return;
  }
  result.residual_model->saved.erase(result.residual_model->saved.begin());
  EXPECT_THROW(
      static_cast<void>(
          studies::compensation_model(result, session.rig, studies::CompensateBy::kFull)),
      studies::StudyError);
  result.residual_model->name = "crystal_ball";
  EXPECT_THROW(
      static_cast<void>(
          studies::compensation_model(result, session.rig, studies::CompensateBy::kFull)),
      studies::StudyError);
}

INSTANTIATE_TEST_SUITE_P(
    , CalibrationByMethod,
    ::testing::Values(
        "lm", "lm+gp", "ekf+rbf", "lse+bpnn", "ekf_dqpso+gp", "lm+anfis", "lm+anfis_paper"),
    [](const auto& each) {
      std::string name = each.param;
      for (char& letter : name) letter = letter == '+' ? '_' : letter;
      return name;
    });

}  // namespace
}  // namespace sixdial::report
