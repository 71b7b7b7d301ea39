// Of a very long session some samples are drawn: spread evenly, whole poses with a few of their
// repeats, both sides by their share; and what is there is found in them too.
#include "diagnosis/drawn_samples.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <map>

#include "diagnosis/diagnosis.h"
#include "tests/diagnosis/made_session.h"

namespace sixdial::diagnosis {
namespace {

/// So many poses, each measured so often without a move; every third pose is held out.
struct Long {
  std::vector<simulation::Trial> trials;
  std::vector<bool> held_out;
  Long(int poses, int repeats) {
    for (int pose = 0; pose < poses; ++pose) {
      for (int repeat = 0; repeat < repeats; ++repeat) {
        simulation::Trial trial;
        trial.point = pose;
        trial.repeat = repeat;
        trial.q =
            Eigen::Vector2d(1.0 + 1e-3 * std::fmod(7.31 * pose, 900.0), 2.0 + 1e-3 * pose);
        trials.push_back(trial);
        held_out.push_back(pose % 3 == 2);
      }
    }
  }
};

TEST(DrawnSamples, AreAllWhereThereAreNoMoreThanAsked) {
  const Long few(100, 1);
  const std::vector<bool> all(100, true);
  EXPECT_EQ(drawn_samples(few.trials, few.held_out, 100, 1), all);
  EXPECT_EQ(drawn_samples(few.trials, few.held_out, 0, 1), all);
}

TEST(DrawnSamples, LieEvenlyInTheSessionAndOnBothSides) {
  constexpr int kAll = 30'000;
  constexpr int kMost = 3'000;
  const Long all(kAll, 1);
  const std::vector<bool> drawn = drawn_samples(all.trials, all.held_out, kMost, 1);
  int held_out = 0;
  std::vector<int> by_tenth(10);
  for (int t = 0; t < kAll; ++t) {
    if (!drawn[static_cast<std::size_t>(t)]) continue;
    ++by_tenth[static_cast<std::size_t>(10 * t / kAll)];
    held_out += all.held_out[static_cast<std::size_t>(t)];
  }
  EXPECT_NEAR(static_cast<int>(std::ranges::count(drawn, true)), kMost, 2);
  EXPECT_NEAR(held_out, kMost / 3.0, 2);
  for (const int each : by_tenth) EXPECT_NEAR(each, kMost / 10.0, 3);
  EXPECT_EQ(drawn_samples(all.trials, all.held_out, kMost, 1), drawn);
  EXPECT_NE(drawn_samples(all.trials, all.held_out, kMost, 2), drawn);
}

TEST(DrawnSamples, KeepAFewRepeatsOfAPoseToTellTheNoise) {
  const Long many(2'000, 10);
  std::map<int, int> repeats;
  const std::vector<bool> drawn = drawn_samples(many.trials, many.held_out, 1'200, 1);
  for (std::size_t t = 0; t < drawn.size(); ++t) {
    if (drawn[t]) ++repeats[many.trials[t].point];
  }
  EXPECT_NEAR(static_cast<double>(repeats.size()), 400, 2);
  for (const auto& [point, count] : repeats) EXPECT_EQ(count, 3) << point;
  // Few poses: all of them, with as many repeats as there is room for.
  const Long few(40, 500);
  repeats.clear();
  const std::vector<bool> of_few = drawn_samples(few.trials, few.held_out, 1'000, 1);
  for (std::size_t t = 0; t < of_few.size(); ++t) {
    if (of_few[t]) ++repeats[few.trials[t].point];
  }
  EXPECT_EQ(repeats.size(), 40U);
  for (const auto& [point, count] : repeats) EXPECT_NEAR(count, 25, 1) << point;
}

TEST(DrawnSamples, ShowTheCauseAndRememberThePastOfEach) {
  // Backlash goes by the side from which a joint came, which is that of the sample before: one
  // that was not drawn as a rule.
  const geometry::Rig rig = geometry::default_rig();
  Session session = session_of(
      {.effects = {effect_of(rig, "joint_backlash", "joint2", {4e-4})}, .points = 1'200});
  for (simulation::Trial& trial : session.trials) trial.approach.clear();
  const Diagnosis found = diagnose(
      session.model, session.trials, session.held_out,
      {.null_draws = 0, .with_gain = false, .with_limits = false, .most_samples = 240});
  EXPECT_EQ(found.drawn_of, session.trials.size());
  EXPECT_NEAR(found.g1_samples + found.g2_samples, 240, 3);
  EXPECT_LT(found.readings->count(), 240 * 7);
  ASSERT_EQ(found.causes.size(), 1U);
  EXPECT_EQ(found.causes[0].finding.hypothesis.name(), "joint_backlash@joint2");
  EXPECT_NEAR(found.causes[0].estimate[0].value, 4e-4, 4e-5);
}

}  // namespace
}  // namespace sixdial::diagnosis
