// Laws that every effect of the catalogue keeps.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>
#include <set>
#include <string>

#include "simulation/effect.h"
#include "simulation/extended_model.h"

namespace sixdial::simulation {
namespace {

struct Case {
  const Effect* effect;
  Place place;
};

std::vector<Case> all_cases() {
  std::vector<Case> cases;
  const geometry::Rig rig = geometry::default_rig();
  for (const Effect* effect : all_effects()) {
    for (const Place& place : effect->places(rig)) cases.push_back({effect, place});
  }
  return cases;
}

class EveryEffect : public testing::TestWithParam<Case> {
 protected:
  ForwardModel model_{geometry::default_rig()};
  ExtendedModel plain_{model_, {}};
  std::vector<Trial> trials_ = [this] {
    std::mt19937_64 engine(3);
    std::uniform_real_distribution<double> x(16, 40), y(30, 66);
    std::vector<Trial> trials;
    for (int i = 0; i < 40; ++i) {
      Trial trial;
      trial.q = *geometry::inverse(
          model_.rig().robot.nominal, {x(engine), y(engine)}, {}, Eigen::Vector2d(1.4, 3.1));
      trial.time_s = 8.0 * i;
      trial.temperature_c = 20.0 + 0.1 * i;
      trial.approach = {i % 2 ? 1 : -1, i % 3 ? -1 : 1};
      const auto seen = model_.predict(model_.nominal(), trial.q, trial.assembly);
      for (int dial = 0; dial < 6; ++dial) {
        trial.reading.emplace_back(seen->reading[dial]);
      }
      trials.push_back(trial);
    }
    return trials;
  }();
  std::vector<Circumstance> circumstances_ =
      circumstances_of(model_, model_.nominal(), trials_);

  /// All readings and positions with the effect at x.
  [[nodiscard]] Eigen::VectorXd seen(const std::vector<double>& x) const {
    ActiveEffect active{GetParam().effect, GetParam().place, x};
    std::vector<double> values;
    Scene scene;
    for (std::size_t t = 0; t < trials_.size(); ++t) {
      EXPECT_TRUE(plain_.run(
          model_.nominal(), trials_[t], circumstances_[t], scene,
          x.empty() ? nullptr : &active));
      values.insert(values.end(), scene.reading_mm.begin(), scene.reading_mm.end());
      values.push_back(scene.p_WE.x());
      values.push_back(scene.p_WE.y());
    }
    return Eigen::Map<Eigen::VectorXd>(values.data(), static_cast<Eigen::Index>(values.size()));
  }
  /// `share` of one sigma of parameter i, all others zero; a searched value in its middle.
  [[nodiscard]] std::vector<double> only(std::size_t i, double share) const {
    const Effect& effect = *GetParam().effect;
    std::vector<double> x(effect.parameters.size(), 0.0);
    if (effect.searched) {
      const auto values = effect.searched(model_.rig(), circumstances_, GetParam().place);
      x.back() = values[values.size() / 2];
    }
    x[i] = share * effect.parameters[i].sigma;
    return x;
  }
  [[nodiscard]] std::size_t linear() const {
    return GetParam().effect->parameters.size() - (GetParam().effect->searched ? 1 : 0);
  }
};

TEST_P(EveryEffect, DoesNothingAtZero) {
  for (std::size_t i = 0; i < linear(); ++i) {
    EXPECT_EQ((seen(only(i, 0.0)) - seen({})).norm(), 0.0);
  }
}

TEST_P(EveryEffect, MovesAReadingAtOneSigma) {
  constexpr double kSeen_mm = 1e-4;
  double most = 0.0;
  for (std::size_t i = 0; i < linear(); ++i) {
    most = std::max(most, (seen(only(i, 1.0)) - seen({})).cwiseAbs().maxCoeff());
  }
  if (linear() == 0) {  // exchanged dials
    Scene scene;
    ActiveEffect active{GetParam().effect, GetParam().place, {}};
    ASSERT_TRUE(plain_.run(model_.nominal(), trials_[0], circumstances_[0], scene, &active));
    most = 1.0;
  }
  EXPECT_GT(most, kSeen_mm);
}

TEST_P(EveryEffect, IsSmoothInItsParameters) {
  for (std::size_t i = 0; i < linear(); ++i) {
    const Eigen::VectorXd whole = seen(only(i, 1.0)) - seen({});
    const Eigen::VectorXd half = 2 * (seen(only(i, 0.5)) - seen({}));
    // A step in x alone moves no joint: nothing to compare.
    if (whole.norm() == 0.0) continue;
    EXPECT_LT((whole - half).norm(), 0.02 * whole.norm())
        << GetParam().effect->parameters[i].name;
  }
}

TEST_P(EveryEffect, SaysWhatItIsInWords) {
  const Effect& effect = *GetParam().effect;
  for (const auto text :
       {effect.cause, effect.in_words, effect.signature, effect.consequence, effect.advice,
        effect.told_apart, effect.helps}) {
    EXPECT_FALSE(text.empty());
  }
  std::set<std::string_view> names;
  for (const EffectParameter& parameter : effect.parameters) {
    EXPECT_FALSE(parameter.unit.empty());
    EXPECT_GT(parameter.sigma, 0.0);
    EXPECT_TRUE(names.insert(parameter.name).second) << parameter.name;
  }
  EXPECT_EQ(find_effect(effect.cause), &effect);
}

INSTANTIATE_TEST_SUITE_P(, EveryEffect, testing::ValuesIn(all_cases()), [](const auto& each) {
  std::string name = std::string(each.param.effect->cause) + "_" + each.param.place.name;
  std::replace(name.begin(), name.end(), ',', '_');
  return name;
});

TEST(Effects, TheCatalogueIsInOrderAndWithoutDoubles) {
  std::string last;
  for (const Effect* effect : all_effects()) {
    EXPECT_LT(last, std::string(effect->cause));
    last = effect->cause;
  }
  // Of spec 4, where outliers and stale readings are per sample; more may come.
  EXPECT_GE(all_effects().size(), 20U);
  EXPECT_EQ(find_effect("none_such"), nullptr);
}

}  // namespace
}  // namespace sixdial::simulation
