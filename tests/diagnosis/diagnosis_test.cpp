// The verdict as a whole: laws on sessions that the project's own simulation makes. Whether
// somebody else's effects are found: tests/blind and measured_sessions_test.cpp.
#include "diagnosis/diagnosis.h"

#include <gtest/gtest.h>

#include <cmath>
#include <optional>
#include <string>
#include <vector>

#include "calibration/random.h"
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

TEST(Diagnosis, OfNoiseAloneFindsNothing) {
  int found = 0;
  constexpr int kSessions = 20;
  for (int seed = 1; seed <= kSessions; ++seed) {
    const Session session = session_of({.seed = static_cast<std::uint64_t>(seed)});
    const Diagnosis verdict =
        diagnose(session.model, session.trials, session.held_out, quick());
    found += !verdict.causes.empty() || verdict.unexplained.significant;
  }
  EXPECT_LE(found, 2) << "2 % false alarms are allowed: two of twenty are one in fifteen";
}

// 80 % power by definition. Half as large again must nearly always do.
TEST(Diagnosis, NamesAnEffectHalfAsLargeAgainAsItsLimit) {
  const Session empty = session_of({.seed = 5});
  DiagnosisSettings settings = quick();
  settings.with_limits = true;
  const Diagnosis blank = diagnose(empty.model, empty.trials, empty.held_out, settings);
  ASSERT_GT(blank.limits.size(), 40U);
  int tried = 0;
  int named = 0;
  std::string missed;
  for (const Limit& limit : blank.limits) {
    EXPECT_GE(limit.name, limit.detect) << limit.hypothesis.name();
    if (!std::isfinite(limit.name) || limit.hypothesis.effect->searched) continue;
    // One place of each effect.
    if (limit.hypothesis.place.dial > 0 || limit.hypothesis.place.joint > 0) continue;
    simulation::ActiveEffect active = at_rest(limit.hypothesis);
    active.x[0] = 1.5 * limit.name;
    const Session session = session_of({.effects = {active}, .seed = 5});
    const Diagnosis verdict =
        diagnose(session.model, session.trials, session.held_out, quick());
    ++tried;
    bool right = false;
    for (const Cause& cause : verdict.causes) {
      right = right || cause.finding.hypothesis == limit.hypothesis;
      for (const Rival& rival : cause.finding.tied_with) {
        right = right || rival.hypothesis == limit.hypothesis;
      }
    }
    named += right;
    if (right) continue;
    missed += limit.hypothesis.name() + " " + std::to_string(active.x[0]) + ", limits " +
              std::to_string(limit.detect) + " " + std::to_string(limit.name) + " said:";
    for (const Cause& cause : verdict.causes) missed += " " + cause.finding.hypothesis.name();
    for (const auto* list : {&verdict.named.unknown, &verdict.named.background}) {
      for (const UnknownCandidate& each : *list) {
        missed += " " + each.covariates.front() + " " + std::to_string(each.evidence);
      }
    }
    if (verdict.named.rig_geometry)
      missed += " rig " + std::to_string(*verdict.named.rig_geometry);
    missed += "\n";
  }
  EXPECT_GE(tried, 12);
  EXPECT_GE(named, tried - 2) << missed;
}

TEST(Diagnosis, MeasuresWhatNamingGainsAndConfirmsIt) {
  const geometry::Rig rig = geometry::default_rig();
  const Session session =
      session_of({.effects = {effect_of(rig, "joint_backlash", "joint2", {4e-4})}, .seed = 3});
  const Diagnosis verdict = diagnose(session.model, session.trials, session.held_out);
  ASSERT_EQ(verdict.causes.size(), 1U);
  const Cause& cause = verdict.causes[0];
  EXPECT_EQ(cause.finding.hypothesis.name(), "joint_backlash@joint2");
  EXPECT_TRUE(cause.confirmed);
  EXPECT_GT(cause.gain_mm, 0.002);
  ASSERT_EQ(cause.estimate.size(), 1U);
  EXPECT_LT(std::abs(cause.estimate[0].value - 4e-4), 4 * cause.estimate[0].sd);
  const auto row = [&](GainModel model, bool network = false) -> const GainRow& {
    for (const GainRow& each : verdict.gain) {
      if (each.model == model && each.network == network) return each;
    }
    throw std::out_of_range("no such row");
  };
  const GainRow& extended = row(GainModel::kExtended);
  EXPECT_LT(extended.high_mm, 0.0) << "better than calibrated beyond doubt";
  EXPECT_LT(extended.mean_mm, row(GainModel::kCalibrated, true).mean_mm);
  const GainRow& without = row(GainModel::kWithout);
  EXPECT_EQ(without.without, cause.finding.hypothesis);
  EXPECT_LT(std::abs(without.mean_mm - row(GainModel::kCalibrated).mean_mm), 1e-4);
  EXPECT_GT(extended.removed_share, 0.9);
}

