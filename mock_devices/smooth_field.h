// Smooth random errors: a vector field over the table, and a walk in time. Both are fixed by a
// seed and can be asked in any order.
#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <vector>

namespace sixdial::mock_devices {

/// Sum of plane waves with random directions and phases; each coordinate has the given rms.
class SmoothField {
 public:
  /// Waves of one length.
  static SmoothField of_wavelength(double rms_mm, double wavelength_mm, std::uint64_t seed);
  /// Squared-exponential correlation exp(-r^2 / (2 length^2)).
  static SmoothField of_length(double rms_mm, double length_mm, std::uint64_t seed);
  [[nodiscard]] Eigen::Vector2d at(const Eigen::Vector2d& p_mm) const;

 private:
  static constexpr std::size_t kWaves = 24;
  struct Wave {
    Eigen::Vector2d k;
    double phase_x, phase_y;
  };
  double scale_mm_ = 0.0;
  std::array<Wave, kWaves> waves_{};
};

/// Two independent random walks, standard deviation mm_per_sqrt_h sqrt(t); nodes 5 s apart and
/// straight between them; constant after five hours.
class RandomWalk {
 public:
  RandomWalk(double mm_per_sqrt_h, std::uint64_t seed);
  [[nodiscard]] Eigen::Vector2d at(double time_s) const;

 private:
  std::vector<Eigen::Vector2d> nodes_;
};

}  // namespace sixdial::mock_devices
