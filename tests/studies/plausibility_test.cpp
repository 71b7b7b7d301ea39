// What speaks against a session is found before any number is believed: one session that is
// right, and each kind of fault put into it.
#include "studies/plausibility.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <functional>
#include <set>

#include "geometry/units.h"
#include "report/documents/calibration_json.h"
#include "report/documents/warnings_document.h"
#include "report/headline.h"
#include "report/report_run.h"
#include "report/words/warning_words.h"
#include "session/bundle.h"
#include "session/sample_layout.h"
#include "session/trials.h"
#include "studies/calibrate.h"
#include "studies/compare.h"
#include "studies/plausibility/check.h"
#include "tests/studies/plausible_session.h"
#include "tests/support/paths.h"

namespace sixdial::studies {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::Not;

TEST(Plausibility, ARightSessionIsLeftAsItIs) {
  const session::Session session = right_session();
  const PlausibleSession judged = plausible(session);
  EXPECT_THAT(judged.warnings, IsEmpty()) << report::warnings_text(judged.warnings);
  EXPECT_EQ(
      session::trials_of(judged.session, "").size(), session::trials_of(session, "").size());
}

TEST(Plausibility, EveryCodeHasWordsAndStandsOnce) {
  std::set<std::string_view> seen;
  for (const plausibility::PlausibilityCheck& check : plausibility::checks()) {
    for (const std::string_view code : check.codes) {
      EXPECT_TRUE(report::has_words(code)) << code;
      EXPECT_TRUE(seen.insert(code).second) << code;
    }
  }
  EXPECT_GT(seen.size(), 10U);
}

TEST(Plausibility, ASetThatIsNotUsedIsListedWithItsCount) {
  for (const char* name : {"g1", "Gl", "G 1", "G3", "warm-up"}) {
    const session::Session session = session_with([&](session::Session& each) {
      for (std::size_t i = 0; i < each.samples.size(); i += 3) each.samples[i].set = name;
    });
    const Warning told = only_warning(plausible(session));
    EXPECT_EQ(told.code, "set_not_used");
    EXPECT_EQ(told.where.rows, static_cast<int>((session.samples.size() + 2) / 3));
    EXPECT_THAT(report::warning_text(told), HasSubstr("\"" + std::string(name) + "\""));
    const bool slip = std::string(name) != "G3" && std::string(name) != "warm-up";
    EXPECT_EQ(told.parts.contains("meant"), slip) << name;
    EXPECT_EQ(told.severity, slip ? Severity::kDoubt : Severity::kNote);
  }
}

TEST(Plausibility, ADialThatNeverMovesAndOneThatIsACopyAreNotUsed) {
  constexpr std::size_t kD = 3;
  const PlausibleSession stuck = plausible(session_with([](session::Session& each) {
    for (session::Sample& sample : each.samples) {
      if (sample.channels[kD].value) sample.channels[kD].value = 12.345;
    }
  }));
  const Warning told = only_warning(stuck);
  EXPECT_EQ(told.code, "stuck_column");
  EXPECT_EQ(told.severity, Severity::kDoubt);
  EXPECT_THAT(report::warning_text(told), HasSubstr("Dial D reads 12.345 mm"));
  for (const session::Sample& sample : stuck.session.samples) {
    if (sample.channels[kD].value) {
      EXPECT_EQ(sample.channels[kD].quality, session::Quality::kBad);
    }
  }
  const PlausibleSession copied = plausible(session_with([](session::Session& each) {
    for (session::Sample& sample : each.samples) sample.channels[1] = sample.channels[0];
  }));
  EXPECT_EQ(only_warning(copied).code, "copied_columns");
  EXPECT_THAT(report::warning_text(copied.warnings[0]), HasSubstr("Dials A and B"));
  // A plunger at its stop stays there.
  EXPECT_THAT(
      codes_of(plausible(session_with([](session::Session& each) {
                 for (session::Sample& sample : each.samples) sample.channels[kD].value = 0.0;
               })).warnings),
      IsEmpty());
}

TEST(Plausibility, CopiedRowsCountOnce) {
  const session::Session right = right_session();
  const session::Session session = session_with([&](session::Session& each) {
    for (std::size_t i = 0; i < 20; ++i) {
      session::Sample copy = right.samples[i];
      copy.point += 1000;
      each.samples.push_back(copy);
    }
  });
  const PlausibleSession judged = plausible(session);
  const Warning told = only_warning(judged);
  EXPECT_EQ(told.code, "copied_rows");
  EXPECT_EQ(told.where.rows, 20);
  EXPECT_EQ(counted(judged, ""), right.samples.size());
}

TEST(Plausibility, CopiedRepeatsCountOnceAndAreNotCalledRows) {
  const session::Session right = right_session();
  const session::Session session = session_with([&](session::Session& each) {
    for (std::size_t i = 0; i < 30; ++i) {
      session::Sample copy = right.samples[i];
      copy.repeat = 1;
      each.samples.push_back(copy);
    }
  });
  const Warning told = only_warning(plausible(session));
  EXPECT_EQ(told.code, "copied_repeats");
  EXPECT_EQ(told.where.rows, 30);
}

TEST(Plausibility, AReadingThatDiffersInTheLastDigitIsNoCopy) {
  const session::Session right = right_session();
  const session::Session session = session_with([&](session::Session& each) {
    for (std::size_t i = 0; i < 30; ++i) {
      session::Sample copy = right.samples[i];
      copy.repeat = 1;
      const auto read = std::ranges::find_if(
          copy.channels, [](const auto& channel) { return channel.value.has_value(); });
      ASSERT_NE(read, copy.channels.end());  // not every dial touches at every pose
      *read->value += 0.001;
      *copy.time_utc += std::chrono::hours(5);
      each.samples.push_back(copy);
    }
  });
  EXPECT_THAT(plausible(session).warnings, IsEmpty());
}

TEST(Plausibility, ARowOfG2ThatRepeatsG1ValidatesNothing) {
  std::size_t copied = 0;
  const session::Session session = session_with([&](session::Session& each) {
    std::vector<session::Sample> g1;
    for (const session::Sample& sample : each.samples) {
      if (sample.set == "G1") g1.push_back(sample);
    }
    for (session::Sample& sample : each.samples) {
      if (sample.set != "G2" || copied == 30) continue;
      const int point = sample.point;
      sample = g1[copied++];
      sample.set = "G2";
      sample.point = point;
    }
  });
  const PlausibleSession judged = plausible(session);
  const Warning told = only_warning(judged);
  EXPECT_EQ(told.code, "g2_repeats_g1");
  EXPECT_EQ(told.where.rows, static_cast<int>(copied));
  EXPECT_EQ(static_cast<double>(counted(judged, "G2")), number(told, "left"));
  const CalibrationResult result = calibrate(session, quick());
  EXPECT_EQ(result.method("lm")->g2->points, static_cast<int>(counted(judged, "G2")));
}

TEST(Plausibility, AWrongDateIsNamedAndTheRestIsUsed) {
  const session::Session right = right_session();
  const std::size_t n = right.samples.size();
  for (const std::size_t row : {std::size_t{0}, std::size_t{1}, n / 2, n - 1}) {
    for (const auto wrong :
         {std::chrono::hours(-24 * 365 * 56), std::chrono::hours(24 * 31),
          std::chrono::hours(30)}) {
      const session::Session session =
          session_with([&](session::Session& each) { *each.samples[row].time_utc += wrong; });
      const PlausibleSession judged = plausible(session);
      const Warning told = only_warning(judged);
      EXPECT_EQ(told.code, "wrong_date") << row;
      ASSERT_EQ(told.where.named.size(), 1U);
      EXPECT_EQ(told.where.named[0].line, right.samples[row].line);
      // Between its neighbours, or at the one that it has.
      const auto off = *judged.session.samples[row].time_utc - *right.samples[row].time_utc;
      EXPECT_LT(std::abs(std::chrono::duration<double>(off).count()), 60.0) << row;
    }
  }
}

TEST(Plausibility, AFewWrongDatesTogetherAreNamed) {
  const session::Session right = right_session();
  const session::Session session = session_with([](session::Session& each) {
    for (const std::size_t row : {7U, 8U, 9U}) {
      *each.samples[row].time_utc -= std::chrono::hours(48);
    }
    *each.samples[12].time_utc -= std::chrono::hours(24 * 365 * 56);
  });
  const PlausibleSession judged = plausible(session);
  const Warning told = only_warning(judged);
  EXPECT_EQ(told.code, "wrong_date");
  EXPECT_EQ(told.where.rows, 4);
  for (const std::size_t row : {7U, 8U, 9U, 12U}) {
    const auto off = *judged.session.samples[row].time_utc - *right.samples[row].time_utc;
    EXPECT_LT(std::abs(std::chrono::duration<double>(off).count()), 60.0) << row;
  }
}

TEST(Plausibility, OneTimeForAllRowsIsNone) {
  const PlausibleSession judged = plausible(session_with([](session::Session& each) {
    for (session::Sample& sample : each.samples) {
      sample.time_utc = each.samples.front().time_utc;
    }
  }));
  EXPECT_EQ(only_warning(judged).code, "same_time");
  EXPECT_FALSE(judged.session.samples.back().time_utc.has_value());
}

TEST(Plausibility, AClockThatWasSetBackLeavesTheOrderOfMeasuring) {
  const session::Session right = right_session();
  const std::size_t from = 37;
  const session::Session session = session_with([&](session::Session& each) {
    for (std::size_t i = from; i < each.samples.size(); ++i) {
      *each.samples[i].time_utc -= std::chrono::minutes(20);
    }
  });
  const PlausibleSession judged = plausible(session);
  const Warning told = only_warning(judged);
  EXPECT_EQ(told.code, "clock_set_back");
  EXPECT_EQ(told.where.named.at(0).line, right.samples[from].line);
  for (std::size_t i = 1; i < judged.session.samples.size(); ++i) {
    EXPECT_LE(*judged.session.samples[i - 1].time_utc, *judged.session.samples[i].time_utc)
        << i;
  }
}

TEST(Plausibility, ANightBetweenTwoDaysIsNoFault) {
  const session::Session session = session_with([](session::Session& each) {
    for (std::size_t i = each.samples.size() / 2; i < each.samples.size(); ++i) {
      *each.samples[i].time_utc += std::chrono::hours(16);
    }
  });
  EXPECT_THAT(plausible(session).warnings, IsEmpty());
}

TEST(Plausibility, OneWrongTemperatureIsNamedAndTheRestIsUsed) {
  const session::Session right = right_session();
  for (const std::size_t row : {std::size_t{0}, std::size_t{60}, right.samples.size() - 1}) {
    for (const double wrong : {2137.0, 0.0, 293.2, -5.0}) {
      const session::Session session = session_with(
          [&](session::Session& each) { each.samples[row].temperature_c = wrong; });
      const PlausibleSession judged = plausible(session);
      const Warning told = only_warning(judged);
      EXPECT_EQ(told.code, "wrong_temperature") << wrong;
      EXPECT_EQ(told.where.named.at(0).line, right.samples[row].line);
      EXPECT_NEAR(
          *judged.session.samples[row].temperature_c, *right.samples[row].temperature_c, 1.0);
    }
  }
}

TEST(Plausibility, TemperaturesInAnotherUnitAreReadAsSuch) {
  const session::Session right = right_session();
  const auto in = [&](double factor, double zero) {
    return session_with([&](session::Session& each) {
      for (session::Sample& sample : each.samples) {
        sample.temperature_c = factor * *sample.temperature_c + zero;
      }
    });
  };
  for (const auto& [session, unit] :
       {std::pair{in(1.0, 273.15), "kelvin"}, std::pair{in(1.8, 32.0), "degrees Fahrenheit"}}) {
    const PlausibleSession judged = plausible(session);
    const Warning told = only_warning(judged);
    EXPECT_EQ(told.code, "temperature_unit");
    EXPECT_THAT(report::warning_text(told), HasSubstr(unit));
    EXPECT_NEAR(
        *judged.session.samples[7].temperature_c, *right.samples[7].temperature_c, 1e-9);
  }
}

TEST(Plausibility, ValuesThatStandForNoReadingAreToldWithTheirCount) {
  for (const double none : {-999.0, 9999.0, 77.7}) {
    const session::Session session = session_with([&](session::Session& each) {
      for (std::size_t i = 4; i < each.samples.size(); i += 10)
        each.samples[i].channels[2].value = none;
    });
    const Warning told = only_warning(plausible(session));
    EXPECT_EQ(told.code, "reading_for_none") << none;
    EXPECT_EQ(std::get<std::string>(told.parts.at("dial")), session.rig.dials[2].id);
    EXPECT_EQ(number(told, "value"), none);
    EXPECT_EQ(told.where.rows, static_cast<int>((session.samples.size() - 4 + 9) / 10));
  }
}

TEST(Plausibility, TheSignOfADialIsSuspected) {
  for (const std::size_t dial : {std::size_t{1}, std::size_t{4}}) {
    const session::Session session = session_with([&](session::Session& each) {
      for (session::Sample& sample : each.samples) {
        if (sample.channels[dial].value) *sample.channels[dial].value *= -1.0;
      }
    });
    const PlausibleSession judged = plausible(session);
    const Warning told = only_warning(judged);
    EXPECT_EQ(told.code, "sign_of_dial");
    EXPECT_FALSE(is_clean(judged.warnings));
  }
}

TEST(Plausibility, SingleReadingsOutsideTheTravelAreAlwaysTold) {
  const session::Session session = session_with([](session::Session& each) {
    each.samples[10].channels[0].value = 60.123;
    each.samples[20].channels[0].value = -7.5;
  });
  const Warning told = only_warning(plausible(session));
  EXPECT_EQ(told.code, "outside_travel");
  EXPECT_EQ(told.where.rows, 2);
  EXPECT_EQ(told.severity, Severity::kNote);
}

TEST(Plausibility, ARowInDegreesIsTheRowsFaultAndNoDials) {
  const session::Session right = right_session();
  for (const std::size_t row : {std::size_t{0}, std::size_t{33}}) {
    const session::Session session = session_with(
        [&](session::Session& each) { each.samples[row].q *= geometry::kDegPerRad; });
    const PlausibleSession judged = plausible(session);
    const Warning told = only_warning(judged);
    EXPECT_EQ(told.code, "row_in_degrees");
    EXPECT_EQ(told.where.named.at(0).line, right.samples[row].line);
    EXPECT_EQ(counted(judged, ""), right.samples.size() - 1);
  }
}

TEST(Plausibility, OneJointInDegreesIsEnough) {
  const session::Session session = session_with(
      [](session::Session& each) { each.samples[12].q[1] *= geometry::kDegPerRad; });
  EXPECT_EQ(only_warning(plausible(session)).code, "row_in_degrees");
}

TEST(Plausibility, JointValuesOfAnotherPoseAreTheRowsFaultAndNoDials) {
  const session::Session right = right_session();
  const std::vector<std::function<void(Eigen::VectorXd&)>> slips{
      [](Eigen::VectorXd& q) { q[0] += 0.3; }, [](Eigen::VectorXd& q) { q[1] -= 0.2; },
      [](Eigen::VectorXd& q) { q[0] += 0.2, q[1] += 0.3; }};
  for (const auto& slip : slips) {
    const session::Session session =
        session_with([&](session::Session& each) { slip(each.samples[40].q); });
    const PlausibleSession judged = plausible(session);
    const Warning told = only_warning(judged);
    EXPECT_EQ(told.code, "row_elsewhere");
    EXPECT_EQ(told.where.named.at(0).line, right.samples[40].line);
    EXPECT_EQ(counted(judged, ""), right.samples.size() - 1);
  }
}

TEST(Plausibility, RowsOfAnotherYearAreNamedTogether) {
  const session::Session session = session_with([](session::Session& each) {
    for (std::size_t i = 0; i < 4; ++i) {
      *each.samples[i].time_utc -= std::chrono::hours(24 * 365 * 10);
    }
  });
  const Warning told = only_warning(plausible(session));
  EXPECT_EQ(told.code, "wrong_date");
  EXPECT_EQ(told.where.rows, 4);
}

TEST(Plausibility, TheAssemblyOfAllSamplesGoesBeforeThatOfTheRigFile) {
  const session::Session session = session_with(
      [](session::Session& each) { each.rig.robot.assembly = geometry::Assembly::kRight; });
  const PlausibleSession judged = plausible(session);
  EXPECT_THAT(codes_of(judged.warnings), ::testing::Contains("wrong_assembly"));
  EXPECT_EQ(judged.session.rig.robot.assembly, geometry::Assembly::kLeft);
}

TEST(Plausibility, TheModeOfAllSamplesGoesBeforeThatOfTheRigFile) {
  for (const auto& wrong :
       {geometry::WorkingMode(-1, -1), geometry::WorkingMode(1, -1),
        geometry::WorkingMode(-1, 1)}) {
    const session::Session right = right_session();
    const session::Session session =
        session_with([&](session::Session& each) { each.rig.robot.working_mode = wrong; });
    const PlausibleSession judged = plausible(session);
    const Warning told = only_warning(judged);
    EXPECT_EQ(told.code, "wrong_mode");
    EXPECT_EQ(working_mode_in_use(judged.warnings, session.rig), right.rig.robot.working_mode);
    EXPECT_EQ(judged.session.rig.robot.working_mode, right.rig.robot.working_mode);
    EXPECT_EQ(
        report::verdict_of(calibrate(session, quick())).state,
        report::CalibrationState::kNotCalibrated);
  }
}

TEST(Plausibility, AReferencePoseThatIsNotTheRigsIsNamedInsteadOfReadings) {
  for (const Eigen::Vector2d& pose :
       {Eigen::Vector2d(0.0, 60.0), Eigen::Vector2d(40.0, 30.0)}) {
    const session::Session session =
        session_with([&](session::Session& each) { each.rig.cuboid.reference_pose_mm = pose; });
    const PlausibleSession judged = plausible(session);
    const Warning told = only_warning(judged);
    EXPECT_EQ(told.code, "reference_pose");
    EXPECT_THAT(report::warning_line(told), HasSubstr("rig.toml"));
    const CalibrationResult result = calibrate(session, quick());
    EXPECT_THAT(result.gross_errors->found, IsEmpty());
    EXPECT_EQ(report::verdict_of(result).state, report::CalibrationState::kNotCalibrated);
  }
}

TEST(Plausibility, AMountThatIsNotTheRigsIsNamed) {
  const session::Session session = session_with(
      [](session::Session& each) { each.rig.cuboid.mount = geometry::Mount::kDistal1; });
  const PlausibleSession judged = plausible(session);
  EXPECT_THAT(codes_of(judged.warnings), ::testing::Contains("mount"));
  EXPECT_TRUE(forbids_commands(judged.warnings));
}

/// Positions beside the dials, shifted.
session::Session with_positions(const Eigen::Vector2d& shift_mm) {
  return session_with([&](session::Session& each) {
    for (session::Sample& sample : each.samples) {
      const auto at = session::trial_of(each.rig, sample).position_mm;
      if (at) session::set_position(sample, each.rig.dials.size(), *at + shift_mm);
    }
  });
}

TEST(Plausibility, PositionsThatContradictTheDialsAreToldAndOneIsUsed) {
  const PlausibleSession judged = plausible(with_positions({10.0, 0.0}));
  const Warning told = only_warning(judged);
  EXPECT_EQ(told.code, "positions_and_dials_differ");
  EXPECT_NEAR(number(told, "apart"), 10.0, 0.1);
  EXPECT_EQ(std::get<std::string>(told.parts.at("used")), "the dials");
  for (const session::Sample& sample : judged.session.samples) {
    EXPECT_FALSE(session::position_of(sample, judged.session.rig.dials.size()));
  }
  EXPECT_THAT(plausible(with_positions({0.0, 0.0})).warnings, IsEmpty());
}

}  // namespace
}  // namespace sixdial::studies