TEST(Diagnosis, SaysScatterWhereTheNoiseIsLargerThanItsRepeats) {
  Session session = session_of({.points = 120, .repeats = 2, .seed = 11});
  // Each point sits somewhere else than the robot says, the same for its repeats.
  calibration::RandomSequence random(4, 2);
  for (std::size_t t = 0; t + 1 < session.trials.size(); t += 2) {
    for (std::size_t d = 0; d < 6; ++d) {
      const double off = 0.004 * random.normal();
      *session.trials[t].reading[d] += off;
      *session.trials[t + 1].reading[d] += off;
    }
  }
  const Diagnosis verdict = diagnose(session.model, session.trials, session.held_out, quick());
  EXPECT_EQ(verdict.noise.source, NoiseSource::kRepeats);
  EXPECT_LT(std::abs(verdict.noise.sigma_mm - kNoise_mm), 0.2 * kNoise_mm);
  EXPECT_TRUE(verdict.unexplained.scatter);
  EXPECT_TRUE(verdict.unexplained.depends_on.empty());
}

// A dial that scatters is no cause, and must not make one of its own noise.
TEST(Diagnosis, NamesTheDialThatScattersAndNoCauseForIt) {
  constexpr int kSessions = 6;
  constexpr double kMore = 4.0;
  constexpr double kAbout = 0.15;  // two and a half standard deviations of an s of 150 readings
  int falsely = 0;
  for (std::size_t dial = 0; dial < kSessions; ++dial) {
    Session session = session_of({.seed = 40 + dial});
    calibration::RandomSequence random(50 + dial, 3);
    for (simulation::Trial& trial : session.trials) {
      *trial.reading[dial] += std::sqrt(kMore * kMore - 1) * kNoise_mm * random.normal();
    }
    const Diagnosis verdict =
        diagnose(session.model, session.trials, session.held_out, quick());
    for (const Cause& cause : verdict.causes) falsely += cause.finding.certain();
    falsely += !verdict.unexplained.depends_on.empty();
    ASSERT_EQ(verdict.unexplained.noisy_dials.size(), 1U) << dial;
    const NoisyDial& found = verdict.unexplained.noisy_dials[0];
    EXPECT_EQ(found.dial, session.model.rig().dials[dial].id);
    EXPECT_LT(std::abs(found.sigma_mm / (kMore * kNoise_mm) - 1), kAbout);
    EXPECT_TRUE(verdict.unexplained.scatter);
  }
  EXPECT_LE(falsely, 1) << "2 % false alarms are allowed";
}

// Beside a dial that scatters a cause elsewhere is found as well as ever.
TEST(Diagnosis, FindsACauseBesideADialThatScatters) {
  const geometry::Rig rig = geometry::default_rig();
  Session session =
      session_of({.effects = {effect_of(rig, "joint_backlash", "joint1", {1e-4})}, .seed = 61});
  calibration::RandomSequence random(62, 3);
  for (simulation::Trial& trial : session.trials) *trial.reading[4] += 0.01 * random.normal();
  const Diagnosis verdict = diagnose(session.model, session.trials, session.held_out, quick());
  ASSERT_EQ(verdict.causes.size(), 1U);
  EXPECT_EQ(verdict.causes[0].finding.hypothesis.name(), "joint_backlash@joint1");
  EXPECT_TRUE(verdict.causes[0].finding.certain());
  ASSERT_EQ(verdict.unexplained.noisy_dials.size(), 1U);
  EXPECT_EQ(verdict.unexplained.noisy_dials[0].dial, "E");
}

// The rig file may give a dial its own repeatability: then nothing is wrong with it.
TEST(Diagnosis, TakesEachDialsNoiseFromTheRigFile) {
  Session session = session_of({.seed = 63});
  geometry::Rig rig = session.model.rig();
  rig.dials[2].repeatability_mm = 4 * kNoise_mm;
  session.model = simulation::ForwardModel(rig);
  calibration::RandomSequence random(64, 3);
  for (simulation::Trial& trial : session.trials) {
    *trial.reading[2] += std::sqrt(15.0) * kNoise_mm * random.normal();
  }
  const Diagnosis verdict = diagnose(session.model, session.trials, session.held_out, quick());
  EXPECT_TRUE(verdict.causes.empty());
  EXPECT_FALSE(verdict.unexplained.significant);
}

