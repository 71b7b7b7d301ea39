// A slow change that no column shows is not called by the name of one that has a column.
#include <gtest/gtest.h>

#include <cmath>
#include <string>

#include "calibration/random.h"
#include "diagnosis/naming.h"
#include "tests/diagnosis/made_session.h"

namespace sixdial::diagnosis {
namespace {

/// Links that grow with something smooth in time; the temperature that was recorded is of
/// another course.
Session grown_by_something_else(std::uint64_t seed, double size_degC) {
  calibration::RandomSequence random(seed, 4);
  const double phase = random.uniform(0, 6.28);
  const double periods = random.uniform(0.5, 1.6);
  const geometry::Rig rig = geometry::default_rig();
  Recipe recipe{
      .effects = {effect_of(rig, "link_thermal_growth", "links", {2e-5})}, .seed = seed};
  recipe.temperature_degC = [=](double share) {
    return 22.0 + size_degC * std::sin(6.2832 * periods * share + phase);
  };
  Session session = session_of(recipe);
  const double rise_degC = random.uniform(2, 6);
  const double until = random.uniform(0.3, 1.5);
  for (std::size_t t = 0; t < session.trials.size(); ++t) {
    const double share = static_cast<double>(t) / static_cast<double>(session.trials.size());
    session.trials[t].temperature_c = 20.0 + rise_degC * (1 - std::exp(-share / until));
  }
  return session;
}

TEST(SlowChange, ThatNoColumnShowsIsNotCalledThermalGrowth) {
  constexpr int kSessions = 12;
  int unknown = 0;
  std::string wrong;
  for (int i = 0; i < kSessions; ++i) {
    const Session session =
        grown_by_something_else(600 + static_cast<std::uint64_t>(i), 2.0 + 0.5 * i);
    Readings readings(session.model, session.trials);
    const NamedCauses found = name_causes(readings);
    for (const Finding& finding : found.findings) {
      if (finding.certain()) {
        wrong += std::to_string(i) + ": " + finding.hypothesis.name() + " ";
      }
    }
    for (const std::string& each : found.depends_on()) unknown += each == "time";
  }
  EXPECT_EQ(wrong, "");
  EXPECT_GE(unknown, kSessions - 2);
}

TEST(SlowChange, ThatTheColumnShowsKeepsItsName) {
  constexpr int kSessions = 6;
  const geometry::Rig rig = geometry::default_rig();
  int named = 0;
  for (int i = 0; i < kSessions; ++i) {
    const Session session = session_of(
        {.effects = {effect_of(rig, "link_thermal_growth", "links", {4e-5})},
         .seed = 700 + static_cast<std::uint64_t>(i)});
    Readings readings(session.model, session.trials);
    const NamedCauses found = name_causes(readings);
    named += found.findings.size() == 1 && found.findings[0].certain() &&
             found.findings[0].hypothesis.name() == "link_thermal_growth@links";
  }
  EXPECT_GE(named, kSessions - 1);
}

}  // namespace
}  // namespace sixdial::diagnosis
