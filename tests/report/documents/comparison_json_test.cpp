// A comparison of an earlier version is read whole and written as it was.
#include "report/documents/comparison_json.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "report/words/comparison_words.h"
#include "studies/error.h"
#include "tests/report/documents/stored_document.h"

namespace sixdial::report {
namespace {

using ::testing::HasSubstr;

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

TEST(ComparisonWords, HaveARowForEachMethodAndNameTheBest) {
  const studies::ComparisonResult result =
      comparison_from_json(stored_document("comparison.json"));
  const std::string text = comparison_text(result);
  EXPECT_THAT(text, HasSubstr("before  "));
  EXPECT_THAT(text, ::testing::ContainsRegex("lm\\+gp .*best on G2"));
}

}  // namespace
}  // namespace sixdial::report
