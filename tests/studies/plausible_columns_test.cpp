// Times, temperatures and sets of whole columns, and dials at their ends.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <chrono>
#include <cmath>

#include "report/words/warning_words.h"
#include "tests/studies/plausible_session.h"

namespace sixdial::studies {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;

TEST(PlausibleColumns, AYearBetweenTwoRowsIsTold) {
  const PlausibleSession judged = plausible(session_with([](session::Session& each) {
    for (std::size_t i = each.samples.size() / 2; i < each.samples.size(); ++i) {
      *each.samples[i].time_utc += std::chrono::hours(365 * 24);
    }
  }));
  EXPECT_EQ(only_warning(judged).code, "long_pause");
  EXPECT_THAT(report::warning_text(judged.warnings[0]), HasSubstr("365 days lie between"));
}

TEST(PlausibleColumns, AUnitThatWasChangedMidwayConvertsItsRowsAlone) {
  const session::Session right = right_session();
  struct Unit {
    const char* name;
    double factor, offset;
  };
  for (const Unit& unit :
       {Unit{"kelvin", 1.0, 273.15}, Unit{"degrees Fahrenheit", 1.8, 32.0},
        Unit{"tenths of a degree", 10.0, 0.0}}) {
    for (const std::size_t begin : {std::size_t{0}, right.samples.size() / 2}) {
      const PlausibleSession judged = plausible(session_with([&](session::Session& each) {
        for (std::size_t i = begin; i < each.samples.size(); ++i) {
          auto& degC = each.samples[i].temperature_c;
          degC = unit.factor * *degC + unit.offset;
        }
      }));
      const Warning told = only_warning(judged);
      EXPECT_EQ(told.code, "temperature_unit");
      EXPECT_THAT(report::warning_text(told), HasSubstr(unit.name));
      EXPECT_EQ(told.where.rows, static_cast<int>(right.samples.size() - begin));
      for (std::size_t i = 0; i < right.samples.size(); ++i) {
        EXPECT_NEAR(
            *judged.session.samples[i].temperature_c, *right.samples[i].temperature_c, 1e-9);
      }
    }
  }
}

TEST(PlausibleColumns, AThermometerThatIsNotThereGivesNoTemperature) {
  for (const double value : {0.0, -127.0, 850.0}) {
    const PlausibleSession judged = plausible(session_with([&](session::Session& each) {
      for (session::Sample& sample : each.samples) sample.temperature_c = value;
    }));
    EXPECT_EQ(only_warning(judged).code, "no_temperature");
    EXPECT_FALSE(judged.session.samples[3].temperature_c.has_value());
  }
  // Often, but not always, it says that it has nothing to say.
  const PlausibleSession often = plausible(session_with([](session::Session& each) {
    for (std::size_t i = 3; i < each.samples.size(); i += 8) {
      each.samples[i].temperature_c = -85.0;
    }
  }));
  EXPECT_EQ(only_warning(often).code, "wrong_temperature");
}

TEST(PlausibleColumns, ADialAtTheEndOfItsTravelIsCounted) {
  constexpr std::size_t kD = 3;
  int pushed = 0;
  const PlausibleSession judged = plausible(session_with([&](session::Session& each) {
    for (std::size_t i = 0; i < each.samples.size(); i += 7) {
      auto& value = each.samples[i].channels[kD].value;
      if (!value) continue;
      value = each.rig.dials[kD].geometry.travel_mm;
      ++pushed;
    }
  }));
  const Warning told = only_warning(judged);
  EXPECT_EQ(told.code, "end_of_travel");
  EXPECT_EQ(told.where.rows, pushed);
  EXPECT_THAT(report::warning_text(told), HasSubstr("Dial D is pushed to the end"));
}

TEST(PlausibleColumns, HowLittleG2CanSayIsTold) {
  const PlausibleSession few = plausible(session_with([](session::Session& each) {
    int kept = 0;
    std::erase_if(each.samples, [&](const session::Sample& sample) {
      return sample.set == "G2" && ++kept > 2;
    });
  }));
  EXPECT_THAT(codes_of(few.warnings), ElementsAre("few_validating"));
  // At the poses of G1, measured again: it shows noise, no other place.
  const PlausibleSession again = plausible(session_with([](session::Session& each) {
    std::vector<session::Sample> g2;
    std::erase_if(
        each.samples, [](const session::Sample& sample) { return sample.set == "G2"; });
    for (std::size_t i = 0; i < 20; ++i) {
      session::Sample sample = each.samples[i];
      sample.set = "G2";
      for (session::ChannelValue& reading : sample.channels) {
        if (reading.value) *reading.value += 0.001 * (1 + static_cast<int>(i % 2));
      }
      *sample.time_utc += std::chrono::hours(2);
      g2.push_back(sample);
    }
    each.samples.insert(each.samples.end(), g2.begin(), g2.end());
  }));
  EXPECT_THAT(codes_of(again.warnings), ElementsAre("g2_at_poses_of_g1"));
  EXPECT_THAT(report::warning_text(again.warnings[0]), HasSubstr("20 rows of 20 of G2 stand"));
}

TEST(PlausibleColumns, StepsThatTheRigFileDoesNotStateAreToldAndUsed) {
  constexpr std::size_t kB = 1;
  // Rounded by who wrote the file; and a file that states a resolution of other dials.
  const PlausibleSession coarse = plausible(session_with([](session::Session& each) {
    for (session::Sample& sample : each.samples) {
      auto& value = sample.channels[kB].value;
      if (value) value = std::round(*value / 0.01) * 0.01;
    }
  }));
  Warning told = only_warning(coarse);
  EXPECT_EQ(told.code, "resolution");
  EXPECT_THAT(
      report::warning_text(told),
      HasSubstr("dial B come in steps of 0.01 mm, where the rig file states a resolution of "
                "0.001 mm"));
  EXPECT_EQ(coarse.session.rig.dials[kB].resolution_mm, 0.01);
  EXPECT_EQ(coarse.session.rig.dials[0].resolution_mm, 0.001);
  const PlausibleSession slip = plausible(session_with([](session::Session& each) {
    for (geometry::Dial& dial : each.rig.dials) dial.resolution_mm = 1.0;
  }));
  told = only_warning(slip);
  EXPECT_EQ(told.code, "resolution");
  EXPECT_THAT(
      report::warning_text(told),
      HasSubstr("dials A, B, C, D, E and F come in steps of 0.001 mm"));
  // A mean of three readings, as somebody wrote it: more digits, and no other dial.
  const PlausibleSession mean = plausible(session_with([](session::Session& each) {
    int third = 0;
    for (session::Sample& sample : each.samples) {
      for (session::ChannelValue& reading : sample.channels) {
        if (!reading.value) continue;
        third = (third + 1) % 3;
        reading.value = std::round((*reading.value + third * 1e-3 / 3.0) * 1e4) / 1e4;
      }
    }
  }));
  EXPECT_TRUE(mean.warnings.empty());
}

TEST(PlausibleColumns, ADialWithoutAnyReadingIsTold) {
  const PlausibleSession judged = plausible(session_with([](session::Session& each) {
    for (session::Sample& sample : each.samples) {
      sample.channels[0].value.reset();
      sample.channels[4].value.reset();
    }
  }));
  ASSERT_EQ(judged.warnings.size(), 1U);
  EXPECT_EQ(only_warning(judged).code, "silent_dial");
  EXPECT_THAT(report::warning_text(judged.warnings[0]), HasSubstr("dials A and E"));
}

}  // namespace
}  // namespace sixdial::studies
