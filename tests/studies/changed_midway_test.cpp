// What changes while a session is measured: a dial's zero, unit or plug, the frame of
// positions; and values that no unit explains.
#include "studies/changed_midway.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "report/words/warning_words.h"
#include "session/rig_file.h"
#include "studies/calibrate.h"
#include "studies/compare.h"
#include "tests/studies/drawn_sessions.h"

namespace sixdial::studies {
namespace {

using ::testing::HasSubstr;

/// The readings of some dials from a row on, changed.
session::Session from_row(
    session::Session session, std::size_t row, const std::vector<std::size_t>& dials,
    const std::function<double(double)>& change) {
  for (std::size_t i = row; i < session.samples.size(); ++i) {
    for (const std::size_t dial : dials) {
      auto& value = session.samples[i].channels[dial].value;
      if (value) value = change(*value);
    }
  }
  return session;
}

CalibrationResult calibrated(const session::Session& session) {
  return calibrate(session, {.method = "lm", .seed = 1, .threads = 1});
}

/// The only warning, which must be this one.
std::string only_text(const std::vector<Warning>& warnings, const std::string& code) {
  EXPECT_EQ(codes_text(warnings), code + " ");
  return warnings.empty() ? "" : report::warning_text(warnings.front());
}

constexpr std::size_t kB = 1, kC = 2, kE = 4, kF = 5;

TEST(ChangedMidway, AZeroThatWasSetIsOneChangeAndNoAccidents) {
  for (const double shift_mm : {-0.05, 0.3, 2.0}) {
    for (std::uint64_t seed = 1; seed <= 3; ++seed) {
      const auto result = calibrated(
          from_row(by_dials(seed), 50, {kC}, [&](double mm) { return mm + shift_mm; }));
      const std::string text = only_text(*result.warnings, "dial_changed");
      EXPECT_THAT(text, HasSubstr("Dial C reads otherwise from line 5")) << seed;
      EXPECT_THAT(text, HasSubstr(shift_mm > 0 ? "too much" : "too little"));
      EXPECT_THAT(text, HasSubstr("to the end"));
      EXPECT_FALSE(is_clean(*result.warnings));
    }
  }
}

/// Dials that stand elsewhere than the file says, by as much as it states, are fitted along: a
/// change is seen against where they were found.
TEST(ChangedMidway, IsSeenOnARigThatIsKnownRoughlyAndNoneIsMadeUp) {
  for (std::uint64_t seed = 1; seed <= 3; ++seed) {
    session::Session session = by_dials(seed);
    std::string& text = session.rig_text;
    for (std::size_t at = 0; (at = text.find("[[dial]]", at)) != std::string::npos; at += 8) {
      text.insert(at + 8, "\nposition_sd_mm = [0.03, 0.1]");
    }
    session.rig = session::parse_rig(text, "rig.toml");
    const double off_mm[] = {0.03, -0.02, 0.04, 0.0, -0.03, 0.02};
    for (session::Sample& sample : session.samples) {
      for (std::size_t d = 0; d < std::size(off_mm); ++d) {
        auto& value = sample.channels[d].value;
        if (value && *value > 1.0) *value += off_mm[d];
      }
    }
    const auto clean = calibrated(session);
    EXPECT_TRUE(clean.rig) << seed;
    EXPECT_EQ(codes_text(*clean.warnings), "") << seed;
    const auto changed =
        calibrated(from_row(session, 50, {kC}, [](double mm) { return mm + 0.3; }));
    EXPECT_THAT(only_text(*changed.warnings, "dial_changed"), HasSubstr("Dial C")) << seed;
  }
}

TEST(ChangedMidway, AUnitKeyThatWasPressedAndPlugsThatWereExchanged) {
  const auto inches =
      calibrated(from_row(by_dials(4), 48, {kB}, [](double mm) { return mm / 25.4; }));
  EXPECT_THAT(only_text(*inches.warnings, "dial_changed"), HasSubstr("Dial B reads otherwise"));
  session::Session exchanged = by_dials(5);
  for (std::size_t i = 52; i < exchanged.samples.size(); ++i) {
    std::swap(exchanged.samples[i].channels[kE], exchanged.samples[i].channels[kF]);
  }
  EXPECT_THAT(
      only_text(*calibrated(exchanged).warnings, "dial_changed"),
      HasSubstr("Dials E and F read otherwise"));
}

TEST(ChangedMidway, AllOfG2InAnotherUnitIsToldByBothStudies) {
  session::Session session = by_dials(6);
  for (session::Sample& sample : session.samples) {
    if (sample.set != "G2") continue;
    for (session::ChannelValue& each : sample.channels) {
      if (each.value) each.value = *each.value / 25.4;
    }
  }
  EXPECT_THAT(
      only_text(*calibrated(session).warnings, "dial_changed"), HasSubstr("Dials A, B, C"));
  const ComparisonResult compared =
      compare(session, {.methods = {"before", "lm"}, .seed = 1, .threads = 1});
  EXPECT_THAT(only_text(*compared.warnings, "dial_changed"), HasSubstr("from line 62"));
}

TEST(ChangedMidway, SingleAccidentsAndARightSessionAreNoChange) {
  for (std::uint64_t seed = 1; seed <= 6; ++seed) {
    session::Session session = by_dials(seed);
    EXPECT_EQ(codes_text(*calibrated(session).warnings), "");
    Drawn drawn(seed);
    for (int k = 0; k < 6; ++k) {
      auto& value = session.samples[drawn.below(session.samples.size())].channels[kC].value;
      if (value) *value += drawn.within(0.2, 3.0);
    }
    EXPECT_EQ(codes_text(*calibrated(session).warnings), "") << seed;
  }
}

TEST(ChangedMidway, AFrameThatWasMovedIsTold) {
  for (std::uint64_t seed = 1; seed <= 4; ++seed) {
    Drawn drawn(20 + seed);
    const std::size_t row = 15 + drawn.below(60);
    const Vector2d shift(drawn.within(0.1, 1.0), drawn.within(-1.0, -0.1));
    session::Session session = by_positions(seed);
    EXPECT_EQ(codes_text(plausible(session).warnings), "") << seed;
    const std::size_t dials = session.rig.dials.size();
    for (std::size_t i = row; i < session.samples.size(); ++i) {
      session::Sample& sample = session.samples[i];
      session::set_position(sample, dials, *session::position_of(sample, dials) + shift);
    }
    const auto judged = plausible(session);
    const std::string text = only_text(judged.warnings, "frame_moved");
    EXPECT_THAT(text, HasSubstr("are shifted by (")) << seed;
    EXPECT_EQ(judged.warnings.front().where.named.at(0).line, session.samples[row].line);
    EXPECT_FALSE(is_clean(judged.warnings));
  }
}

TEST(ChangedMidway, OnePositionBeyondAllUnitsLetsNoFitFail) {
  for (const double far : {1e300, -1e12, 1e7}) {
    session::Session session = by_positions(2);
    const std::size_t dials = session.rig.dials.size();
    session::set_position(session.samples[4], dials, Vector2d(far, 50.0));
    const auto result = calibrated(session);
    only_text(*result.warnings, "far_position");
    EXPECT_LT(result.rmse_mm, 0.05) << far;
  }
}

TEST(ChangedMidway, JointValuesOfTheRowAboveAreNamed) {
  for (const int step : {1, -1}) {
    const session::Session right = by_dials(8);
    session::Session session = right;
    for (std::size_t i = 1; i + 1 < right.samples.size(); ++i) {
      session.samples[i].q =
          right.samples[static_cast<std::size_t>(static_cast<std::ptrdiff_t>(i) - step)].q;
    }
    const auto judged = plausible(session);
    const Warning* warning = told(judged.warnings, "joints_of_other_row");
    ASSERT_NE(warning, nullptr) << codes_text(judged.warnings);
    EXPECT_EQ(text_of(*warning, "whose"), step > 0 ? "the row above" : "the row below");
    EXPECT_TRUE(forbids_commands(judged.warnings));
  }
}

TEST(ChangedMidway, OneJointInAnotherUnitOrAllAreNamed) {
  const std::vector<std::pair<std::string, double>> units{
      {"degrees", 180.0 / kPi}, {"gon", 200.0 / kPi}, {"turns", 0.5 / kPi}};
  for (const auto& [unit, factor] : units) {
    for (int which = 0; which < 3; ++which) {  // 0, 1: that joint; 2: both
      session::Session session = by_dials(9);
      for (session::Sample& sample : session.samples) {
        if (which != 1) sample.q[0] *= factor;
        if (which != 0) sample.q[1] *= factor;
      }
      const PlausibleSession judged = plausible(session);
      const std::string place =
          unit + " " + std::to_string(which) + ": " + codes_text(judged.warnings);
      const bool all_degrees = which == 2 && unit == "degrees";
      const Warning* warning =
          told(judged.warnings, all_degrees ? "joints_in_degrees" : "joint_unit");
      ASSERT_NE(warning, nullptr) << place;
      if (!all_degrees) {
        EXPECT_EQ(text_of(*warning, "unit"), unit) << place;
        EXPECT_EQ(
            text_of(*warning, "joints"),
            which == 2 ? "all joints" : "theta" + std::to_string(which + 1))
            << place;
      }
      EXPECT_EQ(told(judged.warnings, "dials_exchanged"), nullptr) << place;
      EXPECT_TRUE(forbids_commands(judged.warnings)) << place;
    }
  }
}

}  // namespace
}  // namespace sixdial::studies
