// Dials under another's name or in another unit, targets and angles that do not fit: named, and
// nothing is said where nothing is wrong. Drawn by the mock rig.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "geometry/units.h"
#include "studies/calibrate.h"
#include "tests/studies/drawn_sessions.h"

namespace sixdial::studies {
namespace {

using ::testing::HasSubstr;

// ---- Dials

session::Session with_columns(session::Session session, const std::vector<std::size_t>& from) {
  const session::Session as_is = session;
  for (std::size_t i = 0; i < session.samples.size(); ++i) {
    for (std::size_t k = 0; k < from.size(); ++k) {
      session.samples[i].channels[k] = as_is.samples[i].channels[from[k]];
    }
  }
  return session;
}

TEST(Dials, EveryPairThatIsExchangedIsNamed) {
  for (const geometry::Mount mount : {geometry::Mount::kDistal2, geometry::Mount::kFree}) {
    session::Session right = by_dials(31);
    right.rig.cuboid.mount = mount;
    int pairs = 0;
    for (std::size_t a = 0; a < 6; ++a) {
      for (std::size_t b = a + 1; b < 6; ++b) {
        std::vector<std::size_t> from{0, 1, 2, 3, 4, 5};
        std::swap(from[a], from[b]);
        const auto judged = plausible(with_columns(right, from));
        const Warning* warning = told(judged.warnings, "dials_exchanged");
        ASSERT_NE(warning, nullptr) << a << b << ": " << codes_text(judged.warnings);
        const auto& dials = right.rig.dials;
        EXPECT_EQ(text_of(*warning, "dials"), dials[a].id + " and " + dials[b].id);
        EXPECT_EQ(warning->severity, Severity::kWrong);
        EXPECT_EQ(exchanged_pair(judged), std::pair(a, b));
        for (std::size_t i = 0; i < right.samples.size(); ++i) {
          for (std::size_t k = 0; k < 6; ++k) {
            EXPECT_EQ(
                judged.session.samples[i].channels[k].value,
                right.samples[i].channels[k].value);
          }
        }
        ++pairs;
      }
    }
    EXPECT_EQ(pairs, 15);
  }
}

TEST(Dials, ExchangedInAnyOrderAreNamed) {
  Drawn drawn(37);
  for (int k = 0; k < 12; ++k) {
    std::vector<std::size_t> from{0, 1, 2, 3, 4, 5};
    const std::size_t first = drawn.below(4);  // three in a ring
    std::swap(from[first], from[first + 1]);
    std::swap(from[first + 1], from[first + 2]);
    const session::Session right = by_dials(40 + static_cast<std::uint64_t>(k));
    const auto judged = plausible(with_columns(right, from));
    const Warning* warning = told(judged.warnings, "dials_exchanged");
    ASSERT_NE(warning, nullptr) << codes_text(judged.warnings);
    for (std::size_t column = 0; column < 6; ++column) {
      if (from[column] == column) continue;
      const auto& dials = right.rig.dials;
      EXPECT_THAT(
          text_of(*warning, "how"),
          HasSubstr(dials[column].id + " shows " + dials[from[column]].id));
    }
  }
}

TEST(Dials, InAnotherUnitAreNamedOneOrAll) {
  struct Case {
    const char* unit;
    double mm;
  };
  for (const Case& each :
       {Case{"inches", 25.4}, Case{"centimetres", 10.0}, Case{"metres", 1000.0}}) {
    for (std::size_t dial = 0; dial <= 6; ++dial) {  // the last: all of them
      const session::Session right = by_dials(50 + dial);
      session::Session session = right;
      for (session::Sample& sample : session.samples) {
        for (std::size_t k = 0; k < 6; ++k) {
          auto& value = sample.channels[k].value;
          if (value && (k == dial || dial == 6)) *value /= each.mm;
        }
      }
      const auto judged = plausible(session);
      const Warning* warning = told(judged.warnings, "dial_unit");
      ASSERT_NE(warning, nullptr) << each.unit << dial << ": " << codes_text(judged.warnings);
      EXPECT_EQ(text_of(*warning, "unit"), each.unit);
      EXPECT_EQ(
          text_of(*warning, "dials"),
          dial == 6 ? "all dials" : "dial " + session.rig.dials[dial].id);
      EXPECT_EQ(warning->severity, Severity::kWrong);
      // The rest of the study sees millimetres, and nobody is accused of gross readings.
      for (std::size_t i = 0; i < session.samples.size(); ++i) {
        for (std::size_t k = 0; k < 6; ++k) {
          const auto& value = judged.session.samples[i].channels[k].value;
          if (value) {
            EXPECT_NEAR(*value, *right.samples[i].channels[k].value, 1e-9);
          }
        }
      }
    }
  }
}

TEST(Dials, ThatCountTheOtherWayAreNamedAndNotTakenForExchanged) {
  for (const std::vector<std::size_t>& reversed :
       {std::vector<std::size_t>{0}, {4}, {0, 1}, {2, 5}, {0, 1, 2, 3, 4, 5}}) {
    const session::Session right = by_dials(55);
    session::Session session = right;
    for (session::Sample& sample : session.samples) {
      for (const std::size_t k : reversed) {
        auto& value = sample.channels[k].value;
        if (value) *value = right.rig.dials[k].geometry.travel_mm - *value;
      }
    }
    const auto judged = plausible(session);
    const Warning* warning = told(judged.warnings, "dial_reversed");
    ASSERT_NE(warning, nullptr) << codes_text(judged.warnings);
    EXPECT_EQ(told(judged.warnings, "dials_exchanged"), nullptr);
    for (const std::size_t k : reversed) {
      const auto& value = judged.session.samples[7].channels[k].value;
      if (value) {
        EXPECT_NEAR(*value, *right.samples[7].channels[k].value, 1e-9);
      }
    }
  }
}

TEST(Dials, AShiftOfTheirMountsIsNoExchange) {
  for (const double shift_mm : {0.2, 1.0, 3.0}) {
    session::Session session = by_dials(61);
    for (session::Sample& sample : session.samples) {
      for (const std::size_t k : {2U, 3U}) {
        if (sample.channels[k].value) *sample.channels[k].value += shift_mm;
      }
    }
    EXPECT_EQ(told(plausible(session).warnings, "dials_exchanged"), nullptr);
  }
}

// ---- Nothing is told where nothing is wrong

TEST(UnitsAndFrames, NothingIsSaidOfRigsWithHonestFaults) {
  const geometry::Rig rig = geometry::default_rig();
  int sessions = 0;
  for (std::uint64_t seed = 1; seed <= 60; ++seed) {
    mock_devices::World world;
    world.robot = mock_devices::drawn_robot(rig, seed);
    world.seed = seed;
    const auto effect = mock_devices::draw_effect(rig, seed, mock_devices::Pool::kCatalogue);
    const auto& row = mock_devices::cause_row(effect.cause);
    if (row.swaps_cables || row.is_data_fault) continue;
    world.effects = {effect};
    session::Session session;
    try {
      session = session::parse_session(
          mock_devices::session_csv(
              mock_devices::generate_session(
                  world, mock_devices::random_plan(rig, seed, 40, 20)),
              rig, "2026-03-02T08:30:00.000Z"),
          "session.csv", mock_devices::rig_toml(rig), "rig.toml");
    } catch (const std::invalid_argument&) {
      continue;  // this robot cannot take the plan
    }
    ++sessions;
    const auto judged = plausible(session);
    EXPECT_EQ(codes_text(judged.warnings), "") << "seed " << seed << ' ' << effect.cause;
  }
  EXPECT_GT(sessions, 40);
}

// ---- Targets and angles

TEST(Targets, ThatDoNotFitTheJointAnglesAreNotWhatBeforeIsTakenFrom) {
  const session::Session right = by_dials(71);
  session::Session session = right;
  for (session::Sample& sample : session.samples) sample.target_mm->x() += 200.0;
  const CalibrationRequest request{.method = "lm", .seed = 1, .threads = 1};
  const CalibrationResult result = calibrate(session, request);
  ASSERT_TRUE(result.warnings);
  const Warning* warning = told(*result.warnings, "targets_elsewhere");
  ASSERT_NE(warning, nullptr) << codes_text(*result.warnings);
  EXPECT_EQ(warning->severity, Severity::kNote);
  EXPECT_EQ(warning->where.rows, 90);
  EXPECT_FALSE(result.before_uses_targets);
  EXPECT_LT(result.method("before")->g2->mean_mm, 10.0);
  // As they are commanded after a calibration they fit.
  session::Session commanded = right;
  for (session::Sample& sample : commanded.samples) *sample.target_mm += Vector2d(1.2, -0.9);
  EXPECT_EQ(told(plausible(commanded).warnings, "targets_elsewhere"), nullptr);
}

TEST(JointAngles, ThatJumpByAWholeTurnAreContinuousAgain) {
  for (const std::size_t joint : {0U, 1U}) {
    const session::Session right = by_dials(81);
    const auto k = static_cast<Eigen::Index>(joint);
    std::vector<double> angles;
    for (const session::Sample& sample : right.samples) angles.push_back(sample.q[k]);
    const double cut = geometry::median_of(angles);
    session::Session wrapped = right;
    int jumped = 0;
    for (session::Sample& sample : wrapped.samples) {
      if (sample.q[k] > cut + 0.05) {
        sample.q[k] -= 2 * kPi;
        ++jumped;
      }
    }
    const auto judged = plausible(wrapped);
    const Warning* warning = told(judged.warnings, "joint_wrapped");
    ASSERT_NE(warning, nullptr) << codes_text(judged.warnings);
    EXPECT_EQ(warning->severity, Severity::kNote);
    EXPECT_EQ(warning->where.rows, jumped);
    for (std::size_t i = 0; i < right.samples.size(); ++i) {
      EXPECT_NEAR(judged.session.samples[i].q[k], right.samples[i].q[k], 1e-12);
    }
  }
}

TEST(JointAngles, ThatTurnTheOtherWayAreNamed) {
  session::Session session = by_dials(91);
  for (session::Sample& sample : session.samples) sample.q = -sample.q;
  const auto judged = plausible(session);
  const Warning* warning = told(judged.warnings, "joint_reversed");
  ASSERT_NE(warning, nullptr) << codes_text(judged.warnings);
  EXPECT_EQ(warning->severity, Severity::kWrong);
}

}  // namespace
}  // namespace sixdial::studies
