// What something unnamed depends on, in words.
#include <gtest/gtest.h>

#include <string>
#include <vector>

#include "report/words/diagnosis_words.h"

namespace sixdial::report {
namespace {

TEST(DependenceWords, AFewAreAllNamed) {
  EXPECT_EQ(covariates_in_words({"time"}), "time");
  EXPECT_EQ(covariates_in_words({"x", "y", "time"}), "x, y and time");
  EXPECT_EQ(
      covariates_in_words({"x", "y", "time", "gamma"}, "or"),
      "x, y, time or the cuboid's angle");
}

TEST(DependenceWords, OfManyThatDoAsWellTheLikeliestThreeAre) {
  EXPECT_EQ(
      covariates_in_words({"time", "x", "y", "gamma", "temperature"}),
      "time, x, y or one of 2 other quantities");
}

}  // namespace
}  // namespace sixdial::report
