// What units, frames and exchanged columns do to a session, and that every study is told: drawn
// variants of each, made by the mock rig.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <functional>
#include <numbers>
#include <random>

#include "geometry/registration.h"
#include "geometry/units.h"
#include "session/sample_layout.h"
#include "session/trials.h"
#include "studies/calibrate.h"
#include "studies/compare.h"
#include "studies/plausibility.h"
#include "tests/support/simulated.h"

namespace sixdial::studies {
namespace {

using Eigen::Vector2d;
using ::testing::HasSubstr;
using testing::measured;
using testing::simple_world;

constexpr double kPi = std::numbers::pi;

class Drawn {
 public:
  explicit Drawn(std::uint64_t seed) : engine_(seed) {}
  double within(double low, double high) {
    return std::uniform_real_distribution<double>(low, high)(engine_);
  }
  std::size_t below(std::size_t n) {
    return std::uniform_int_distribution<std::size_t>(0, n - 1)(engine_);
  }

 private:
  std::mt19937_64 engine_;
};

/// A robot around nominal, 60 points of G1 and 30 of G2 read by six dials.
session::Session by_dials(
    std::uint64_t seed, const geometry::Rig& rig = geometry::default_rig()) {
  mock_devices::World world;
  world.rig = rig;
  world.robot = mock_devices::drawn_robot(rig, seed);
  world.seed = seed;
  session::Session session = session::parse_session(
      mock_devices::session_csv(
          mock_devices::generate_session(world, mock_devices::random_plan(rig, seed, 60, 30)),
          rig, "2026-03-02T08:30:00.000Z"),
      "session.csv", mock_devices::rig_toml(rig), "rig.toml");
  session.name = "drawn";
  return session;
}

/// The same as an instrument would have measured it: positions alone.
session::Session by_positions(std::uint64_t seed) {
  session::Session session = by_dials(seed);
  const std::size_t dials = session.rig.dials.size();
  std::vector<session::Sample> samples;
  for (const simulation::Trial& trial : session::trials_of(session, "")) {
    if (!trial.position_mm) continue;
    session::Sample sample = session.samples[static_cast<std::size_t>(trial.sample)];
    for (std::size_t k = 0; k < dials; ++k) sample.channels[k] = {};
    session::set_position(sample, dials, *trial.position_mm);
    samples.push_back(std::move(sample));
  }
  session.samples = std::move(samples);
  return session;
}

using Change = std::function<Vector2d(const Vector2d&)>;

session::Session changed(session::Session session, const Change& change) {
  const std::size_t dials = session.rig.dials.size();
  for (session::Sample& sample : session.samples) {
    const Vector2d at = *session::position_of(sample, dials);
    session::set_position(sample, dials, change(at));
  }
  return session;
}

Change rigid(double turn_rad, const Vector2d& shift_mm) {
  const Eigen::Rotation2Dd turn(turn_rad);
  return [turn, shift_mm](const Vector2d& p) -> Vector2d { return turn * p + shift_mm; };
}

const Warning* told(const std::vector<Warning>& warnings, std::string_view code) {
  const auto found = std::ranges::find(warnings, code, &Warning::code);
  return found == warnings.end() ? nullptr : &*found;
}

std::string text_of(const Warning& warning, const std::string& part) {
  return std::get<std::string>(warning.parts.at(part));
}
double figure_of(const Warning& warning, const std::string& part) {
  return std::get<double>(warning.parts.at(part));
}

std::string codes_of(const std::vector<Warning>& warnings) {
  std::string codes;
  for (const Warning& each : warnings) codes += each.code + " ";
  return codes;
}

/// Median distance between the measured positions of two sessions.
double apart_mm(const session::Session& a, const session::Session& b) {
  std::vector<double> apart;
  for (std::size_t i = 0; i < a.samples.size(); ++i) {
    apart.push_back((*session::position_of(a.samples[i], a.rig.dials.size()) -
                     *session::position_of(b.samples[i], b.rig.dials.size()))
                        .norm());
  }
  return geometry::median_of(apart);
}

// ---- Units of positions

TEST(UnitOfPositions, IsNamedAndNothingIsCalibrated) {
  struct Case {
    const char* name;
    double mm;
  };
  for (const Case& unit :
       {Case{"inches", 25.4}, Case{"metres", 1000.0}, Case{"centimetres", 10.0},
        Case{"micrometres", 1e-3}}) {
    for (std::uint64_t seed = 1; seed <= 3; ++seed) {
      const session::Session right = by_positions(seed);
      const auto judged =
          plausible(changed(right, [&](const Vector2d& p) -> Vector2d { return p / unit.mm; }));
      const Warning* warning = told(judged.warnings, "position_unit");
      ASSERT_NE(warning, nullptr) << unit.name << ": " << codes_of(judged.warnings);
      EXPECT_EQ(text_of(*warning, "unit"), unit.name);
      EXPECT_DOUBLE_EQ(figure_of(*warning, "factor"), unit.mm);
      EXPECT_FALSE(is_clean(judged.warnings));
      EXPECT_TRUE(forbids_commands(judged.warnings));
      // What follows is at least of the right size.
      EXPECT_LT(apart_mm(judged.session, right), 1e-9);
    }
  }
}

TEST(UnitOfPositions, AndTheFrameAndTheHandednessAtOnce) {
  Drawn drawn(5);
  for (std::uint64_t seed = 1; seed <= 4; ++seed) {
    const Change frame = rigid(drawn.within(-kPi, kPi), {200.0, -150.0});
    const auto judged = plausible(changed(by_positions(seed), [&](const Vector2d& p) {
      const Vector2d there = frame(p);
      return Vector2d(there.y() / 25.4, there.x() / 25.4);
    }));
    EXPECT_NE(told(judged.warnings, "position_unit"), nullptr) << codes_of(judged.warnings);
    const bool mirrored = told(judged.warnings, "frame_mirrored") != nullptr ||
                          told(judged.warnings, "axis_reversed") != nullptr ||
                          told(judged.warnings, "columns_exchanged") != nullptr;
    EXPECT_TRUE(mirrored) << codes_of(judged.warnings);
  }
}

// ---- Frames

TEST(Frame, IsRegisteredBeforeAnySearchAndTheLinksAreTheSame) {
  Drawn drawn(11);
  for (const double turn_deg : {0.0, 12.0, 90.0, -137.0, 180.0}) {
    const session::Session right = by_positions(7);
    const Vector2d shift(drawn.within(300, 600), drawn.within(-500, -200));
    const session::Session turned =
        changed(right, rigid(turn_deg * geometry::kRadPerDeg, shift));
    const CalibrationRequest request{.method = "lm", .seed = 3, .threads = 1};
    const CalibrationResult before = calibrate(right, request);
    const CalibrationResult after = calibrate(turned, request);
    ASSERT_TRUE(after.warnings);
    const Warning* warning = told(*after.warnings, "frame_registered");
    ASSERT_NE(warning, nullptr) << codes_of(*after.warnings);
    EXPECT_EQ(warning->severity, Severity::kNote);
    EXPECT_NEAR(std::remainder(figure_of(*warning, "turn") - turn_deg, 360.0), 0.0, 2.0);
    EXPECT_NEAR(after.rmse_mm, before.rmse_mm, 1e-6);
    for (std::size_t i = 0; i < before.parameters.size(); ++i) {
      const ParameterRow& here = before.parameters[i];
      const ParameterRow& there = after.parameters[i];
      const bool of_the_base = here.name == "x0" || here.name == "y0" || here.name == "alpha";
      if (of_the_base) continue;
      EXPECT_NEAR(there.identified, here.identified, 1e-4) << here.name << " at " << turn_deg;
      EXPECT_NEAR(there.sd, here.sd, 1e-3 * here.sd + 1e-9) << here.name;
    }
    const double alpha = after.parameters[7].identified - before.parameters[7].identified;
    EXPECT_NEAR(std::remainder(alpha - turn_deg * geometry::kRadPerDeg, 2 * kPi), 0.0, 1e-6);
    // "Before" is the robot's error, not the frame's.
    EXPECT_LT(after.method("before")->g2->mean_mm, 5.0);
  }
}

TEST(Frame, EveryMethodStartsThere) {
  const session::Session turned =
      changed(by_positions(9), rigid(100.0 * geometry::kRadPerDeg, {-250.0, 400.0}));
  const ComparisonResult result = compare(
      turned, {.methods = {"before", "lse", "lm", "ekf", "ekf_dqpso"},
               .seed = 1,
               .threads = 1,
               .qpso1_iterations = 20,
               .qpso2_iterations = 60});
  for (const ComparedRow& row : result.methods) {
    ASSERT_TRUE(row.g2) << row.id;
    EXPECT_LT(row.g2->mean_mm, row.id == "before" ? 5.0 : 0.1) << row.id;
  }
}

TEST(Frame, GrossRowsDoNotTurnIt) {
  Drawn drawn(13);
  for (std::uint64_t seed = 1; seed <= 4; ++seed) {
    session::Session session = changed(by_positions(seed), rigid(2.0, {350.0, -220.0}));
    for (std::size_t i = 0; i < session.samples.size(); i += 6) {
      const Vector2d slip(drawn.within(-300, 300), drawn.within(20, 200));
      const Vector2d at = *session::position_of(session.samples[i], session.rig.dials.size());
      session::set_position(session.samples[i], session.rig.dials.size(), at + slip);
    }
    const auto judged = plausible(session);
    const Warning* warning = told(judged.warnings, "frame_registered");
    ASSERT_NE(warning, nullptr);
    EXPECT_NEAR(figure_of(*warning, "turn"), 2.0 * geometry::kDegPerRad, 2.0);
  }
}

TEST(Frame, OfARobotBesideItsPlaceMovesTheBaseAndLeavesTheTargets) {
  // Where the rig file has the base 7 mm beside where it stands.
  session::Session session = by_dials(21);
  session.rig.robot.nominal[*session.rig.robot.model->find_parameter("x0")] += 7.0;
  const auto judged = plausible(session);
  const Warning* warning = told(judged.warnings, "base_registered");
  ASSERT_NE(warning, nullptr) << codes_of(judged.warnings);
  EXPECT_EQ(warning->severity, Severity::kNote);
  EXPECT_FALSE(judged.frame);
  for (std::size_t i = 0; i < session.samples.size(); ++i) {
    EXPECT_EQ(judged.session.samples[i].target_mm, session.samples[i].target_mm);
  }
}

TEST(Frame, ThatIsMirroredIsNamed) {
  Drawn drawn(17);
  for (std::uint64_t seed = 1; seed <= 3; ++seed) {
    const session::Session right = by_positions(seed);
    struct Case {
      const char* code;
      Change change;
    };
    const double turn = drawn.within(0.5, 1.0);
    const std::vector<Case> cases{
        {"columns_exchanged",
         [](const Vector2d& p) -> Vector2d {
           return {p.y(), p.x()};
         }},
        {"axis_reversed",
         [](const Vector2d& p) -> Vector2d {
           return {p.x(), -p.y()};
         }},
        {"axis_reversed",
         [](const Vector2d& p) -> Vector2d {
           return {-p.x(), p.y()};
         }},
        {"frame_mirrored", [&](const Vector2d& p) -> Vector2d {
           return rigid(turn, {100.0, 200.0})({p.x(), -p.y()});
         }}};
    for (const Case& each : cases) {
      const auto judged = plausible(changed(right, each.change));
      const Warning* warning = told(judged.warnings, each.code);
      ASSERT_NE(warning, nullptr) << each.code << ": " << codes_of(judged.warnings);
      EXPECT_TRUE(forbids_commands(judged.warnings));
      EXPECT_LT(figure_of(*warning, "miss"), figure_of(*warning, "now") / 3.0);
    }
  }
}

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
        ASSERT_NE(warning, nullptr) << a << b << ": " << codes_of(judged.warnings);
        const auto& dials = right.rig.dials;
        EXPECT_EQ(text_of(*warning, "dials"), dials[a].id + " and " + dials[b].id);
        EXPECT_EQ(warning->severity, Severity::kWrong);
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
    ASSERT_NE(warning, nullptr) << codes_of(judged.warnings);
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
  for (const Case& each : {Case{"inches", 25.4}, Case{"centimetres", 10.0}}) {
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
      ASSERT_NE(warning, nullptr) << each.unit << dial << ": " << codes_of(judged.warnings);
      EXPECT_EQ(text_of(*warning, "unit"), each.unit);
      EXPECT_EQ(
          text_of(*warning, "dials"),
          dial == 6 ? "all dials" : "dial " + session.rig.dials[dial].id);
      EXPECT_EQ(warning->severity, Severity::kWrong);
      // The rest of the study sees millimetres, and nobody is accused of gross readings.
      for (std::size_t i = 0; i < session.samples.size(); ++i) {
        for (std::size_t k = 0; k < 6; ++k) {
          const auto& value = judged.session.samples[i].channels[k].value;
          if (value) EXPECT_NEAR(*value, *right.samples[i].channels[k].value, 1e-9);
        }
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
    EXPECT_EQ(codes_of(judged.warnings), "") << "seed " << seed << ' ' << effect.cause;
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
  ASSERT_NE(warning, nullptr) << codes_of(*result.warnings);
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
    ASSERT_NE(warning, nullptr) << codes_of(judged.warnings);
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
  ASSERT_NE(warning, nullptr) << codes_of(judged.warnings);
  EXPECT_EQ(warning->severity, Severity::kWrong);
}

}  // namespace
}  // namespace sixdial::studies
