// Dials that stand elsewhere than the rig file says are no exchange of others, and what rests
// on leaving out many readings is never certain.
#include <gtest/gtest.h>

#include <map>
#include <string>

#include "calibration/random.h"
#include "diagnosis/diagnosis.h"
#include "diagnosis/thresholds.h"
#include "tests/diagnosis/made_session.h"

namespace sixdial::diagnosis {
namespace {

DiagnosisSettings quick() {
  DiagnosisSettings settings;
  settings.with_gain = false;
  settings.with_limits = false;
  settings.null_draws = 0;
  return settings;
}

/// By so much each dial stands further along its axis [mm].
using Shifts = std::map<std::string, double>;

struct Tried {
  Diagnosis verdict;
  std::string said;
  bool swapped = false;  // dials named as exchanged
};

Tried tried(const Shifts& shifts, const Recipe& recipe) {
  Session session = session_of(recipe);
  for (simulation::Trial& trial : session.trials) {
    for (std::size_t d = 0; d < trial.reading.size(); ++d) {
      const auto shift = shifts.find(session.model.rig().dials[d].id);
      if (shift != shifts.end()) *trial.reading[d] += shift->second;
    }
  }
  Tried result{diagnose(session.model, session.trials, session.held_out, quick()), {}, false};
  for (const Cause& cause : result.verdict.causes) {
    const Finding& finding = cause.finding;
    const std::string name = finding.hypothesis.name();
    result.said += name + (finding.certain() ? " " : "? ");
    result.swapped = result.swapped || finding.hypothesis.effect->exchanges_dials;
  }
  return result;
}

TEST(ShiftedDials, AreNoExchangeOfTwoOthers) {
  const Tried found = tried({{"C", 0.2}, {"D", 0.2}}, {.seed = 7});
  EXPECT_FALSE(found.swapped) << found.said;
  EXPECT_LT(found.verdict.named.gross.size(), 10U);
}

TEST(ShiftedDials, OfOtherSizesAndNumbersAreNoneEither) {
  EXPECT_FALSE(tried({{"A", -0.6}}, {.seed = 401}).swapped);
  EXPECT_FALSE(tried({{"B", 0.1}, {"E", -0.4}}, {.seed = 402}).swapped);
}

TEST(ShiftedDials, HideNoExchange) {
  Session session = session_of({.seed = 9});
  for (simulation::Trial& trial : session.trials) {
    std::swap(trial.reading[2], trial.reading[5]);
    *trial.reading[0] += 0.3;
  }
  const Diagnosis verdict = diagnose(session.model, session.trials, session.held_out, quick());
  ASSERT_FALSE(verdict.causes.empty());
  EXPECT_EQ(verdict.causes[0].finding.hypothesis.name(), "dial_swap@C,F");
  EXPECT_TRUE(verdict.causes[0].finding.certain());
  EXPECT_TRUE(verdict.causes[0].on_g1);
}

// A tenth of the readings is far off, each by something else: backlash is there, but what was
// left out might say something else.
TEST(LeftOutReadings, MakeNothingCertainWhereTheyAreMany) {
  const geometry::Rig rig = geometry::default_rig();
  Session session =
      session_of({.effects = {effect_of(rig, "joint_backlash", "joint2", {4e-4})}, .seed = 6});
  calibration::RandomSequence random(8, 3);
  for (simulation::Trial& trial : session.trials) {
    for (auto& reading : trial.reading) {
      if (random.uniform(0, 1) < 0.12) *reading += random.uniform(-0.5, 0.5);
    }
  }
  const Diagnosis verdict = diagnose(session.model, session.trials, session.held_out, quick());
  ASSERT_FALSE(verdict.causes.empty());
  EXPECT_GT(verdict.causes[0].finding.left_out, kMostLeftOut);
  for (const Cause& cause : verdict.causes) {
    EXPECT_FALSE(cause.finding.certain()) << cause.finding.hypothesis.name();
    EXPECT_FALSE(cause.confirmed) << cause.finding.hypothesis.name();
  }
}

}  // namespace
}  // namespace sixdial::diagnosis
