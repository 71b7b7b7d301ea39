// What a sample owes to its past, and what nobody knows of it.
#include "simulation/circumstances.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "geometry/same_pose.h"
#include "simulation/extended_model.h"

namespace sixdial::simulation {
namespace {

constexpr double kNoise_mm = 0.002;

/// Twelve points, each measured three times; readings with noise.
struct Walked {
  ForwardModel model{geometry::default_rig()};
  std::vector<Trial> trials;

  explicit Walked(double jitter_rad = 0.0, int repeats = 3, int points = 12) {
    std::mt19937_64 engine(7);
    std::normal_distribution<double> normal;
    std::uniform_real_distribution<double> x(18, 38), y(32, 62);
    const geometry::Rig& rig = model.rig();
    for (int point = 0; point < points; ++point) {
      const auto q = geometry::inverse(
          rig.robot.nominal, {x(engine), y(engine)}, {}, Eigen::Vector2d(1.4, 3.1));
      for (int repeat = 0; repeat < repeats; ++repeat) {
        Trial trial;
        trial.point = point;
        trial.repeat = repeat;
        trial.q = *q;
        for (double& each : trial.q) each += jitter_rad * normal(engine);
        trial.time_s = 8.0 * static_cast<double>(trials.size());
        trial.temperature_c = 20 + 0.01 * *trial.time_s;
        for (Eigen::Index joint = 0; joint < 2 && !trials.empty(); ++joint) {
          const double way = trial.q[joint] - trials.back().q[joint];
          const bool still = repeat > 0;
          trial.approach.push_back(
              still ? trials.back().approach_of(static_cast<std::size_t>(joint))
                    : (way > 0 ? 1 : -1));
        }
        const auto seen = model.predict(model.nominal(), trial.q, trial.assembly);
        for (const double reading_mm : seen->reading) {
          trial.reading.emplace_back(reading_mm + kNoise_mm * normal(engine));
        }
        trials.push_back(trial);
      }
    }
  }
  [[nodiscard]] std::vector<Circumstance> circumstances() const {
    return circumstances_of(model, model.nominal(), trials);
  }
};

void expect_directions_of_real_moves(const Walked& walked, std::size_t repeats) {
  const auto samples = walked.circumstances();
  for (std::size_t t = repeats; t < samples.size(); ++t) {
    const std::size_t first = t - t % repeats;
    EXPECT_EQ(samples[t].plunger_direction, samples[first].plunger_direction) << t;
    EXPECT_EQ(samples[t].travel, samples[first].travel) << t;
    EXPECT_NEAR(samples[t].travel.norm(), 1.0, 1e-12);
    EXPECT_EQ(samples[t].approach, samples[first].approach) << t;
    for (std::size_t dial = 0; dial < 6; ++dial) {
      const double way =
          *walked.trials[first].reading[dial] - *walked.trials[first - 1].reading[dial];
      if (std::abs(way) < 0.05) continue;
      EXPECT_EQ(samples[t].plunger_direction[dial], way > 0 ? 1.0 : -1.0) << t;
    }
  }
}

TEST(Circumstances, StandingStillIsNoMotion) { expect_directions_of_real_moves(Walked(), 3); }

TEST(Circumstances, TheJitterOfEncodersIsNoMotion) {
  expect_directions_of_real_moves(Walked(1e-5), 3);
}

TEST(Circumstances, SidesThatNobodyRecordedAreThoseOfTheMoves) {
  Walked walked;
  const auto recorded = walked.circumstances();
  for (Trial& trial : walked.trials) trial.approach.clear();
  for (const SidesFrom from : sides_from(walked.model.robot(), walked.trials)) {
    EXPECT_EQ(from, SidesFrom::kRows);
  }
  const auto samples = walked.circumstances();
  EXPECT_TRUE(samples[0].approach.isZero()) << "nobody knows where the robot came from";
  int unknown = 0;
  for (std::size_t t = 3; t < samples.size(); ++t) {
    const std::size_t first = t - t % 3;
    for (Eigen::Index joint = 0; joint < 2; ++joint) {
      // By chance one pose has nearly the joint value of the one before.
      const double way = walked.trials[first].q[joint] - walked.trials[first - 1].q[joint];
      const bool hardly = std::abs(way) < geometry::kSamePose_rad;
      unknown += hardly;
      EXPECT_EQ(samples[t].approach[joint], hardly ? 0.0 : recorded[t].approach[joint]) << t;
    }
  }
  EXPECT_EQ(unknown, 3);
}

TEST(Circumstances, SidesOfOneJointWithTheOtherSignAreTurnedRound) {
  Walked walked(0.0, 1, 60);
  const auto recorded = walked.circumstances();
  for (Trial& trial : walked.trials) {
    if (trial.approach.size() == 2) trial.approach[1] *= -1;
  }
  const auto from = sides_from(walked.model.robot(), walked.trials);
  EXPECT_EQ(from, (std::vector{SidesFrom::kColumns, SidesFrom::kReversed}));
  const auto samples = walked.circumstances();
  for (std::size_t t = 1; t < samples.size(); ++t) {
    EXPECT_EQ(samples[t].approach, recorded[t].approach) << t;
    EXPECT_EQ(samples[t].plunger_direction, recorded[t].plunger_direction) << t;
  }
}

// Who sends the robot behind each pose first, to the side that a plan asks for, goes against
// half of the moves; always from the same side, against any share of them.
TEST(Circumstances, SidesThatAPlanAskedForStayAsTheyAre) {
  Walked walked(0.0, 1, 60);
  for (std::size_t t = 1; t < walked.trials.size(); ++t) {
    walked.trials[t].approach = {t % 2 == 0 ? 1 : -1, -1};
  }
  for (const SidesFrom from : sides_from(walked.model.robot(), walked.trials)) {
    EXPECT_EQ(from, SidesFrom::kColumns);
  }
  Walked falling(0.0, 1, 60);  // a joint that only ever turns down, always come to from below
  for (std::size_t t = 0; t < falling.trials.size(); ++t) {
    falling.trials[t].q[0] = 1.5 - 0.005 * static_cast<double>(t);
    if (t > 0) falling.trials[t].approach[0] = 1;
  }
  EXPECT_EQ(sides_from(falling.model.robot(), falling.trials)[0], SidesFrom::kColumns);
}

TEST(Circumstances, AnEmptySideAtAPoseThatWasNotLeftIsThatOfTheLastMove) {
  Walked walked;
  for (std::size_t t = 0; t < walked.trials.size(); ++t) {
    if (t % 3 != 0) walked.trials[t].approach = {0, 0};
  }
  expect_directions_of_real_moves(walked, 3);
  // Moved, and nobody says from where: unknown.
  walked.trials[6].approach = {0, 0};
  EXPECT_TRUE(walked.circumstances()[6].approach.isZero());
}

// A joint that hardly moves changes its side all the same; a point that was skipped is not in
// the session, so that the next one seems to come from elsewhere.
TEST(Circumstances, OneOddSideDoesNotMakeASessionFromBothSides) {
  Walked walked;
  const auto before = walked.circumstances();
  walked.trials[9].approach[0] *= -1;
  walked.trials[10].approach = walked.trials[11].approach = walked.trials[9].approach;
  const auto after = walked.circumstances();
  for (std::size_t t = 12; t < after.size(); ++t) {
    EXPECT_EQ(after[t].plunger_direction, before[t].plunger_direction) << t;
  }
}

// A session that was measured from both sides: the last way is the one that was asked for.
TEST(Circumstances, APlungerFollowsTheSideThatItsJointsCameFrom) {
  Walked walked(0.0, 2);
  for (std::size_t t = 0; t < walked.trials.size(); ++t) {
    const int side = t % 2 == 0 ? 1 : -1;
    walked.trials[t].approach = {side, side};
  }
  const auto samples = walked.circumstances();
  int told = 0;
  for (std::size_t t = 0; t < samples.size(); ++t) {
    const double side = t % 2 == 0 ? 1 : -1;
    const auto at = [&](double away_rad) {
      return walked.model.predict(
          walked.model.nominal(),
          walked.trials[t].q + away_rad * side * Eigen::Vector2d::Ones(),
          walked.trials[t].assembly);
    };
    const Eigen::VectorXd way_mm = at(0.0)->reading - at(-0.01)->reading;
    for (std::size_t dial = 0; dial < 6; ++dial) {
      const double mm = way_mm[static_cast<Eigen::Index>(dial)];
      if (std::abs(mm) < 0.05) continue;
      ++told;
      EXPECT_EQ(samples[t].plunger_direction[dial], mm > 0 ? 1.0 : -1.0) << t;
    }
    EXPECT_GT(samples[t].travel.dot(at(0.0)->frames.X[0].p - at(-0.01)->frames.X[0].p), 0.0);
  }
  EXPECT_GT(told, 100);
}

TEST(Circumstances, ALostReadingStillIsAForce) {
  Walked walked;
  const auto whole = walked.circumstances();
  walked.trials[9].reading[3].reset();
  const auto lost = walked.circumstances();
  ASSERT_GT(whole[9].plunger_force_n[3], 1.0);
  EXPECT_NEAR(lost[9].plunger_force_n[3], whole[9].plunger_force_n[3], 1e-3);
  EXPECT_EQ(lost[9].plunger_direction, whole[9].plunger_direction);
  // A dial that the cuboid does not reach is free.
  geometry::Rig rig = geometry::default_rig();
  rig.dials[3].geometry.position_mm -= 100 * rig.dials[3].geometry.axis;
  const ForwardModel away(rig);
  for (Trial& trial : walked.trials) trial.reading[3].reset();
  EXPECT_EQ(circumstances_of(away, away.nominal(), walked.trials)[9].plunger_force_n[3], 0.0);
}

TEST(Circumstances, ABlankTemperatureOrTimeIsTakenFromItsNeighbours) {
  Walked walked;
  const auto whole = walked.circumstances();
  walked.trials[9].temperature_c.reset();
  walked.trials[20].time_s.reset();
  const auto blank = walked.circumstances();
  EXPECT_NEAR(blank[9].temperature_degC, whole[9].temperature_degC, 1e-9);
  EXPECT_NEAR(blank[20].time_h, whole[20].time_h, 1e-9);
  EXPECT_EQ(whole[9].temperature_sd_degC, 0.0);
  // Nobody recorded any: the reference, and nothing to doubt.
  for (Trial& trial : walked.trials) trial.temperature_c.reset();
  const auto none = walked.circumstances();
  EXPECT_EQ(none[9].temperature_degC, 20.0);
  EXPECT_EQ(none[9].temperature_sd_degC, 0.0);
}

TEST(Circumstances, WhatNobodyKnowsIsInDoubt) {
  Walked walked;
  walked.trials[0].approach = {0, 0};
  walked.trials[30].temperature_c.reset();
  walked.trials[31].temperature_c = *walked.trials[31].temperature_c + 0.1;
  const auto samples = walked.circumstances();
  const auto doubts = doubts_of(samples);
  int sides = 0, temperatures = 0, others = 0;
  for (const Doubt& each : doubts) {
    const bool first_point = each.trial < 3;
    const bool side = each.otherwise.approach != samples[each.trial].approach;
    const bool warm = each.otherwise.temperature_degC != samples[each.trial].temperature_degC;
    sides += side;
    temperatures += warm;
    others += !side && !warm;
    EXPECT_TRUE(warm ? each.trial == 30 : first_point) << each.trial;
  }
  EXPECT_EQ(sides, 3 * 2);
  EXPECT_EQ(temperatures, 1);
  EXPECT_EQ(others, 3 * (2 + 6));  // travel and plungers, before the first move
}

// The deviation that it states is the one that it makes: 95 % within 1.96 of it.
TEST(WithoutGaps, StatesHowFarOffItIs) {
  std::mt19937_64 engine(5);
  std::normal_distribution<double> normal;
  int inside = 0, tried = 0;
  for (int session = 0; session < 40; ++session) {
    std::vector<double> along{0.0};
    std::vector<double> truth{20.0};
    for (int i = 1; i < 150; ++i) {
      along.push_back(along.back() + 8);
      truth.push_back(truth.back() + 0.05 * normal(engine));
    }
    std::vector<std::optional<double>> values(truth.begin(), truth.end());
    for (int i = 5; i < 150; i += 7) values[static_cast<std::size_t>(i)].reset();
    for (int i = 60; i < 75; ++i) values[static_cast<std::size_t>(i)].reset();
    const auto filled = without_gaps(along, values);
    for (std::size_t i = 0; i < truth.size(); ++i) {
      if (values[i]) {
        EXPECT_EQ(filled[i].value, truth[i]);
        EXPECT_EQ(filled[i].sd, 0.0);
        continue;
      }
      ++tried;
      inside += std::abs(filled[i].value - truth[i]) < 1.96 * filled[i].sd;
    }
  }
  EXPECT_GT(tried, 1000);
  EXPECT_NEAR(static_cast<double>(inside) / tried, 0.95, 0.03);
}

// Virtual work: the torque is what the displacements of the plungers say, whatever they press.
TEST(Torque, IsTheVirtualWorkOfThePlungers) {
  const Walked walked;
  const auto samples = walked.circumstances();
  const ExtendedModel plain(walked.model, {});
  const ModelVector at = walked.model.nominal();
  for (std::size_t t = 0; t < samples.size(); t += 5) {
    const Trial& trial = walked.trials[t];
    const auto torque = plain.torque_Nmm(at, trial, samples[t]);
    ASSERT_TRUE(torque.has_value());
    for (Eigen::Index joint = 0; joint < 2; ++joint) {
      constexpr double kStep_rad = 1e-5;
      const auto reading = [&](double step) {
        Eigen::VectorXd q = trial.q;
        q[joint] += step;
        return walked.model.predict(at, q, trial.assembly)->reading;
      };
      const Eigen::VectorXd by_q = (reading(kStep_rad) - reading(-kStep_rad)) / (2 * kStep_rad);
      double work = 0.0;
      for (std::size_t dial = 0; dial < 6; ++dial) {
        work -= samples[t].plunger_force_n[dial] * by_q[static_cast<Eigen::Index>(dial)];
      }
      EXPECT_NEAR((*torque)[joint], work, 1e-5 * std::abs(work) + 1e-5);
    }
  }
}

}  // namespace
}  // namespace sixdial::simulation
