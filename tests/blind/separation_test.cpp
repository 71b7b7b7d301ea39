// Two causes that a session cannot tell apart come apart after the proposed poses were
// measured.
#include "diagnosis/separation.h"

#include <gtest/gtest.h>

#include <string>
#include <vector>

#include "diagnosis/naming.h"
#include "mock_devices/session_generator.h"
#include "tests/blind/challenge.h"

namespace sixdial::blind {
namespace {

using diagnosis::Finding;
using mock_devices::PlannedPose;

constexpr double kNoise_mm = 0.002;

/// A world with one hidden effect and dials that are noisy and nothing else.
mock_devices::World world_with(const mock_devices::HiddenEffect& effect, std::uint64_t seed) {
  mock_devices::World world;
  world.robot = mock_devices::drawn_robot(world.rig, seed);
  world.dials = {kNoise_mm, 0.001, 0.0, 0.0};
  world.seed = seed;
  world.effects = {effect};
  return world;
}

/// Everything that the nominal robot reaches in and around the default rectangle, in each
/// working mode, with angles continuous around the reference pose.
std::vector<diagnosis::PosePoint> candidates_on(const geometry::Rig& rig) {
  std::vector<diagnosis::PosePoint> result;
  for (const geometry::WorkingMode mode : geometry::kWorkingModes) {
    const auto near = geometry::inverse(rig.robot.nominal, rig.cuboid.reference_pose_mm, mode);
    if (!near) continue;
    for (double x = 14; x <= 42; x += 4) {
      for (double y = 28; y <= 68; y += 4) {
        const Eigen::Vector2d target(x, y);
        const auto q = geometry::inverse(rig.robot.nominal, target, mode, *near);
        if (!q) continue;
        const auto assembly = geometry::assembly_at(rig.robot.nominal, *q, target);
        if (!assembly) continue;
        result.push_back({*q, target, *assembly, {0, 0}});
      }
    }
  }
  return result;
}

struct Verdict {
  diagnosis::NamedCauses named;
  const Finding* of(const std::string& truth) const {
    for (const Finding& each : named.findings) {
      if (each.hypothesis.name() == truth) return &each;
      for (const auto& rival : each.tied_with) {
        if (rival.hypothesis.name() == truth) return &each;
      }
    }
    return nullptr;
  }
};

TEST(TiedCauses, ComeApartByTheProposedPoses) {
  const geometry::Rig rig = geometry::default_rig();
  const simulation::ForwardModel model(rig);
  constexpr int kProposed = 24;
  int ties = 0;
  int resolved = 0;
  std::string told;
  for (std::uint64_t seed = 400; seed < 460 && ties < 6; ++seed) {
    for (const char* cause : {"joint_second_harmonic", "joint_eccentricity"}) {
      const auto effect = mock_devices::draw_effect_of(rig, cause, seed);
      const std::string truth = std::string(cause) + "@" + effect.where;
      const mock_devices::World world = world_with(effect, seed);
      std::vector<PlannedPose> plan = mock_devices::random_plan(rig, seed);
      const auto before = trials_of(rig, mock_devices::generate_session(world, plan));
      diagnosis::Readings readings(model, before);
      const Verdict first{diagnosis::name_causes(readings)};
      const Finding* tied = first.of(truth);
      if (!tied || tied->tied_with.empty() || first.named.findings.size() != 1) continue;
      ++ties;
      const auto candidates = candidates_on(rig);
      const auto proposal = diagnosis::separating_poses(
          readings, first.named.extended, 0, tied->tied_with.front().fitted, candidates,
          kProposed);
      ASSERT_EQ(proposal.chosen.size(), static_cast<std::size_t>(kProposed));
      EXPECT_GT(proposal.log_odds.back(), proposal.log_odds_now);
      for (const std::size_t i : proposal.chosen) {
        PlannedPose pose;
        pose.point = static_cast<int>(plan.size());
        pose.time_s = plan.back().time_s + 8;
        pose.q_rad = candidates[i].q_rad;
        pose.target_mm = candidates[i].target_mm;
        pose.assembly = candidates[i].assembly;
        plan.push_back(pose);
      }
      diagnosis::Readings more(
          model, trials_of(rig, mock_devices::generate_session(world, plan)));
      const Verdict second{diagnosis::name_causes(more)};
      bool certain = false;
      for (const Finding& each : second.named.findings) {
        certain = certain || (each.hypothesis.name() == truth && each.certain());
      }
      resolved += certain;
      told += "seed " + std::to_string(seed) + " " + truth +
              (certain ? " resolved\n" : " not resolved\n");
    }
  }
  EXPECT_GE(ties, 6) << "ties were tried";
  EXPECT_GE(resolved, ties - 1) << told;
}

}  // namespace
}  // namespace sixdial::blind