// The first sample of a session: nobody knows from which side the joint came.
TEST(Diagnosis, CallsNoSampleGrossForASideThatNobodyKnows) {
  const geometry::Rig rig = geometry::default_rig();
  Session session =
      session_of({.effects = {effect_of(rig, "joint_backlash", "joint2", {6e-4})}, .seed = 71});
  session.trials[0].approach[1] = 0;
  const Diagnosis verdict = diagnose(session.model, session.trials, session.held_out, quick());
  ASSERT_EQ(verdict.causes.size(), 1U);
  EXPECT_EQ(verdict.causes[0].finding.hypothesis.name(), "joint_backlash@joint2");
  EXPECT_TRUE(verdict.named.gross.empty());
}

// The first point of a session, read three times: how the tool came there is not recorded, and
// what that makes is no scatter of the dials.
TEST(Diagnosis, CallsNothingScatterThatAnUnknownMoveMakes) {
  const geometry::Rig rig = geometry::default_rig();
  Session session = session_of(
      {.effects = {effect_of(rig, "passive_clearance", "elbows", {0.01})},
       .points = 40,
       .repeats = 3,
       .seed = 73});
  const Eigen::Vector2d off_mm(0.007, -0.007);
  for (std::size_t t = 0; t < 3; ++t) {
    const auto seen =
        session.model.predict(session.truth, session.trials[t].q, session.trials[t].assembly);
    for (std::size_t d = 0; d < 6; ++d) {
      const auto row = static_cast<Eigen::Index>(d);
      *session.trials[t].reading[d] +=
          seen->observation.by_frames.row(row).head<2>().dot(off_mm);
    }
  }
  const Diagnosis verdict = diagnose(session.model, session.trials, session.held_out, quick());
  ASSERT_EQ(verdict.causes.size(), 1U);
  EXPECT_EQ(verdict.causes[0].finding.hypothesis.name(), "passive_clearance@elbows");
  EXPECT_FALSE(verdict.unexplained.significant);
  EXPECT_TRUE(verdict.causes[0].confirmed) << "without the gain table too";
}

// The tool is shifted after the last fitted point. Naming that may be right, but G1 knows
// nothing of it: a gain on G2 would be what G2's own readings said.
TEST(Diagnosis, GainsNothingByWhatOnlyTheJudgedPointsShow) {
  const geometry::Rig rig = geometry::default_rig();
  constexpr double kStep_mm = 0.014;
  constexpr double kFirstSample = 115;  // G2 begins at 100
  const Session session = session_of(
      {.effects = {effect_of(rig, "step", "base", {kStep_mm, 0.0, kFirstSample})},
       .points = 150,
       .seed = 91});
  DiagnosisSettings settings = quick();
  settings.with_gain = true;
  const Diagnosis verdict = diagnose(session.model, session.trials, session.held_out, settings);
  int seen = 0;
  for (const GainRow& row : verdict.gain) {
    if (row.model != GainModel::kExtended || row.network) continue;
    EXPECT_LT(std::abs(row.difference_mm), 0.001);
    ++seen;
  }
  EXPECT_EQ(seen, 1);
}

TEST(Diagnosis, SaysWhereAGrossReadingTouchesAtTheEdge) {
  constexpr std::size_t kDial = 4;
  constexpr double kFar_mm =
      -4.0;  // its tip leaves the face where the tool is far to the right
  Session session = session_of({.seed = 72, .dial_E_x_mm = kFar_mm});
  const geometry::Rig& rig = session.model.rig();
  const auto along_mm = [&](const simulation::Trial& trial) {
    const auto pose = session.model.predict(
        session.model.nominal(), trial.q, trial.assembly, std::nullopt, false);
    return geometry::contact_on_face(
               rig.dials[kDial].geometry, {pose->p_WE(), pose->gamma_rad}, rig.cuboid.side_mm,
               1)
        .along_mm;
  };
  int at_edge = 0;
  int inside = 0;
  std::vector<bool> expected(session.trials.size());
  for (std::size_t t = 0; t < session.trials.size(); ++t) {
    const double along = std::abs(along_mm(session.trials[t]));
    const bool edge = along > rig.cuboid.side_mm / 2 + 1;
    if (!edge && along > rig.cuboid.side_mm / 2 - 10) continue;
    int& count = edge ? at_edge : inside;
    if (++count > 3) continue;
    expected[t] = edge;
    *session.trials[t].reading[kDial] += 0.3;
  }
  ASSERT_GE(at_edge, 3);
  const Readings readings(session.model, session.trials);
  const Diagnosis verdict = diagnose(session.model, session.trials, session.held_out, quick());
  ASSERT_EQ(verdict.named.gross.size(), 6U);
  for (const GrossReading& each : verdict.named.gross) {
    const auto trial =
        static_cast<std::size_t>(readings.rows()[static_cast<std::size_t>(each.row)].trial);
    EXPECT_EQ(each.near_edge, expected[trial]) << trial;
  }
}

