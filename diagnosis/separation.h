// Which poses to measure next so that two tied causes come apart, or a hidden one shows
// (Atkinson and Fedorov's T-optimality, greedily): those that leave most of cause A's signal
// when robot, clamp, the other causes and cause B are fitted to it.
//
//   lambda = min |A's signal - (J p + B b)|^2 / s^2 over p, b; log odds expected = lambda / 2
#pragma once

#include <array>
#include <optional>
#include <span>
#include <vector>

#include "diagnosis/naming.h"

namespace sixdial::diagnosis {

/// A pose that could be measured.
struct PosePoint {
  Eigen::Vector2d q_rad{0, 0};
  Eigen::Vector2d target_mm{0, 0};
  geometry::Assembly assembly = geometry::Assembly::kLeft;
  std::array<int, 2> approach{0, 0};
};

struct Separation {
  std::vector<std::size_t> chosen;  // indices of candidates, in the order chosen
  std::vector<double> log_odds;     // expected with each of them and all before
  double log_odds_now = 0.0;        // expected of the session as it is
};

/// `fit` explains the session and has the cause as its effect number `cause`. `rival`: the
/// effect it is tied with; empty: the cause against none. Poses that the robot or the dials
/// cannot take are left out. Each candidate is taken once.
[[nodiscard]] Separation separating_poses(
    const Readings& readings, const JointFit& fit, std::size_t cause,
    const std::optional<simulation::ActiveEffect>& rival, std::span<const PosePoint> candidates,
    int count);

}  // namespace sixdial::diagnosis
