// Laws that every effect of the catalogue keeps, and the laws tried on effects that break them.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <iostream>
#include <string>
#include <utility>

#include "simulation/effect_words.h"
#include "tests/simulation/effect_laws.h"

namespace sixdial::simulation {
namespace {

using testing::Contains;
using testing::IsEmpty;

class EveryEffect : public testing::TestWithParam<EffectCase> {
 protected:
  EffectLaws laws_{GetParam().rig};
  const Effect& effect_ = *GetParam().effect;
  Place place_ = GetParam().place;
};

TEST_P(EveryEffect, DoesNothingAtZero) {
  EXPECT_THAT(laws_.does_nothing_at_zero(effect_, place_), IsEmpty());
}

TEST_P(EveryEffect, HasNoParameterThatDoesNothing) {
  EXPECT_THAT(laws_.every_parameter_acts(effect_, place_), IsEmpty());
}

TEST_P(EveryEffect, IsSmoothInItsParameters) {
  EXPECT_THAT(laws_.is_smooth(effect_, place_), IsEmpty());
}

TEST_P(EveryEffect, ExchangesReadingsIfItSaysSo) {
  EXPECT_THAT(laws_.exchanges_its_dials(effect_, place_), IsEmpty());
}

TEST_P(EveryEffect, SaysWhatItIsInWords) {
  EXPECT_THAT(laws_.says_what_it_is(effect_, place_), IsEmpty());
}

TEST_P(EveryEffect, SaysHowLargeItIs) {
  EXPECT_THAT(laws_.says_its_size(effect_, place_), IsEmpty());
  std::cout << effect_.cause << " at " << place_.name << ": "
            << EffectLaws::example_of_size(effect_, place_) << "\n";
}

INSTANTIATE_TEST_SUITE_P(
    , EveryEffect, testing::ValuesIn(effect_cases()),
    [](const auto& each) { return each.param.name(); });

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

// ---- Effects that are wrong on purpose, each for one law.

constexpr EffectParameter kAngles[] = {{"a", "rad", 1e-3}, {"b", "rad", 1e-3}};

/// Two waves over a joint's angle; keeps every law.
void bend(std::span<const double> x, const Place& place, const Circumstance&, Scene& scene) {
  const double q = scene.q[place.joint];
  scene.q[place.joint] += x[0] * std::sin(4 * q) + x[1] * std::cos(4 * q);
}

Effect right() {
  return {
      .cause = "joint_fourth_harmonic",
      .in_words = "fourth harmonic",
      .places = at_each_joint,
      .parameters = kAngles,
      .before_kinematics = bend,
      .size = "amplitude {a,b}",
      .twin = "joint_fourth_harmonic",
      .signature = "Four waves.",
      .consequence = "Parts are off.",
      .advice = "Look at the gear.",
      .told_apart = "By the number of waves.",
      .helps = "A wide range."};
}

class Laws : public testing::Test {
 protected:
  EffectLaws laws_;
  Place place_ = at_each_joint(laws_.rig())[0];
};

TEST_F(Laws, AreKeptByAnEffectAddedAtRunTime) {
  const Effect effect = right();
  const AddedEffect added(effect);
  EXPECT_THAT(laws_.all(effect, place_), IsEmpty());
}

TEST_F(Laws, FindAParameterThatDoesNothing) {
  Effect effect = right();
  effect.before_kinematics = [](std::span<const double> x, const Place& place,
                                const Circumstance&, Scene& scene) {
    scene.q[place.joint] += x[0] * std::sin(4 * scene.q[place.joint]);
  };
  EXPECT_THAT(laws_.every_parameter_acts(effect, place_), Contains("b moves nothing"));
}

TEST_F(Laws, FindASearchedParameterThatDoesNothing) {
  Effect effect = right();
  effect.searched = [](const geometry::Rig&, std::span<const Circumstance>, const Place&) {
    return std::vector<double>{1.0, 2.0, 3.0};
  };
  effect.before_kinematics = [](std::span<const double> x, const Place& place,
                                const Circumstance&, Scene& scene) {
    scene.q[place.joint] += x[0] * std::sin(4 * scene.q[place.joint]);
  };
  EXPECT_THAT(laws_.every_parameter_acts(effect, place_), Contains("b moves nothing"));
}

TEST_F(Laws, FindAParameterThatActsWhereItIsSaidToBeMissing) {
  Effect effect = right();
  effect.parameter_of_place = [](const Place&, int k) -> std::optional<EffectParameter> {
    if (k == 1) return std::nullopt;
    return kAngles[0];
  };
  EXPECT_THAT(
      laws_.every_parameter_acts(effect, place_),
      Contains("b acts where it is said to be missing"));
}

TEST_F(Laws, FindAnOffsetAtZero) {
  Effect effect = right();
  effect.before_kinematics = [](std::span<const double> x, const Place& place,
                                const Circumstance&,
                                Scene& scene) { scene.q[place.joint] += 1e-6 + x[0]; };
  EXPECT_THAT(laws_.does_nothing_at_zero(effect, place_), Not(IsEmpty()));
}

TEST_F(Laws, FindAKink) {
  Effect effect = right();
  effect.before_kinematics = [](std::span<const double> x, const Place& place,
                                const Circumstance&, Scene& scene) {
    scene.q[place.joint] += std::sqrt(std::abs(x[0] * 1e-3)) + x[1];
  };
  EXPECT_THAT(laws_.is_smooth(effect, place_), Contains("a is not smooth"));
}

TEST_F(Laws, FindDialsThatAreNotExchanged) {
  Effect effect = *find_effect("dial_swap");
  const Place pair = at_each_pair_of_dials(laws_.rig())[3];
  ASSERT_THAT(laws_.exchanges_its_dials(effect, pair), IsEmpty());
  effect.after_reading = [](std::span<const double>, const Place& place, const Circumstance&,
                            Scene& scene) {
    scene.reading[static_cast<std::size_t>(place.dial)] =
        scene.reading[static_cast<std::size_t>(place.other_dial)];
  };
  EXPECT_THAT(laws_.exchanges_its_dials(effect, pair), Not(IsEmpty()));
}

TEST_F(Laws, FindWhatIsNotSaid) {
  Effect effect = right();
  effect.size = "amplitude {a}";
  const AddedEffect added(effect);
  EXPECT_THAT(
      laws_.says_its_size(effect, place_), Contains("b is not in the words of its size"));
  effect.twin = "";
  EXPECT_THAT(laws_.says_what_it_is(effect, place_), Contains("a name or a text is missing"));
  effect.never_negative = true;
  EXPECT_THAT(
      laws_.says_what_it_is(effect, place_),
      Contains("it is never negative, but none of its parameters is said to be so"));
  effect.needs = kTime;
  EXPECT_THAT(
      laws_.says_what_it_is(effect, place_),
      Contains("it needs the time, but is not said to be in time"));
}

// ---- The catalogue at run time.

/// What an interpreter would hand over: a function that brings data of its own.
struct Wave {
  double waves;
  void operator()(
      std::span<const double> x, const Place& place, const Circumstance&, Scene& scene) const {
    const double q = scene.q[place.joint];
    scene.q[place.joint] += x[0] * std::sin(waves * q) + x[1] * std::cos(waves * q);
  }
};

TEST(AddedEffect, IsInTheCatalogueAsLongAsItLives) {
  const std::size_t before = all_effects().size();
  const auto built_in = all_effects();
  const Wave wave{7.0};
  Effect effect = right();
  effect.before_kinematics = Effect::Hook::of(wave);
  {
    const AddedEffect added(effect);
    EXPECT_EQ(find_effect("joint_fourth_harmonic"), &effect);
    EXPECT_EQ(all_effects().size(), before + 1);
    EXPECT_TRUE(std::ranges::is_sorted(all_effects(), {}, &Effect::cause));
    const EffectLaws laws;
    for (const Place& place : effect.places(laws.rig())) {
      EXPECT_THAT(laws.all(effect, place), IsEmpty());
    }
  }
  EXPECT_EQ(find_effect("joint_fourth_harmonic"), nullptr);
  EXPECT_EQ(all_effects().size(), before);
  EXPECT_EQ(built_in.size(), before);  // what was returned before has not changed
}

TEST(AddedEffect, RefusesATakenNameAndARowThatDoesNothing) {
  Effect effect = right();
  effect.cause = "joint_gain";
  EXPECT_THROW(AddedEffect{effect}, std::invalid_argument);
  effect = right();
  effect.before_kinematics = nullptr;
  EXPECT_THROW(AddedEffect{effect}, std::invalid_argument);
  EXPECT_EQ(find_effect("joint_fourth_harmonic"), nullptr);
}

TEST(EffectWords, SayTheSize) {
  const double nan = std::nan("");
  const auto words = [](const char* cause, std::vector<FoundParameter> found) {
    return size_in_words(*find_effect(cause), found);
  };
  EXPECT_EQ(
      words("joint_backlash", {{"b", 6e-4, 2e-5, "rad"}}),
      "0.0344\u00B0 \u00B1 0.0023\u00B0 (k = 2)");
  EXPECT_EQ(
      words("joint_eccentricity", {{"a", 3e-3, 1e-4, "rad"}, {"b", 4e-3, 1e-4, "rad"}}),
      "amplitude 0.286\u00B0 \u00B1 0.011\u00B0 (k = 2)");
  EXPECT_EQ(
      words("step", {{"shift", -0.02, 1e-3, "mm"}, {"sample", 1071, nan, "1"}}),
      "-0.0200 mm \u00B1 0.0020 mm from sample 1071 on (k = 2)");
  EXPECT_EQ(
      words(
          "dial_cyclic",
          {{"a", 3e-3, 1e-4, "mm"}, {"b", 4e-3, 1e-4, "mm"}, {"period", 5.0, 0.01, "mm"}}),
      "amplitude 0.00500 mm \u00B1 0.00020 mm, period 5 mm (k = 2)");
  EXPECT_EQ(
      words("dial_swap", {{"difference_rms", 3.256, nan, "mm"}}), "they differ by 3.26 mm rms");
  Effect without_words = right();
  without_words.size = {};
  const std::vector<FoundParameter> found{{"a", 1e-3, nan, "rad"}, {"b", 2e-3, nan, "rad"}};
  EXPECT_EQ(size_in_words(without_words, found), "a 0.0573\u00B0, b 0.115\u00B0");
}

TEST(EffectWords, NameThePlace) {
  const auto words = [](const char* cause, const char* place) {
    return in_words_at(*find_effect(cause), place);
  };
  EXPECT_EQ(words("joint_backlash", "joint2"), "backlash of joint 2");
  EXPECT_EQ(words("joint_compliance", "joints"), "compliance of the joints");
  EXPECT_EQ(words("dial_lean", "C"), "lean of dial C");
  EXPECT_EQ(words("dial_swap", "C,D"), "swapped dials C and D");
  EXPECT_EQ(words("step", "base"), "a step of the base");
  EXPECT_EQ(words("step", "E"), "a step of dial E");
  EXPECT_EQ(words("base_drift", "base"), "drift of the base");
}

}  // namespace
}  // namespace sixdial::simulation