TEST(Diagnosis, OfAFreeMountKnowsEachSamplesAngleOnlyFromItsDials) {
  const geometry::Rig rig = geometry::default_rig();
  const Session clean = session_of({.seed = 21, .mount = geometry::Mount::kFree});
  EXPECT_TRUE(diagnose(clean.model, clean.trials, clean.held_out, quick()).causes.empty());
  const Session hidden = session_of(
      {.effects = {effect_of(rig, "dial_gain", "E", {2e-3})},
       .seed = 21,
       .mount = geometry::Mount::kFree});
  const Diagnosis verdict = diagnose(hidden.model, hidden.trials, hidden.held_out, quick());
  ASSERT_FALSE(verdict.causes.empty());
  EXPECT_EQ(verdict.causes[0].finding.hypothesis.name(), "dial_gain@E");
}

TEST(Diagnosis, WithoutG2HoldsOutEveryThirdPointItself) {
  Session session = session_of({.seed = 2});
  session.held_out.assign(session.trials.size(), false);
  const Diagnosis verdict = diagnose(session.model, session.trials, session.held_out, quick());
  EXPECT_TRUE(verdict.held_out_by_program);
  EXPECT_EQ(verdict.g2_samples, 50);
}

TEST(Diagnosis, OfTooFewReadingsIsRefusedInWords) {
  const Session session = session_of({.points = 3});
  EXPECT_THROW(
      (void)diagnose(session.model, session.trials, session.held_out, quick()),
      std::invalid_argument);
}

TEST(Diagnosis, GivesTheSameAnswerTwiceAndUnderShuffledDialNames) {
  const geometry::Rig rig = geometry::default_rig();
  const Session session =
      session_of({.effects = {effect_of(rig, "dial_lean", "C", {4e-3})}, .seed = 8});
  DiagnosisSettings settings = quick();
  const Diagnosis once = diagnose(session.model, session.trials, session.held_out, settings);
  const Diagnosis twice = diagnose(session.model, session.trials, session.held_out, settings);
  ASSERT_EQ(once.causes.size(), 1U);
  EXPECT_EQ(once.causes[0].finding.evidence, twice.causes[0].finding.evidence);
  // The same rig, its dials listed backwards.
  geometry::Rig backwards = session.model.rig();
  std::reverse(backwards.dials.begin(), backwards.dials.end());
  const simulation::ForwardModel other(backwards);
  std::vector<simulation::Trial> trials = session.trials;
  for (auto& trial : trials) std::reverse(trial.reading.begin(), trial.reading.end());
  const Diagnosis reversed = diagnose(other, trials, session.held_out, settings);
  ASSERT_EQ(reversed.causes.size(), 1U);
  EXPECT_EQ(reversed.causes[0].finding.hypothesis.place.name, "C");
  // Sums in another order.
  EXPECT_LT(
      std::abs(once.causes[0].finding.evidence - reversed.causes[0].finding.evidence), 1e-3);
}

TEST(SimulatedFalseAlarm, IsAboutUniformUnderNoise) {
  constexpr int kSessions = 12;
  int below_half = 0;
  for (int seed = 1; seed <= kSessions; ++seed) {
    const Session session = session_of({.seed = 300 + static_cast<std::uint64_t>(seed)});
    DiagnosisSettings settings = quick();
    settings.null_draws = 60;
    below_half += diagnose(session.model, session.trials, session.held_out, settings)
                      .false_alarm_probability < 0.5;
  }
  // Binomial of 12: outside 1..11 once in two thousand.
  EXPECT_GE(below_half, 1);
  EXPECT_LE(below_half, 11);
}

}  // namespace
}  // namespace sixdial::diagnosis
