// Bad readings are found with their dial and size, whoever else is bad, and good ones are left
// alone.
#include "calibration/gross_errors.h"

#include <gtest/gtest.h>

#include <cmath>
#include <set>

#include "calibration/random.h"
#include "geometry/instruments/contact.h"
#include "tests/calibration/support.h"

namespace sixdial::calibration {
namespace {

using testing::DialSession;
using testing::SessionPlan;
using testing::simulate_dials;

constexpr double kNoise_mm = 0.002;
// Size of an error as it is found: noise of the reading and of what the others say.
constexpr double kSize_mm = 6 * kNoise_mm;

SessionPlan plan() {
  SessionPlan result;
  result.noise_mm = kNoise_mm;
  return result;
}

struct Planted {
  int sample, dial;
  double size_mm;
};

/// Five per cent of all readings are 0.05 to 0.5 mm off, either way.
std::vector<Planted> spoil(DialSession& session, std::uint64_t seed) {
  RandomSequence random(seed, 950);
  std::vector<Planted> planted;
  for (simulation::Trial& trial : session.g1) {
    for (std::size_t dial = 0; dial < trial.reading.size(); ++dial) {
      if (!trial.reading[dial] || random.uniform() > 0.05) continue;
      const double size_mm = random.uniform(0.05, 0.5) * (random.uniform() < 0.5 ? -1.0 : 1.0);
      *trial.reading[dial] += size_mm;
      planted.push_back({trial.sample, static_cast<int>(dial), size_mm});
    }
  }
  return planted;
}

/// As the service does with what was found: those readings do not count.
void set_aside(DialSession& session, const std::vector<GrossError>& found) {
  const auto dials = session.rig.dial_geometries();
  for (const GrossError& each : found) {
    auto trial = std::ranges::find(session.g1, each.sample, &simulation::Trial::sample);
    trial->reading[static_cast<std::size_t>(each.dial)].reset();
  }
}

/// Positions of the active three of what is left.
void measure_positions(DialSession& session) {
  const auto dials = session.rig.dial_geometries();
  for (simulation::Trial& trial : session.g1) {
    std::vector<geometry::DialReading> readings;
    for (std::size_t dial = 0; dial < dials.size(); ++dial) {
      if (!trial.reading[dial]) continue;
      readings.push_back({static_cast<int>(dial), *trial.reading[dial], kNoise_mm});
    }
    const auto at = geometry::best_active_three(
        dials, readings, session.rig.cuboid.side_mm, trial.gamma_rad.value_or(0.0));
    if (at) {
      trial.position_mm = at->pose.p_WE;
    } else {
      trial.position_mm.reset();
    }
  }
}

class GrossErrorsOnEveryMount : public ::testing::TestWithParam<geometry::Mount> {};

TEST_P(GrossErrorsOnEveryMount, AreFoundWithDialAndSizeAndNoOthers) {
  std::size_t missed = 0;
  std::size_t accused = 0;
  std::size_t wrong_size = 0;
  std::size_t planted_in_all = 0;
  // A free cuboid turns to hide a part: two bad readings of one sample can look like another.
  const bool free = GetParam() == geometry::Mount::kFree;
  for (std::uint64_t seed = 1; seed <= 12; ++seed) {
    DialSession session = simulate_dials(plan(), seed, GetParam());
    const auto planted = spoil(session, seed);
    planted_in_all += planted.size();
    const auto check = find_gross_errors(session.g1, session.rig);
    EXPECT_TRUE(check.not_possible.empty());
    EXPECT_EQ(check.systematic, 0);
    EXPECT_LT(std::abs(std::log(check.sigma_mm / kNoise_mm)), 0.3);
    for (const Planted& each : planted) {
      const auto found = std::ranges::find_if(check.found, [&](const GrossError& error) {
        return error.sample == each.sample && error.dial == each.dial;
      });
      if (found == check.found.end()) {
        ++missed;
      } else {
        wrong_size += std::abs(found->size_mm - each.size_mm) > kSize_mm ? 1U : 0U;
      }
    }
    for (const GrossError& error : check.found) {
      accused += std::ranges::none_of(
                     planted,
                     [&](const Planted& each) {
                       return error.sample == each.sample && error.dial == each.dial;
                     })
                     ? 1U
                     : 0U;
    }
  }
  EXPECT_GT(planted_in_all, 200U);
  EXPECT_LE(missed, free ? planted_in_all / 25 : 0U);
  EXPECT_LE(wrong_size, free ? planted_in_all / 25 : 0U);
  EXPECT_LE(accused, free ? planted_in_all / 25 : 0U);
}

INSTANTIATE_TEST_SUITE_P(
    , GrossErrorsOnEveryMount,
    ::testing::Values(
        geometry::Mount::kDistal1, geometry::Mount::kDistal2, geometry::Mount::kFree),
    [](const auto& each) { return "mount" + std::to_string(static_cast<int>(each.param)); });

TEST(GrossErrors, ParametersStayWithinTwiceTheCleanSessionsStandardDeviations) {
  int tried = 0;
  for (std::uint64_t seed = 1; seed <= 20; ++seed) {
    const DialSession clean = simulate_dials(plan(), seed);
    DialSession bad = clean;
    ASSERT_GT(spoil(bad, seed).size(), 10U);
    DialSession checked = bad;
    set_aside(checked, find_gross_errors(bad.g1, bad.rig).found);
    measure_positions(bad);
    measure_positions(checked);
    for (const bool dials : {false, true}) {
      const auto space_of = [&](const DialSession& session) {
        return dials ? dial_space(session.g1, session.rig)
                     : position_space(
                           position_observations(session.g1), session.rig.robot.nominal);
      };
      const Identifier& lm = *find_identifier("lm");
      const auto reference = identify(lm, space_of(clean));
      IdentifySettings forgiving;
      forgiving.loss = Loss::kCauchy;
      const auto after_check = identify(lm, space_of(checked));
      const auto robust = identify(lm, space_of(bad), forgiving);
      for (int i = 0; i < reference.x.size(); ++i) {
        const double limit = 2.0 * std::sqrt(reference.covariance(i, i));
        EXPECT_LT(std::abs(after_check.x[i] - reference.x[i]), limit)
            << "check, dials " << dials << ", seed " << seed << ", parameter " << i;
        EXPECT_LT(std::abs(robust.x[i] - reference.x[i]), limit)
            << "cauchy, dials " << dials << ", seed " << seed << ", parameter " << i;
        ++tried;
      }
    }
  }
  EXPECT_EQ(tried, 20 * 21);
}

TEST(GrossErrors, WithoutThemNobodyIsAccused) {
  std::size_t accused = 0;
  for (std::uint64_t seed = 100; seed < 130; ++seed) {
    const DialSession session = simulate_dials(plan(), seed);
    accused += find_gross_errors(session.g1, session.rig).found.size();
  }
  EXPECT_EQ(accused, 0U);
}

TEST(GrossErrors, AreFoundInPositionsWhereAnInstrumentGivesThose) {
  auto session = simulate_dials(plan(), 41);
  for (simulation::Trial& trial : session.g1) {
    std::ranges::fill(trial.reading, std::nullopt);
  }
  session.g1[7].position_mm->x() += 0.1;
  session.g1[70].position_mm->y() -= 0.3;
  const auto check = find_gross_errors(session.g1, session.rig);
  ASSERT_EQ(check.found.size(), 2U);
  EXPECT_EQ(check.found[0].sample, session.g1[7].sample);
  EXPECT_EQ(check.found[0].dial, -1);
  EXPECT_LT(std::abs(check.found[0].size_mm - 0.1), 5 * kSize_mm);
  EXPECT_EQ(check.found[1].sample, session.g1[70].sample);
}

/// A session of positions alone.
DialSession positions_only(SessionPlan plan, std::uint64_t seed) {
  DialSession session = simulate_dials(plan, seed);
  for (auto* set : {&session.g1, &session.g2}) {
    for (simulation::Trial& trial : *set) std::ranges::fill(trial.reading, std::nullopt);
  }
  return session;
}

// One session in a hundred is what the limit claims: 4 of 100 come by chance once in 50 runs.
TEST(GrossErrors, FewPositionsAccuseNobody) {
  for (const int points : {9, 12, 20, 60}) {
    SessionPlan few = plan();
    few.g1_points = points;
    int sessions = 0;
    for (std::uint64_t seed = 700; seed < 800; ++seed) {
      const DialSession session = positions_only(few, seed);
      sessions += find_gross_errors(session.g1, session.rig).found.empty() ? 0 : 1;
    }
    EXPECT_LE(sessions, 3) << points << " points";
  }
}

// Joints turn about points beside their axes and links bend, ten times the noise: everything is
// smooth, nothing is an accident. Of 40 sets at 1 % each, more than 2 come by chance once in
// 120 runs.
TEST(GrossErrors, WhatIsSmoothIsNoAccident) {
  int accused = 0;
  for (std::uint64_t seed = 800; seed < 820; ++seed) {
    SessionPlan smooth = plan();
    smooth.non_kinematic = 1.0;
    const DialSession session = positions_only(smooth, seed);
    const auto check = find_gross_errors(session.g1, session.rig);
    accused += static_cast<int>(check.found.size());
    accused += static_cast<int>(judge_readings(session.g2, session.rig, check).found.size());
  }
  EXPECT_LE(accused, 2);
}

// A rig file that calls its dials exact sets no least size for an error.
TEST(GrossErrors, FewReadingsOfDialsAccuseNobody) {
  for (const int points : {6, 9, 12, 30}) {
    SessionPlan few = plan();
    few.g1_points = points;
    int sessions = 0;
    for (std::uint64_t seed = 700; seed < 800; ++seed) {
      DialSession session = simulate_dials(few, seed);
      for (geometry::Dial& dial : session.rig.dials) dial.accuracy_mm = 0.0;
      sessions += find_gross_errors(session.g1, session.rig).found.empty() ? 0 : 1;
    }
    EXPECT_LE(sessions, 3) << points << " points";
  }
}

TEST(GrossErrors, WhatIsSmoothInDialsIsNoAccidentAndAnAccidentInItIsFound) {
  constexpr double kAccident_mm = 0.3;
  int accused = 0, missed = 0;
  for (std::uint64_t seed = 800; seed < 820; ++seed) {
    SessionPlan smooth = plan();
    smooth.non_kinematic = 1.0;
    smooth.g1_points = seed % 2 == 0 ? 30 : 100;
    DialSession session = simulate_dials(smooth, seed);
    const auto clean = find_gross_errors(session.g1, session.rig);
    accused += static_cast<int>(clean.found.size()) + (clean.systematic > 0 ? 1 : 0);
    accused += static_cast<int>(judge_readings(session.g2, session.rig, clean).found.size());
    simulation::Trial& bumped = session.g1[seed % session.g1.size()];
    const std::size_t dial = seed % bumped.reading.size();
    if (!bumped.reading[dial]) continue;
    *bumped.reading[dial] += kAccident_mm;
    const auto found = find_gross_errors(session.g1, session.rig).found;
    missed += found.size() == 1 && found[0].sample == bumped.sample &&
                      found[0].dial == static_cast<int>(dial)
                  ? 0
                  : 1;
  }
  EXPECT_LE(accused, 2);
  EXPECT_LE(missed, 1);
}

TEST(GrossErrors, AreFoundInPositionsWhereTheyHideEachOtherAndInTheOtherSet) {
  int found = 0, wrong = 0, in_g2 = 0;
  for (std::uint64_t seed = 820; seed < 840; ++seed) {
    DialSession session = positions_only(plan(), seed);
    const std::set<int> bad{3, 40, 41, 77};
    for (const int i : bad) {
      session.g1[static_cast<std::size_t>(i)].position_mm->y() += i == 40 ? -0.05 : 0.05;
    }
    session.g2[9].position_mm->x() += 0.05;
    const auto check = find_gross_errors(session.g1, session.rig);
    for (const GrossError& each : check.found) {
      bool planted = false;
      for (const int i : bad) {
        planted = planted || session.g1[static_cast<std::size_t>(i)].sample == each.sample;
      }
      (planted ? found : wrong) += 1;
    }
    const auto judged = judge_readings(session.g2, session.rig, check);
    for (const GrossError& each : judged.found) {
      (each.sample == session.g2[9].sample ? in_g2 : wrong) += 1;
    }
  }
  EXPECT_EQ(found, 4 * 20);
  EXPECT_EQ(in_g2, 20);
  EXPECT_LE(wrong, 1);
}

TEST(GrossErrors, OfASetThatIsNotFittedAreJudgedByTheOthersFit) {
  auto session = simulate_dials(plan(), 42);
  *session.g2[5].reading[2] -= 0.2;
  const auto check = find_gross_errors(session.g1, session.rig);
  EXPECT_TRUE(check.found.empty());
  const auto judged = judge_readings(session.g2, session.rig, check);
  ASSERT_EQ(judged.found.size(), 1U);
  EXPECT_EQ(judged.found[0].sample, session.g2[5].sample);
  EXPECT_EQ(judged.found[0].dial, 2);
  EXPECT_LT(std::abs(judged.found[0].size_mm + 0.2), kSize_mm);
}

TEST(GrossErrors, ADialThatIsWrongEverywhereIsNoAccident) {
  auto session = simulate_dials(plan(), 43);
  for (simulation::Trial& trial : session.g1) {  // C and D have changed places
    std::swap(trial.reading[2], trial.reading[3]);
  }
  const auto check = find_gross_errors(session.g1, session.rig);
  EXPECT_LT(check.found.size(), 5U);
}

TEST(GrossErrors, TooFewReadingsAreSaidToBeTooFew) {
  SessionPlan few = plan();
  few.g1_points = 2;
  const auto session = simulate_dials(few, 44);
  const auto check = find_gross_errors(session.g1, session.rig);
  EXPECT_TRUE(check.found.empty());
  EXPECT_NE(check.not_possible.find("too few"), std::string::npos);
}

}  // namespace
}  // namespace sixdial::calibration
