// Each effect that diagnosis knows has a twin that can be hidden in the true rig, at the same
// places. This test may look at both sides; mock_devices itself includes nothing of simulation.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>
#include <set>
#include <string>
#include <vector>

#include "mock_devices/arm_world.h"
#include "mock_devices/delta_world.h"
#include "mock_devices/hidden_effect.h"
#include "session/rig_file.h"
#include "simulation/effect.h"

namespace sixdial::mock_devices {
namespace {

using simulation::Effect;

std::set<std::string> names_of(const std::vector<simulation::Place>& places) {
  std::set<std::string> names;
  for (const simulation::Place& place : places) names.insert(place.name);
  return names;
}

/// What only a robot in space can have is hidden in an arm.
void expect_twin_at_an_arm(const Effect& effect) {
  constexpr int kJoints = 5;
  const ArmWorld world = drawn_arm(1, kJoints);
  const std::filesystem::path folder =
      std::filesystem::path(testing::TempDir()) / ("twin_" + std::string(effect.cause));
  write_arm_bundle(folder, {}, world);
  const geometry::Rig rig = session::read_rig_file((folder / "rig.toml").string());
  const std::vector<std::string> hidden_at = places_at_arm(world, effect.twin);
  EXPECT_NE(std::ranges::find(arm_causes(), effect.twin, &ArmCause::id), arm_causes().end());
  EXPECT_EQ(
      names_of(effect.places(rig)),
      (std::set<std::string>(hidden_at.begin(), hidden_at.end())));
}

class EveryTwin : public testing::TestWithParam<const Effect*> {};

TEST_P(EveryTwin, CanBeHiddenWhereverTheEffectIsLookedFor) {
  const Effect& effect = *GetParam();
  const geometry::Rig rig = geometry::default_rig();
  if (effect.places(rig).empty()) {
    expect_twin_at_an_arm(effect);
    return;
  }
  const CauseRow& twin = cause_row(effect.twin);
  // A curve is found as something smooth, and so counts with what has no name.
  EXPECT_EQ(twin.in_catalogue, !effect.is_curve);
  EXPECT_EQ(twin.swaps_cables, effect.exchanges_dials);
  const auto hidden_at = twin.places(rig);
  EXPECT_EQ(
      names_of(effect.places(rig)),
      (std::set<std::string>(hidden_at.begin(), hidden_at.end())));
}

INSTANTIATE_TEST_SUITE_P(
    , EveryTwin,
    testing::ValuesIn(simulation::all_effects().begin(), simulation::all_effects().end()),
    [](const auto& each) { return std::string(each.param->cause); });

TEST(Twins, AreAllLookedForOrOutsideOfTheCatalogue) {
  std::set<std::string_view> known, of_curves;
  for (const Effect* effect : simulation::all_effects()) {
    EXPECT_TRUE(known.insert(effect->twin).second) << effect->twin << " is a twin of two";
    if (effect->is_curve) of_curves.insert(effect->twin);
  }
  for (const CauseRow* row : causes()) {
    const bool is_twin = known.contains(row->id);
    if (of_curves.contains(row->id)) {  // found as something smooth
      EXPECT_FALSE(row->in_catalogue) << row->id;
      EXPECT_NE(row->covariate, nullptr) << row->id;
      continue;
    }
    EXPECT_EQ(is_twin, row->in_catalogue && !row->is_data_fault) << row->id;
    EXPECT_EQ(row->covariate != nullptr, !row->in_catalogue) << row->id;
  }
}

TEST(Twins, OfArmsAreAllLookedFor) {
  for (const ArmCause& cause : arm_causes()) {
    const std::string_view name = cause.id;
    EXPECT_NE(simulation::find_effect(name), nullptr) << name;
  }
}

/// A delta of each kind under each instrument.
std::vector<DeltaWorld> deltas() {
  std::vector<DeltaWorld> found;
  for (const bool arms : {false, true}) {
    for (const bool wires : {false, true}) {
      std::uint64_t seed = 1;
      while (drawn_delta(seed).has_arms != arms ||
             drawn_delta(seed).anchors_mm.empty() == wires) {
        ++seed;
      }
      found.push_back(drawn_delta(seed));
    }
  }
  return found;
}

TEST(Twins, OfDeltasAreHiddenWhereverTheEffectIsLookedFor) {
  for (const DeltaWorld& world : deltas()) {
    const std::filesystem::path folder =
        std::filesystem::path(testing::TempDir()) / fmt::format("twin_delta_{}", world.seed);
    write_delta_bundle(folder, {}, world);
    const geometry::Rig rig = session::read_rig_file((folder / "rig.toml").string());
    int compared = 0;
    for (const DeltaCause& cause : delta_causes()) {
      const Effect* effect = simulation::find_effect(cause.id);
      ASSERT_NE(effect, nullptr) << cause.id;
      const std::vector<std::string> hidden_at = places_at_delta(world, cause.id);
      if (hidden_at.empty()) continue;  // an axis of wires, a turn of a carriage
      EXPECT_EQ(
          names_of(effect->places(rig)),
          (std::set<std::string>(hidden_at.begin(), hidden_at.end())))
          << cause.id;
      ++compared;
    }
    EXPECT_GE(compared, 8);
  }
}

}  // namespace
}  // namespace sixdial::mock_devices
