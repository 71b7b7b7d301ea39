// A rig file that is wrong by millimetres: a dial, the cuboid or its mounting are not where the
// file says. Which dial, which way and which robot are drawn. The diagnosis finds it for what
// it is; single gross readings it is not.
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <iterator>
#include <random>
#include <string>

#include "diagnosis/gross_readings.h"
#include "diagnosis/naming.h"
#include "diagnosis/scatter.h"
#include "mock_devices/session_generator.h"
#include "tests/blind/challenge.h"

namespace sixdial::blind {
namespace {

constexpr double kWrong_mm = 5.0;
constexpr double kNoise_mm = 0.002;
/// With a cuboid of another size a tip or two meets the end of its face.
constexpr double kMostGross = 0.01;
constexpr std::array kDials{"A", "B", "C", "D", "E", "F"};

/// A kind of wrong figure in the rig file; `at_a_dial`: of any dial.
struct Wrong {
  const char* cause;  // under the name that the generator gives it
  bool at_a_dial;
};

mock_devices::World drawn_world(std::uint64_t seed) {
  mock_devices::World world;
  for (geometry::Dial& dial : world.rig.dials) dial.repeatability_mm = kNoise_mm;
  world.robot = mock_devices::drawn_robot(world.rig, seed);
  world.seed = seed;
  world.dials = {kNoise_mm, 0.001, 0.0, 0.0};
  return world;
}

class WrongRigFile : public testing::TestWithParam<Wrong> {};

TEST_P(WrongRigFile, IsNamedAndNoReadingIsGross) {
  const Wrong& wrong = GetParam();
  for (std::uint64_t seed = 310; seed < 314; ++seed) {
    std::mt19937_64 engine(seed);
    const std::size_t dial = engine() % kDials.size();
    const double size_mm = engine() % 2 == 0 ? kWrong_mm : -kWrong_mm;
    mock_devices::World world = drawn_world(seed);
    const std::string where = wrong.at_a_dial ? kDials[dial] : "cuboid";
    world.effects = {mock_devices::make_effect(world.rig, wrong.cause, where, size_mm, seed)};
    const std::string truth = std::string(wrong.cause) + "@" + where;
    SCOPED_TRACE(truth + " seed " + std::to_string(seed));
    const auto session = mock_devices::generate_session(
        world, mock_devices::random_plan(world.rig, seed, 66, 34));
    const simulation::ForwardModel model(world.rig);
    diagnosis::Readings readings(model, trials_of(world.rig, session));
    const diagnosis::NamedCauses verdict = diagnosis::name_causes(readings);
    EXPECT_LE(std::ssize(verdict.gross), kMostGross * static_cast<double>(readings.count()));
    const std::vector<bool> as_a_whole = diagnosis::wrong_dials(readings, verdict.extended);
    EXPECT_EQ(std::ranges::count(as_a_whole, true), 0);
    bool in_set = false;
    for (const diagnosis::Finding& finding : verdict.findings) {
      bool own = finding.hypothesis.name() == truth;
      for (const diagnosis::Rival& rival : finding.tied_with) {
        own = own || rival.hypothesis.name() == truth;
      }
      in_set = in_set || own;
      EXPECT_TRUE(own || !finding.certain()) << finding.hypothesis.name();
    }
    EXPECT_TRUE(in_set);
  }
}

INSTANTIATE_TEST_SUITE_P(
    , WrongRigFile,
    testing::Values(
        Wrong{"dial_mount", true}, Wrong{"cuboid_size", false}, Wrong{"cuboid_offset", false}),
    [](const auto& each) { return std::string(each.param.cause); });

// Whatever such a dial reads, it has nothing to do with the cuboid.
TEST(WrongDial, IsSaidToBeWrongAsAWholeAndItsReadingsAreNotGrossOneByOne) {
  for (std::uint64_t seed = 320; seed < 323; ++seed) {
    std::mt19937_64 engine(seed);
    const std::size_t dial = engine() % kDials.size();
    SCOPED_TRACE(std::string("dial ") + kDials[dial]);
    const mock_devices::World world = drawn_world(seed);
    auto session = mock_devices::generate_session(
        world, mock_devices::random_plan(world.rig, seed, 66, 34));
    std::uniform_real_distribution<double> anywhere_mm(2.0, 22.0);
    for (auto& row : session.rows) row.dial_mm[dial] = anywhere_mm(engine);
    const simulation::ForwardModel model(world.rig);
    diagnosis::Readings readings(model, trials_of(world.rig, session));
    const diagnosis::NamedCauses verdict = diagnosis::name_causes(readings);
    const auto of_dial = [&](const diagnosis::GrossReading& gross) {
      return readings.rows()[static_cast<std::size_t>(gross.row)].dial ==
             static_cast<int>(dial);
    };
    EXPECT_EQ(std::ranges::count_if(verdict.gross, of_dial), 0);
    const auto noise = diagnosis::noise_of(readings, verdict.extended);
    const auto scatter = diagnosis::scatter_of(readings, verdict.extended, noise);
    EXPECT_TRUE(std::ranges::any_of(scatter.dials, [&](const diagnosis::NoisyDial& each) {
      return each.dial == kDials[dial];
    }));
    for (const diagnosis::Finding& finding : verdict.findings) {
      EXPECT_FALSE(finding.certain() && finding.hypothesis.place.dial != static_cast<int>(dial))
          << finding.hypothesis.name();
    }
  }
}

}  // namespace
}  // namespace sixdial::blind
