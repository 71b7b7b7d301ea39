// A rig that is known only to within something: no finding while it stands within that, one
// finding where the file claims what several dials contradict, and a table of it all.
#include "diagnosis/rig_seen.h"

#include <gtest/gtest.h>

#include <cmath>

#include "diagnosis/diagnosis.h"
#include "tests/diagnosis/made_session.h"

namespace sixdial::diagnosis {
namespace {

constexpr double kStated_mm = 0.1;

DiagnosisSettings verdict_only() {
  DiagnosisSettings settings;
  settings.with_gain = false;
  settings.with_limits = false;
  settings.null_draws = 0;
  return settings;
}

/// Each dial along its axis known to so much.
simulation::ForwardModel knowing(const geometry::Rig& rig, double along_mm) {
  geometry::Rig stated = rig;
  for (geometry::Dial& dial : stated.dials) {
    dial.deviations.position_mm = Eigen::Vector2d(along_mm, 0.0);
  }
  return simulation::ForwardModel(stated);
}

TEST(RigSeen, AShiftWithinWhatIsStatedIsInTheTableAndNoFinding) {
  Session session = session_of({.seed = 31});
  constexpr double kShift_mm = 0.12;
  for (simulation::Trial& trial : session.trials) {
    if (trial.reading[2]) *trial.reading[2] += kShift_mm;
  }
  const simulation::ForwardModel known = knowing(session.model.rig(), kStated_mm);
  const Diagnosis stated = diagnose(known, session.trials, session.held_out, verdict_only());
  EXPECT_TRUE(stated.causes.empty());
  EXPECT_FALSE(stated.named.rig_geometry.has_value());
  ASSERT_EQ(stated.rig.size(), session.model.rig().dials.size());
  const RigSeen* worst = worst_of(stated.rig);
  ASSERT_NE(worst, nullptr);
  EXPECT_EQ(worst->name, "place of dial C along its axis");
  EXPECT_TRUE(worst->stated);
  EXPECT_DOUBLE_EQ(worst->known_sd, kStated_mm);
  // A dial further out reads more by as much; four standard deviations.
  EXPECT_LE(std::abs(std::abs(worst->off) - kShift_mm), 4 * worst->sd);
  EXPECT_LT(worst->sd, 0.5 * kStated_mm);

  // The same where the file claims exactness: that one dial has a name.
  const Diagnosis claimed =
      diagnose(session.model, session.trials, session.held_out, verdict_only());
  ASSERT_EQ(claimed.causes.size(), 1U);
  EXPECT_EQ(claimed.causes[0].finding.hypothesis.name(), "dial_mount@C");
  EXPECT_TRUE(claimed.rig.empty());
}

TEST(RigSeen, ARigOfWhichNothingIsExactIsOneFinding) {
  Session session = session_of({.seed = 32});
  // Of each dial another shift: no three names do it.
  const double shift_mm[] = {0.05, -0.08, 0.11, -0.06, 0.09, -0.12};
  for (simulation::Trial& trial : session.trials) {
    for (std::size_t d = 0; d < trial.reading.size(); ++d) {
      if (trial.reading[d]) *trial.reading[d] += shift_mm[d];
    }
  }
  const Diagnosis verdict =
      diagnose(session.model, session.trials, session.held_out, verdict_only());
  ASSERT_TRUE(verdict.named.rig_geometry.has_value());
  EXPECT_TRUE(verdict.rig_confirmed);
  EXPECT_FALSE(verdict.rig.empty());
  EXPECT_FALSE(verdict.rig[0].stated);
  for (const Cause& cause : verdict.causes) {
    EXPECT_FALSE(cause.finding.certain()) << cause.finding.hypothesis.name();
  }
}

TEST(RigSeen, AnExactRigStaysClosed) {
  for (const std::uint64_t seed : {41U, 42U, 43U, 44U, 45U}) {
    const Session session = session_of({.seed = seed});
    const Diagnosis verdict =
        diagnose(session.model, session.trials, session.held_out, verdict_only());
    EXPECT_FALSE(verdict.named.rig_geometry.has_value()) << seed;
    EXPECT_TRUE(verdict.rig.empty()) << seed;
  }
}

}  // namespace
}  // namespace sixdial::diagnosis
