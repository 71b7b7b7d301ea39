// The chain of derivatives against differences of the whole simulation, for every effect.
#include "simulation/extended_slopes.h"

#include <gtest/gtest.h>

#include <cmath>

#include "tests/simulation/law_rigs.h"

namespace sixdial::simulation {
namespace {

std::vector<EffectCase> cases_with_a_size() {
  std::vector<EffectCase> cases = effect_cases();
  std::erase_if(cases, [](const EffectCase& each) { return each.effect->exchanges_dials; });
  return cases;
}

void expect_chain_is_difference(const ForwardModel& model, const ActiveEffect& active) {
  const std::vector<Trial> trials = law_trials(model, 10, 80.0);
  ModelVector at = model.nominal();
  for (Eigen::Index k = 0; k < at.size(); ++k) {
    at[k] += (k % 2 ? 0.3 : -0.3) * model.parameters()[static_cast<std::size_t>(k)].change;
  }
  const auto samples = circumstances_of(model, at, trials);
  std::vector<EffectNumber> numbers;
  for (std::size_t k = 0; k < active.x.size() && !active.effect->is_curve; ++k) {
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
    for (std::size_t i = 0; i < own.reading.size(); ++i) {
      EXPECT_NEAR(scene.reading[i], own.reading[i], kRounding_mm);
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
        const auto channels = std::ssize(result.reading);
        Eigen::VectorXd values(3 + channels);
        values << result.p_WE, Eigen::Map<Eigen::VectorXd>(result.reading.data(), channels);
        return values;
      };
      const Eigen::VectorXd slope = (seen(step) - seen(-step)) / (2 * step);
      Eigen::VectorXd chain(slope.size());
      chain << found.tool.col(k), found.reading.col(k);
      // Rounding of readings of 50 mm over the step, and its square for what bends.
      const double tolerance = 2e-6 * slope.norm() + 1e-13 / step;
      EXPECT_LT((chain - slope).norm(), tolerance) << "column " << k << " sample " << t;
    }
  }
}

class EveryEffectsSlope : public testing::TestWithParam<EffectCase> {};

TEST_P(EveryEffectsSlope, IsThatOfTheWholeSimulation) {
  const ForwardModel model(law_rig(GetParam().rig));
  const Effect& effect = *GetParam().effect;
  expect_chain_is_difference(model, {&effect, GetParam().place, three_sizes(effect)});
}

INSTANTIATE_TEST_SUITE_P(
    , EveryEffectsSlope, testing::ValuesIn(cases_with_a_size()),
    [](const auto& each) { return each.param.name(); });

// An effect that was added at run time may look at anything that the scene holds.
TEST(ExtendedSlopes, FollowAnEffectThatLooksBackAtJointsAndLengths) {
  static constexpr EffectParameter kSize[] = {{"a", "1", 1e-2}};
  const Effect sag{
      .cause = "sag",
      .in_words = "sag",
      .places = [](const geometry::Rig& rig) { return at_one_place(rig, "links"); },
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
