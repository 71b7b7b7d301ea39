// Drawn sessions of the mock rig, as dials or another instrument would have measured them, and
// what was told of them: for tests of units, frames, columns and targets.
#pragma once

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <functional>
#include <numbers>
#include <random>
#include <string>
#include <vector>

#include "geometry/registration.h"
#include "session/sample_layout.h"
#include "session/trials.h"
#include "studies/plausibility.h"
#include "tests/support/simulated.h"
#include "tests/support/told.h"

namespace sixdial::studies {

using Eigen::Vector2d;

inline constexpr double kPi = std::numbers::pi;

class Drawn {
 public:
  explicit Drawn(std::uint64_t seed) : engine_(seed) {}
  double within(double low, double high) {
    return std::uniform_real_distribution<double>(low, high)(engine_);
  }
  std::size_t below(std::size_t n) {
    return std::uniform_int_distribution<std::size_t>(0, n - 1)(engine_);
  }

 private:
  std::mt19937_64 engine_;
};

/// A robot around nominal, 60 points of G1 and 30 of G2 read by six dials.
inline session::Session by_dials(
    std::uint64_t seed, const geometry::Rig& rig = geometry::default_rig()) {
  mock_devices::World world;
  world.rig = rig;
  world.robot = mock_devices::drawn_robot(rig, seed);
  world.seed = seed;
  session::Session session = session::parse_session(
      mock_devices::session_csv(
          mock_devices::generate_session(world, mock_devices::random_plan(rig, seed, 60, 30)),
          rig, "2026-03-02T08:30:00.000Z"),
      "session.csv", mock_devices::rig_toml(rig), "rig.toml");
  session.name = "drawn";
  return session;
}

/// The same as an instrument would have measured it: positions alone.
inline session::Session by_positions(std::uint64_t seed) {
  session::Session session = by_dials(seed);
  const std::size_t dials = session.rig.dials.size();
  std::vector<session::Sample> samples;
  for (const simulation::Trial& trial : session::trials_of(session, "")) {
    if (!trial.position_mm) continue;
    session::Sample sample = session.samples[static_cast<std::size_t>(trial.sample)];
    for (std::size_t k = 0; k < dials; ++k) sample.channels[k] = {};
    session::set_position(sample, dials, *trial.position_mm);
    samples.push_back(std::move(sample));
  }
  session.samples = std::move(samples);
  return session;
}

using Change = std::function<Vector2d(const Vector2d&)>;

inline session::Session changed(session::Session session, const Change& change) {
  const std::size_t dials = session.rig.dials.size();
  for (session::Sample& sample : session.samples) {
    const Vector2d at = *session::position_of(sample, dials);
    session::set_position(sample, dials, change(at));
  }
  return session;
}

inline Change rigid(double turn_rad, const Vector2d& shift_mm) {
  const Eigen::Rotation2Dd turn(turn_rad);
  return [turn, shift_mm](const Vector2d& p) -> Vector2d { return turn * p + shift_mm; };
}

inline std::string text_of(const Warning& warning, const std::string& part) {
  return std::get<std::string>(warning.parts.at(part));
}
inline double figure_of(const Warning& warning, const std::string& part) {
  return std::get<double>(warning.parts.at(part));
}

inline std::string codes_text(const std::vector<Warning>& warnings) {
  std::string codes;
  for (const Warning& each : warnings) codes += each.code + " ";
  return codes;
}

/// Median distance between the measured positions of two sessions.
inline double apart_mm(const session::Session& a, const session::Session& b) {
  std::vector<double> apart;
  for (std::size_t i = 0; i < a.samples.size(); ++i) {
    apart.push_back((*session::position_of(a.samples[i], a.rig.dials.size()) -
                     *session::position_of(b.samples[i], b.rig.dials.size()))
                        .norm());
  }
  return geometry::median_of(apart);
}

}  // namespace sixdial::studies
