// Each effect that diagnosis knows has a twin that can be hidden in the true rig, at the same
// places. This test may look at both sides; mock_devices itself includes nothing of simulation.
#include <gtest/gtest.h>

#include <set>
#include <string>

#include "mock_devices/hidden_effect.h"
#include "simulation/effect.h"

namespace sixdial::mock_devices {
namespace {

using simulation::Effect;

class EveryTwin : public testing::TestWithParam<const Effect*> {};

TEST_P(EveryTwin, CanBeHiddenWhereverTheEffectIsLookedFor) {
  const Effect& effect = *GetParam();
  const geometry::Rig rig = geometry::default_rig();
  const CauseRow& twin = cause_row(effect.twin);
  EXPECT_TRUE(twin.in_catalogue);
  EXPECT_EQ(twin.swaps_cables, effect.exchanges_dials);
  std::set<std::string> looked_for;
  for (const simulation::Place& place : effect.places(rig)) looked_for.insert(place.name);
  const auto hidden_at = twin.places(rig);
  EXPECT_EQ(looked_for, (std::set<std::string>(hidden_at.begin(), hidden_at.end())));
}

INSTANTIATE_TEST_SUITE_P(
    , EveryTwin,
    testing::ValuesIn(simulation::all_effects().begin(), simulation::all_effects().end()),
    [](const auto& each) { return std::string(each.param->cause); });

TEST(Twins, AreAllLookedForOrOutsideOfTheCatalogue) {
  std::set<std::string_view> known;
  for (const Effect* effect : simulation::all_effects()) {
    EXPECT_TRUE(known.insert(effect->twin).second) << effect->twin << " is a twin of two";
  }
  for (const CauseRow* row : causes()) {
    EXPECT_EQ(known.contains(row->id), row->in_catalogue && !row->is_data_fault) << row->id;
    EXPECT_EQ(row->covariate != nullptr, !row->in_catalogue) << row->id;
  }
}

}  // namespace
}  // namespace sixdial::mock_devices
