// Figures, axes and joints as people read them: no exponents, no axis too few, no names that
// the robot does not have, no limit that is larger than anything plausible.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <string>

#include "report/words/diagnosis_axes.h"
#include "report/words/diagnosis_text.h"
#include "report/words/diagnosis_words.h"
#include "report/words/warning_words.h"
#include "simulation/effect_words.h"

namespace sixdial::report {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;
using ::testing::Not;

TEST(Digits, HaveNoExponentWhereAPersonReads) {
  using simulation::in_digits;
  EXPECT_EQ(in_digits(204.0, 2), "200");
  EXPECT_EQ(in_digits(99.6, 2), "100");
  EXPECT_EQ(in_digits(44523.0, 3), "44500");
  EXPECT_EQ(in_digits(-1234.5, 3), "-1230");
  EXPECT_EQ(in_digits(3.164e-5, 3), "0.0000316");
  EXPECT_EQ(in_digits(0.0999, 2), "0.1");
  EXPECT_EQ(in_digits(0.05, 3), "0.05");
  EXPECT_EQ(in_digits(12.0, 3), "12");
  EXPECT_EQ(in_digits(100.0, 3), "100");
  EXPECT_EQ(in_digits(0.0, 3), "0");
  EXPECT_EQ(in_digits(std::numeric_limits<double>::infinity(), 3), "inf");
  EXPECT_EQ(in_digits(std::nan(""), 3), "nan");
  // Whatever is said keeps so many digits of the value.
  for (double value = 1.3e-8; value < 1e11; value *= 1.7) {
    for (const int digits : {2, 3, 4}) {
      const std::string said = in_digits(value, digits);
      EXPECT_EQ(said.find('e'), std::string::npos) << said;
      EXPECT_NEAR(std::stod(said), value, 0.5001 * value * std::pow(10.0, 1 - digits)) << said;
    }
  }
  EXPECT_EQ(quantity_in_words(0.0445, std::nan(""), "1/K"), "44500 \u00B5m/(m\u00B7K)");
  EXPECT_EQ(quantity_in_words(3.16e-5, std::nan(""), "rad/m"), "0.0000316 rad/m");
}

TEST(Digits, OfAWarningHaveNoExponent) {
  studies::Warning warning;
  warning.code = "far_position";
  warning.parts["apart"] = 12345.0;
  warning.parts["usual"] = 0.00001234;
  const std::string words = warnings_text({warning});
  EXPECT_THAT(words, HasSubstr("12300 from the middle"));
  EXPECT_THAT(words, HasSubstr("0.0000123 is usual"));
}

studies::DiagnosisResult scattering(diagnosis::ScatterIn in) {
  studies::DiagnosisResult result;
  result.noise.sigma_mm = 0.01;
  result.has_dials = false;
  result.unexplained.significant = true;
  result.unexplained.scatter = true;
  result.unexplained.rms_mm = 0.2;
  result.unexplained.scatter_size =
      diagnosis::ScatterFound{.in = in, .sd_mm = 0.204, .low_mm = 0.0955, .high_mm = 1.31};
  return result;
}

/// The text in one line.
std::string unwrapped(std::string text) {
  for (char& letter : text) letter = letter == '\n' ? ' ' : letter;
  return text;
}

TEST(ScatterWords, NameEveryAxisAndMicrometresInFull) {
  for (const auto in : {diagnosis::ScatterIn::kJoints, diagnosis::ScatterIn::kTool}) {
    studies::DiagnosisResult result = scattering(in);
    EXPECT_THAT(
        unwrapped(diagnosis_text(result)),
        AllOf(
            HasSubstr("by 200 \u00B5m (one standard deviation; 95 % interval 96 to 1300 "
                      "\u00B5m) in x and in y"),
            Not(HasSubstr("in z")), Not(HasSubstr("dials of a sample"))));
    result.tool_shifts.z_mm.emplace();
    EXPECT_THAT(unwrapped(diagnosis_text(result)), HasSubstr("in x, in y and in z"));
  }
}

TEST(LimitWords, ASizeThatNothingHasIsNoLimit) {
  studies::DiagnosisResult result;
  result.limits = {
      {.id = {"frame_skew", "frame"},
       .parameter = "s",
       .unit = "rad",
       .detect = 1.05,
       .name = 1.07,
       .plausible = 0.0003},
      {.id = {"joint_backlash", "joint1"},
       .parameter = "b",
       .unit = "rad",
       .detect = 0.0004,
       .name = 0.05,
       .plausible = 0.0004},
      {.id = {"joint_backlash", "joint2"},
       .parameter = "b",
       .unit = "rad",
       .detect = 0.0008,
       .name = 0.0009,
       .plausible = 0.0004}};
  const std::string text = diagnosis_text(result);
  EXPECT_THAT(
      text, AllOf(
                HasSubstr("at no plausible size          at no plausible size\n"),
                Not(HasSubstr("60.")), Not(HasSubstr("61."))));
  EXPECT_THAT(text, HasSubstr("0.0229\u00B0 to 0.0458\u00B0"));
  EXPECT_THAT(text, HasSubstr("0.0516\u00B0 or never"));  // told at the second joint alone
  EXPECT_THAT(unwrapped(text), HasSubstr("this session cannot show it"));
  result.limits.erase(result.limits.begin());
  EXPECT_THAT(unwrapped(diagnosis_text(result)), Not(HasSubstr("cannot show it")));
  // A result of a version that knew no size to expect says what it found.
  studies::Limit old{.detect = 1.0};
  EXPECT_FALSE(is_beyond_plausible(old, 1.0));
}

TEST(JointWords, AreOfAnyRobot) {
  EXPECT_EQ(covariate_in_words("theta3"), "the value of joint 3");
  EXPECT_EQ(covariates_in_words({"theta1", "x"}, "or"), "the value of joint 1 or x");
  EXPECT_EQ(axis_in_words({studies::CurveAxis::kJointAngle, 1}), "angle of joint 2");
  EXPECT_EQ(axis_in_words({studies::CurveAxis::kJointSlide, 2}), "travel of joint 3");
  EXPECT_EQ(axis_in_words({.axis = studies::CurveAxis::kTime}), "time");
}

}  // namespace
}  // namespace sixdial::report
