// The mock's deltas: their own kinematics, held against geometry's, and what can be hidden in
// them.
#include "mock_devices/delta_world.h"

#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>
#include <fstream>
#include <sstream>

#include "geometry/robot_kind.h"

namespace sixdial::mock_devices {
namespace {

using Eigen::Vector3d;
using Eigen::VectorXd;

constexpr double kSame_mm = 1e-9;  // two ways to the same point, some 500 mm long

/// As geometry's kinds list them: base (6), radius, angles, arms, rods, zeros.
VectorXd parameters_of(const DeltaWorld& world) {
  const DeltaSizes& is = world.actual;
  VectorXd v = VectorXd::Zero(world.has_arms ? 19 : 16);
  v.head<3>() = world.base_mm;
  v.segment<3>(3) = world.base_turn_rad;
  v[6] = is.radius_mm;
  for (Eigen::Index i = 0; i < 3; ++i) {
    const auto k = static_cast<std::size_t>(i);
    v[7 + i] = is.angle_rad[k];
    if (world.has_arms) v[10 + i] = is.arm_mm[k];
    v[(world.has_arms ? 13 : 10) + i] = is.rod_mm[k];
    v[(world.has_arms ? 16 : 13) + i] = is.zero[k];
  }
  return v;
}

TEST(DeltaWorld, ItsPlatformIsWhereGeometryHasIt) {
  int towers = 0, arms = 0, wires = 0;
  for (std::uint64_t seed = 1; seed <= 40; ++seed) {
    DeltaWorld world = drawn_delta(seed);
    (world.has_arms ? arms : towers) += 1;
    wires += world.anchors_mm.empty() ? 0 : 1;
    world.noise_mm = 0.0;
    const auto robot =
        geometry::find_robot_kind(world.has_arms ? "rotary_delta" : "linear_delta")->example();
    std::vector<geometry::Pose<double>> X(robot->frames.size());
    for (const DeltaRow& row : measure_delta(world, 15, 5)) {
      ASSERT_TRUE(robot->forward(parameters_of(world), row.q, geometry::Assembly::kLeft, X));
      for (Eigen::Index k = 0; k < row.reading.size(); ++k) {
        const double seen =
            world.anchors_mm.empty()
                ? X[0].p[k]
                : (X[0].p - world.anchors_mm[static_cast<std::size_t>(k)]).norm();
        EXPECT_LT(std::abs(row.reading[k] - seen), kSame_mm) << "seed " << seed;
      }
    }
  }
  EXPECT_GE(towers, 10);
  EXPECT_GE(arms, 10);
  EXPECT_GE(wires, 5);
}

TEST(DeltaWorld, RodsThatCannotMeetBelowAreNoPose) {
  DeltaSizes sizes{.radius_mm = 150.0, .rod_mm = {100.0, 100.0, 100.0}};
  for (std::size_t i = 0; i < 3; ++i) sizes.angle_rad.at(i) = 2.1 * static_cast<double>(i);
  EXPECT_FALSE(platform_of(sizes, false, Vector3d(300, 300, 300)));
}

TEST(DeltaWorld, EveryCauseDoesNothingAtZeroAndSomethingElsewhere) {
  int tried = 0;
  for (std::uint64_t seed = 1; seed <= 12; ++seed) {
    const DeltaWorld clean = drawn_delta(seed);
    const auto without = measure_delta(clean, 40, 0);
    for (const DeltaCause& cause : delta_causes()) {
      for (const std::string& where : places_at_delta(clean, cause.id)) {
        const double most = clean.has_arms ? cause.most_rad : cause.most_mm;
        for (const double amplitude : {0.0, most}) {
          DeltaWorld world = clean;
          world.effects = {make_delta_effect(clean, cause.id, where, amplitude)};
          const auto with = measure_delta(world, 40, 0);
          double moved = 0.0;
          for (std::size_t i = 0; i < with.size(); ++i) {
            moved =
                std::max(moved, (with[i].reading - without[i].reading).cwiseAbs().maxCoeff());
            EXPECT_EQ(with[i].q, without[i].q);  // an encoder knows nothing of it
          }
          EXPECT_EQ(moved > 1e-9, amplitude > 0.0) << cause.id << " at " << where;
          ++tried;
        }
      }
    }
  }
  EXPECT_GT(tried, 300);
}

TEST(DeltaWorld, LinksThatGrowMakeTheWholeDeltaLarger) {
  for (std::uint64_t seed = 1; seed <= 10; ++seed) {
    DeltaWorld world = drawn_delta(seed);
    world.noise_mm = 0.0;
    world.anchors_mm.clear();
    const auto cold = measure_delta(world, 30, 0);
    constexpr double kPerK = 5e-5;
    world.effects = {make_delta_effect(world, "link_thermal_growth", "links", kPerK)};
    const auto warm = measure_delta(world, 30, 0);
    for (std::size_t i = 0; i < warm.size(); ++i) {
      const double growth = 1.0 + kPerK * (warm[i].temperature_c - 20.0);
      const Vector3d expected =
          world.base_mm + growth * (Vector3d(cold[i].reading) - world.base_mm);
      EXPECT_LT((Vector3d(warm[i].reading) - expected).norm(), 1e-8);
    }
  }
}

TEST(DeltaWorld, UnknownCausesAndPlacesAreRefused) {
  const DeltaWorld world = drawn_delta(1);
  EXPECT_THROW(
      static_cast<void>(make_delta_effect(world, "joint_gain", "joint4", 1e-3)),
      std::invalid_argument);
  EXPECT_THROW(
      static_cast<void>(make_delta_effect(world, "no_such_cause", "joint1", 1e-3)),
      std::invalid_argument);
  DeltaWorld towers = world;
  towers.has_arms = false;
  EXPECT_TRUE(places_at_delta(towers, "joint_eccentricity").empty());
}

TEST(DeltaWorld, TheSameSeedMakesTheSameFiles) {
  const auto text_of = [](const std::string& name) {
    const auto folder = std::filesystem::path(testing::TempDir()) / name;
    const DeltaWorld world = drawn_delta(9);
    write_delta_bundle(folder, measure_delta(world, 10, 5), world);
    std::ostringstream all;
    for (const char* const file : {"rig.toml", "session.csv"}) {
      all << std::ifstream(folder / file).rdbuf();
    }
    std::filesystem::remove_all(folder);
    return all.str();
  };
  const std::string first = text_of("delta_once");
  EXPECT_GT(first.size(), 1000U);
  EXPECT_EQ(first, text_of("delta_again"));
}

}  // namespace
}  // namespace sixdial::mock_devices
