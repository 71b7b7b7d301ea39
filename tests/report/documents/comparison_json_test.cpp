// A comparison of an earlier version is read whole and written as it was.
#include "report/documents/comparison_json.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "report/sections/sections_of_studies.h"
#include "report/words/comparison_words.h"
#include "studies/error.h"
#include "tests/report/documents/stored_document.h"

namespace sixdial::report {
namespace {

using ::testing::HasSubstr;
using ::testing::Not;

/// Its paragraphs, one after the other.
std::string text_of(const std::vector<Section>& sections) {
  std::string text;
  for (const Section& section : sections) {
    for (const auto& block : section.blocks) {
      if (const auto* paragraph = std::get_if<std::string>(&block)) text += *paragraph + '\n';
    }
  }
  return text;
}

TEST(ComparisonDocument, IsReadAndWrittenAsItWas) {
  const Json stored = stored_document("comparison.json");
  const studies::ComparisonResult result = comparison_from_json(stored);
  EXPECT_EQ(result.inputs.seed, 7U);
  EXPECT_EQ(result.best, "lm+gp");
  ASSERT_EQ(result.methods.size(), 3U);
  EXPECT_FALSE(result.methods[0].robot);
  EXPECT_EQ(result.methods[0].g1_errors_mm.size(), 100U);
  ASSERT_TRUE(result.methods[2].residual);
  EXPECT_EQ(
      result.methods[2].residual->effective_parameters.x(),
      stored["methods"][2]["effective_parameters"][0]);
  EXPECT_EQ(result.methods[1].robot->status, calibration::FitStatus::kConverged);
  expect_same_document(to_json(result), stored);
}

TEST(ComparisonDocument, SaysWhichKeyIsWrong) {
  Json document = stored_document("comparison.json");
  document["methods"][1]["g2"]["mean_mm"] = "small";
  try {
    static_cast<void>(comparison_from_json(document));
    FAIL() << "a word was taken for a number";
  } catch (const studies::StudyError& error) {
    EXPECT_EQ(error.code(), studies::StudyErrorCode::kBadData);
    EXPECT_THAT(error.what(), HasSubstr("methods[1].g2.mean_mm"));
  }
  document = stored_document("comparison.json");
  document["schema_version"] = studies::kComparisonSchemaVersion + 1;
  EXPECT_THROW(static_cast<void>(comparison_from_json(document)), studies::StudyError);
}

TEST(ComparisonDocument, HasTheRigThatTheMethodsWereGiven) {
  studies::ComparisonResult result = comparison_from_json(stored_document("comparison.json"));
  EXPECT_FALSE(to_json(result).contains("rig"));  // the file states nothing
  const std::string unsaid = comparison_text(result);
  result.rig = {
      {.name = "place of dial C across its axis",
       .unit = "mm",
       .off = 0.14,
       .sd = 0.01,
       .known_sd = 0.1,
       .stated = true}};
  const Json document = to_json(result);
  EXPECT_EQ(document["rig"][0]["off"], 0.14);
  const auto again = comparison_from_json(document);
  ASSERT_TRUE(again.rig);
  EXPECT_EQ(again.rig->front().name, result.rig->front().name);
  EXPECT_EQ(to_json(again), document);
  EXPECT_THAT(comparison_text(again), HasSubstr("place of dial C across its axis 0.14"));
  EXPECT_THAT(unsaid, Not(HasSubstr("dial C")));
  EXPECT_THAT(
      text_of(comparison_sections(again)), HasSubstr("place of dial C across its axis"));
  result.rig.reset();
  EXPECT_THAT(text_of(comparison_sections(result)), Not(HasSubstr("dial C")));
}

TEST(ComparisonWords, HaveARowForEachMethodAndNameTheBest) {
  const studies::ComparisonResult result =
      comparison_from_json(stored_document("comparison.json"));
  const std::string text = comparison_text(result);
  EXPECT_THAT(text, HasSubstr("before  "));
  EXPECT_THAT(text, ::testing::ContainsRegex("lm\\+gp .*best on G2"));
}

}  // namespace
}  // namespace sixdial::report
