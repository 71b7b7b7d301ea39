// A validation of an earlier version is read whole and written as it was.
#include "report/documents/validation_json.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "report/words/validation_words.h"
#include "studies/error.h"
#include "tests/report/documents/stored_document.h"

namespace sixdial::report {
namespace {

using ::testing::HasSubstr;

TEST(ValidationDocument, IsReadAndWrittenAsItWas) {
  const Json stored = stored_document("validation.json");
  const studies::ValidationResult result = validation_from_json(stored);
  ASSERT_EQ(result.methods.size(), 3U);
  EXPECT_EQ(result.methods[2].by, studies::CompensateBy::kFull);
  EXPECT_EQ(result.points.size(), 15U);
  EXPECT_EQ(result.inputs.calibration_result, 1);
  EXPECT_FALSE(result.inputs.diagnosis_result);
  expect_same_document(to_json(result), stored);
}

TEST(ValidationDocument, OfAWayThatIsUnknownIsRefusedByItsKey) {
  Json document = stored_document("validation.json");
  document["methods"][1]["id"] = "magic";
  try {
    static_cast<void>(validation_from_json(document));
    FAIL() << "an unknown way was taken";
  } catch (const studies::StudyError& error) {
    EXPECT_THAT(error.what(), HasSubstr("methods[1].id is \"magic\""));
  }
}

TEST(ValidationWords, HaveALineForEachWayAndADashWhereNothingWasMeasured) {
  studies::ValidationResult result = validation_from_json(stored_document("validation.json"));
  result.methods[2].errors.reset();
  const std::string text = validation_text(result);
  EXPECT_THAT(text, HasSubstr("after kinematics             0.0103"));
  EXPECT_THAT(
      text,
      HasSubstr("after kinematics + ANFIS          -        -        -       0     0.0059"));
}

}  // namespace
}  // namespace sixdial::report
