#include "mock_devices/smooth_field.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "mock_devices/random.h"

namespace sixdial::mock_devices {
namespace {

using Eigen::Vector2d;

constexpr double kTwoPi = 2 * std::numbers::pi;
constexpr double kNodeSpacing_s = 5.0;
constexpr std::size_t kNodes = 3601;

}  // namespace

SmoothField SmoothField::of_wavelength(
    double rms_mm, double wavelength_mm, std::uint64_t seed) {
  SmoothField field;
  field.scale_mm_ = rms_mm * std::sqrt(2.0 / static_cast<double>(kWaves));
  const Random random(seed, Stream::kField, 0);
  for (std::size_t i = 0; i < kWaves; ++i) {
    const double direction = random.uniform(3 * i, 0.0, kTwoPi);
    const double k = kTwoPi / wavelength_mm;
    field.waves_[i] = {
        {k * std::cos(direction), k * std::sin(direction)},
        random.uniform(3 * i + 1, 0.0, kTwoPi),
        random.uniform(3 * i + 2, 0.0, kTwoPi)};
  }
  return field;
}

SmoothField SmoothField::of_length(double rms_mm, double length_mm, std::uint64_t seed) {
  SmoothField field;
  field.scale_mm_ = rms_mm * std::sqrt(2.0 / static_cast<double>(kWaves));
  const Random random(seed, Stream::kField, 1);
  for (std::size_t i = 0; i < kWaves; ++i) {
    field.waves_[i] = {
        {random.normal(4 * i) / length_mm, random.normal(4 * i + 1) / length_mm},
        random.uniform(4 * i + 2, 0.0, kTwoPi),
        random.uniform(4 * i + 3, 0.0, kTwoPi)};
  }
  return field;
}

Vector2d SmoothField::at(const Vector2d& p_mm) const {
  Vector2d sum = Vector2d::Zero();
  for (const Wave& wave : waves_) {
    const double angle = wave.k.dot(p_mm);
    sum += Vector2d(std::cos(angle + wave.phase_x), std::cos(angle + wave.phase_y));
  }
  return scale_mm_ * sum;
}

RandomWalk::RandomWalk(double mm_per_sqrt_h, std::uint64_t seed) : nodes_(kNodes) {
  const double step_mm = mm_per_sqrt_h * std::sqrt(kNodeSpacing_s / 3600.0);
  const Random random(seed, Stream::kWalk);
  nodes_[0] = Vector2d::Zero();
  for (std::size_t i = 1; i < kNodes; ++i) {
    nodes_[i] =
        nodes_[i - 1] + step_mm * Vector2d(random.normal(2 * i), random.normal(2 * i + 1));
  }
}

Vector2d RandomWalk::at(double time_s) const {
  const double place =
      std::clamp(time_s / kNodeSpacing_s, 0.0, static_cast<double>(kNodes - 1));
  const std::size_t before = std::min(static_cast<std::size_t>(place), kNodes - 2);
  const double share = place - static_cast<double>(before);
  return (1.0 - share) * nodes_[before] + share * nodes_[before + 1];
}

}  // namespace sixdial::mock_devices
