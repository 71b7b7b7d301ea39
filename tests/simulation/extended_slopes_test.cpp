// The chain of derivatives against differences of the whole simulation, for every effect.
#include "simulation/extended_slopes.h"

#include <gtest/gtest.h>

#include <cmath>
#include <ostream>
#include <random>

namespace sixdial::simulation {
namespace {

struct Case {
  const Effect* effect;
  Place place;
  friend void PrintTo(const Case& each, std::ostream* out) {
    *out << each.effect->cause << "@" << each.place.name;
  }
};

std::vector<Case> all_cases() {
  std::vector<Case> cases;
  const geometry::Rig rig = geometry::default_rig();
  for (const Effect* effect : all_effects()) {
    if (effect->exchanges_dials) continue;  // no size to differentiate by
    for (const Place& place : effect->places(rig)) cases.push_back({effect, place});
  }
  return cases;
}

/// A few samples with all that an effect may ask for.
std::vector<Trial> some_trials(const ForwardModel& model) {
  std::mt19937_64 engine(3);
  std::uniform_real_distribution<double> x(18, 38), y(32, 62);
  std::vector<Trial> trials;
  for (int i = 0; i < 10; ++i) {
    Trial trial;
    trial.q = *geometry::inverse(
        model.rig().robot.nominal, {x(engine), y(engine)}, {}, Eigen::Vector2d(1.4, 3.1));
    trial.time_s = 80.0 * i;
    trial.temperature_c = 20.0 + 0.4 * i;
    trial.approach = {i % 2 ? 1 : -1, i % 3 ? -1 : 1};
    const auto seen = model.predict(model.nominal(), trial.q, trial.assembly);
    for (const double reading_mm : seen->reading) trial.reading.emplace_back(reading_mm);
    trials.push_back(trial);
  }
  return trials;
}

void expect_chain_is_difference(const ForwardModel& model, const ActiveEffect& active) {
  const std::vector<Trial> trials = some_trials(model);
  ModelVector at = model.nominal();
  for (Eigen::Index k = 0; k < at.size(); ++k) {
    at[k] += (k % 2 ? 0.3 : -0.3) * model.parameters()[static_cast<std::size_t>(k)].change;
  }
  const auto samples = circumstances_of(model, at, trials);
  std::vector<EffectNumber> numbers;
  for (std::size_t k = 0; k < active.x.size(); ++k) {
    const bool last = k + 1 == active.x.size();
    const Effect& effect = *active.effect;
    if (effect.searched && last && !effect.searched_change) continue;
    numbers.push_back(
        {0, k,
         effect.searched && last ? effect.searched_change(active.x[k])
                                 : 1e-2 * effect.parameters[k].sigma});
  }
  const ExtendedModel extended(model, {active});
  ExtendedSlopes slopes(extended, numbers);
  ExtendedSlopes::Slopes found;
  Scene scene;
  for (std::size_t t = 0; t < trials.size(); ++t) {
    ASSERT_TRUE(slopes.at(at, trials[t], samples[t], scene, found));
    Scene own;
    ASSERT_TRUE(extended.run(at, trials[t], samples[t], own));
    // Left at the sample's own values: a robot may work out its pose by a shorter way where no
    // derivative is asked for, which rounds otherwise.
    constexpr double kRounding_mm = 1e-12;  // 60 mm links in double precision
    for (std::size_t i = 0; i < own.reading_mm.size(); ++i) {
      EXPECT_NEAR(scene.reading_mm[i], own.reading_mm[i], kRounding_mm);
    }
    EXPECT_LT((scene.p_WE - own.p_WE).norm(), kRounding_mm);
    for (Eigen::Index k = 0; k < slopes.count(); ++k) {
      const bool of_model = k < at.size();
      const double step = of_model
                              ? 1e-3 * model.parameters()[static_cast<std::size_t>(k)].change
                              : numbers[static_cast<std::size_t>(k - at.size())].step;
      const auto seen = [&](double change) {
        ModelVector moved = at;
        ExtendedModel there = extended;
        if (of_model) {
          moved[k] += change;
        } else {
          there.effects()[0].x[numbers[static_cast<std::size_t>(k - at.size())].parameter] +=
              change;
        }
        Scene result;
        EXPECT_TRUE(there.run(moved, trials[t], samples[t], result));
        Eigen::VectorXd values(8);
        values.head<2>() = result.p_WE;
        for (int i = 0; i < 6; ++i) {
          values[2 + i] = result.reading_mm[static_cast<std::size_t>(i)];
        }
        return values;
      };
      const Eigen::VectorXd slope = (seen(step) - seen(-step)) / (2 * step);
      Eigen::VectorXd chain(8);
      chain << found.tool.col(k), found.reading.col(k);
      // Rounding of readings of 50 mm over the step, and its square for what bends.
      const double tolerance = 2e-6 * slope.norm() + 1e-13 / step;
      EXPECT_LT((chain - slope).norm(), tolerance) << "column " << k << " sample " << t;
    }
  }
}

class EveryEffectsSlope : public testing::TestWithParam<Case> {};

TEST_P(EveryEffectsSlope, IsThatOfTheWholeSimulation) {
  const ForwardModel model(geometry::default_rig());
  const Effect& effect = *GetParam().effect;
  ActiveEffect active{&effect, GetParam().place, {}};
  for (const EffectParameter& each : effect.parameters) active.x.push_back(3 * each.sigma);
  expect_chain_is_difference(model, active);
}

INSTANTIATE_TEST_SUITE_P(
    , EveryEffectsSlope, testing::ValuesIn(all_cases()), [](const auto& each) {
      return std::string(each.param.effect->cause) + "_" + each.param.place.name;
    });

// An effect that was added at run time may look at anything that the scene holds.
TEST(ExtendedSlopes, FollowAnEffectThatLooksBackAtJointsAndLengths) {
  static constexpr EffectParameter kSize[] = {{"a", "1", 1e-2}};
  const Effect sag{
      .cause = "sag",
      .in_words = "sag",
      .places = [](const geometry::Rig&) { return at_one_place("links"); },
      .parameters = kSize,
      .after_kinematics =
          [](std::span<const double> x, const Place&, const Circumstance&, Scene& scene) {
            scene.p_WE.y() -= x[0] * scene.v[0] * std::cos(scene.q[0]) * scene.v[0] / 60;
          }};
  const ForwardModel model(geometry::default_rig());
  expect_chain_is_difference(model, {&sag, Place{.name = "links"}, {0.05}});
}

}  // namespace
}  // namespace sixdial::simulation
