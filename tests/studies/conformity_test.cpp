// The decision rule on a tolerance, and what the uncertainty of a measured position is made of.
#include "studies/conformity.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "geometry/rig.h"
#include "session/bundle.h"
#include "session/trials.h"
#include "studies/calibrate.h"
#include "tests/support/paths.h"

namespace sixdial::studies {
namespace {

// JCGM 106:2012, 8.3: guarded acceptance and guarded rejection, with a guard band of U.
TEST(Conformity, GuardBandsOnBothSidesOfTheTolerance) {
  EXPECT_EQ(decide(0.012, 0.006, 0.020), Decision::kAccepted);
  EXPECT_EQ(decide(0.014, 0.006, 0.020), Decision::kAccepted);  // the limit belongs to it
  EXPECT_EQ(decide(0.015, 0.006, 0.020), Decision::kUndecided);
  EXPECT_EQ(decide(0.025, 0.006, 0.020), Decision::kUndecided);
  EXPECT_EQ(decide(0.026, 0.006, 0.020), Decision::kUndecided);  // not above it
  EXPECT_EQ(decide(0.027, 0.006, 0.020), Decision::kRejected);
}

TEST(Conformity, WhatNobodyKnowsDecidesNothing) {
  constexpr double kUnknown = std::numeric_limits<double>::quiet_NaN();
  EXPECT_EQ(decide(0.001, kUnknown, 1.0), Decision::kUndecided);
  EXPECT_EQ(decide(kUnknown, 0.001, 1.0), Decision::kUndecided);
}

session::Session stored_session() {
  return session::read_bundle(test_paths::source_dir() + "/tests/data/sessions/01");
}

TEST(Conformity, ScatterAndTheMakersLimitOfErrorBothCount) {
  session::Session session = stored_session();
  for (geometry::Dial& dial : session.rig.dials) dial.accuracy_mm = 0.0;
  const auto scatter_mm = position_uncertainty_mm(session.rig, session.samples.front());
  ASSERT_TRUE(scatter_mm);
  const double dial_mm = session::reading_sigma_mm(session.rig.dials.front());
  // Three dials at right angles: the worst direction has one dial's scatter, at least its half.
  EXPECT_GT(*scatter_mm, 0.5 * dial_mm);
  EXPECT_LT(*scatter_mm, 2.0 * dial_mm);
  // A limit of error of sqrt(3) times the scatter is a rectangle with the scatter's deviation.
  for (geometry::Dial& dial : session.rig.dials) dial.accuracy_mm = std::sqrt(3.0) * dial_mm;
  const auto both_mm = position_uncertainty_mm(session.rig, session.samples.front());
  ASSERT_TRUE(both_mm);
  constexpr double kExact = 1e-9;  // a few flops on values of order 1e-3
  EXPECT_LT(std::abs(*both_mm / *scatter_mm - std::sqrt(2.0)), kExact);
}

TEST(Conformity, ACalibrationIsJudgedByTheRequestElseByTheRigFile) {
  session::Session session = stored_session();
  CalibrationRequest request;
  request.method = "lm";
  EXPECT_FALSE(calibrate(session, request).conformity);
  request.tolerance_mm = 10.0;
  const CalibrationResult wide = calibrate(session, request);
  ASSERT_TRUE(wide.conformity);
  EXPECT_EQ(wide.conformity->decision, Decision::kAccepted);
  EXPECT_EQ(wide.conformity->set, "G2");
  EXPECT_EQ(wide.conformity->accepted, wide.conformity->points);
  EXPECT_EQ(wide.conformity->points, wide.method("lm")->g2->points);
  session.rig.tolerance_mm = 1e-6;
  request.tolerance_mm.reset();
  const CalibrationResult narrow = calibrate(session, request);
  ASSERT_TRUE(narrow.conformity);
  EXPECT_NE(narrow.conformity->decision, Decision::kAccepted);
  EXPECT_EQ(narrow.conformity->accepted, 0);
  // The largest error with its U is what the words name: it cannot be above the set's maximum.
  EXPECT_LE(narrow.conformity->largest_mm, narrow.method("lm")->g2->max_mm + 1e-12);
}

TEST(Conformity, WhereOnlyTheLargestErrorIsKnownEachPointIsAtMostThat) {
  const session::Session session = stored_session();
  const Conformity kept = conformity_of_largest(session, {}, 0.01, 50, 1.0);
  EXPECT_EQ(kept.decision, Decision::kAccepted);
  EXPECT_EQ(kept.accepted, 50);
  double largest_mm = 0.0;
  for (const session::Sample& sample : session.samples) {
    if (sample.set != "G2") continue;
    largest_mm =
        std::max(largest_mm, 2.0 * position_uncertainty_mm(session.rig, sample).value_or(0.0));
  }
  EXPECT_EQ(kept.expanded_mm, largest_mm);
  EXPECT_EQ(conformity_of_largest(session, {}, 2.0, 50, 1.0).decision, Decision::kRejected);
  EXPECT_EQ(conformity_of_largest(session, {}, 1.0, 50, 1.0).decision, Decision::kUndecided);
}

TEST(Conformity, FittedPointsAcceptNothing) {
  session::Session session = stored_session();
  std::erase_if(session.samples, [](const session::Sample& each) { return each.set != "G1"; });
  CalibrationRequest request;
  request.method = "lm";
  request.tolerance_mm = 10.0;
  const CalibrationResult result = calibrate(session, request);
  ASSERT_TRUE(result.conformity);
  EXPECT_FALSE(result.conformity->validated);
  EXPECT_EQ(result.conformity->accepted, result.conformity->points);
  EXPECT_EQ(result.conformity->decision, Decision::kUndecided);
}

}  // namespace
}  // namespace sixdial::studies
