// Sessions that the project's own simulation makes, for tests of the diagnosis.
#pragma once

#include <cstdint>
#include <functional>
#include <vector>

#include "simulation/extended_model.h"

namespace sixdial::diagnosis {

inline constexpr double kNoise_mm = 0.002;

/// A session as the extended simulation shows it, with normal noise.
struct Session {
  simulation::ForwardModel model;
  simulation::ModelVector truth;
  std::vector<simulation::Trial> trials;
  std::vector<bool> held_out;
};

struct Recipe {
  std::vector<simulation::ActiveEffect> effects{};
  double noise_mm = kNoise_mm;
  int points = 150;
  int repeats = 1;
  std::uint64_t seed = 1;
  geometry::Mount mount = geometry::Mount::kDistal2;
  double dial_E_x_mm = 16.0;
  // What differs from one arrival to the next: of the tool in x and in y; of the joints against
  // what was recorded.
  double scatter_mm = 0.0;
  double scatter_rad = 0.0;
  /// By the share of the session that is over; empty: a warm-up with waves.
  std::function<double(double)> temperature_degC{};
};

[[nodiscard]] Session session_of(const Recipe& recipe);

[[nodiscard]] simulation::ActiveEffect effect_of(
    const geometry::Rig& rig, const char* cause, const char* where, std::vector<double> x);

}  // namespace sixdial::diagnosis
