// The measured positions that the stages are timed on: Table 2's robot, targets in a square of
// 40 mm, smooth non-kinematic error of about 0.03 mm, noise 0.003 mm.
#pragma once

#include <cmath>
#include <cstdint>
#include <vector>

#include "calibration/random.h"
#include "geometry/rig.h"
#include "simulation/trial.h"

namespace sixdial::bench {

/// Non-kinematic error: gear eccentricity (first and eighth harmonic) and compliance under a
/// side load.
inline std::vector<simulation::Trial> simulated(int count, std::uint64_t seed) {
  using Eigen::Vector2d;
  constexpr double kScale = 1.45;
  const geometry::Rig rig = geometry::default_rig();
  const geometry::ParameterVector robot = geometry::table_2_robot();
  calibration::RandomSequence random(seed);
  std::vector<simulation::Trial> trials;
  while (static_cast<int>(trials.size()) < count) {
    simulation::Trial trial;
    trial.point = trial.sample = static_cast<int>(trials.size());
    const Vector2d target(random.uniform(0, 40), random.uniform(16, 56));
    const auto q = geometry::inverse(rig.robot.nominal, target, {+1, +1});
    if (!q) continue;
    trial.q = *q;
    trial.target_mm = target;
    trial.assembly = geometry::assembly_at(rig.robot.nominal, *q, target).value();
    const Vector2d phase1(0.3, 1.1);
    const Vector2d phase8(0.7, 2.0);
    Vector2d bent = *q;
    for (int i = 0; i < 2; ++i) {
      bent[i] += kScale * (2.0e-4 * std::sin((*q)[i] + phase1[i]) +
                           3.6e-4 * std::sin(8 * (*q)[i] + phase8[i]));
    }
    const auto pose = geometry::forward(robot, bent, trial.assembly);
    const auto unbent = geometry::forward_derivative(robot, *q, trial.assembly);
    if (!pose || !unbent) continue;
    const Vector2d give =
        kScale * 1.0e-6 * unbent->J_q * (unbent->J_q.transpose() * Vector2d(0.8, -1.2));
    trial.position_mm = pose->p_WE + give + 0.003 * Vector2d(random.normal(), random.normal());
    trials.push_back(trial);
  }
  return trials;
}

}  // namespace sixdial::bench
