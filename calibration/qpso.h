// Quantum-behaved particle swarm optimisation, equations (23)-(28): a minimiser that needs
// values only. Repeatable bit for bit with any number of threads: random numbers belong to
// (seed, particle, iteration, dimension), and all particles of an iteration see the same swarm.
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <functional>
#include <span>
#include <stop_token>
#include <vector>

namespace sixdial::calibration {

/// Some particles of a swarm: row i is a particle, column j a coordinate.
using SwarmRows = Eigen::Ref<const Eigen::ArrayXXd, 0, Eigen::OuterStride<>>;
/// Fills values(i) for particle i. Called from several threads at once for different particles;
/// the value must depend on the particle's own position only. A value that is not finite counts
/// as infinitely bad.
using SwarmObjective =
    std::function<void(const SwarmRows& particles, Eigen::Ref<Eigen::ArrayXd> values)>;

struct QpsoProgress {
  int iteration = 0;  // 1 .. iterations
  int iterations = 0;
  double best = 0.0;
};

struct QpsoSettings {
  int iterations = 100;
  double alpha_start =
      1.0;  // contraction-expansion factor, linear from first to last iteration
  double alpha_end = 0.5;
  std::uint64_t seed = 1;
  std::uint32_t stream = 0;  // tells searches with the same seed apart
  int threads = 1;
  Eigen::VectorXd lower;  // bounds of each coordinate; empty: none
  Eigen::VectorXd upper;
  bool keep_positions = false;  // fill Qpso::best_positions
};

struct QpsoResult {
  Eigen::VectorXd best;         // m
  double value = 0.0;           // +inf if no particle was ever finite
  std::vector<double> history;  // best value after the start and after each iteration
  std::vector<Eigen::VectorXd> best_positions;  // as history, if asked for
  std::int64_t evaluations = 0;
  std::int64_t not_finite = 0;  // evaluations that counted as infinitely bad
  bool cancelled = false;
};

/// `start`: first positions, N x m. Progress is called after each iteration, on this thread.
[[nodiscard]] QpsoResult minimise_qpso(
    const SwarmObjective& objective, const Eigen::ArrayXXd& start, const QpsoSettings& settings,
    const std::function<void(const QpsoProgress&)>& progress = {}, std::stop_token stop = {});

/// The first iteration (0 = start) from which on the best value stays within `fraction` of the
/// final one.
[[nodiscard]] int settled_after(std::span<const double> history, double fraction = 0.01);

}  // namespace sixdial::calibration
