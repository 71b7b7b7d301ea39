// Functions that minimisers are tried on, all with their least value 0: sphere, Griewank and
// Rastrigin at the origin, Rosenbrock at (1, 1, ...). For the tests and for bench/qpso_study.
#pragma once

#include <Eigen/Core>
#include <array>
#include <cmath>
#include <cstdint>
#include <numbers>

#include "calibration/qpso.h"
#include "calibration/random.h"

namespace sixdial::testing {

using StandardFunction = double (*)(const Eigen::ArrayXd&);

inline double sphere(const Eigen::ArrayXd& x) { return x.square().sum(); }
inline double rosenbrock(const Eigen::ArrayXd& x) {
  double sum = 0.0;
  for (Eigen::Index i = 0; i + 1 < x.size(); ++i) {
    const double bend = x[i + 1] - x[i] * x[i];
    sum += 100 * bend * bend + (1 - x[i]) * (1 - x[i]);
  }
  return sum;
}
inline double rastrigin(const Eigen::ArrayXd& x) {
  return (x.square() - 10 * (2 * std::numbers::pi * x).cos() + 10).sum();
}
inline double griewank(const Eigen::ArrayXd& x) {
  double product = 1.0;
  for (Eigen::Index i = 0; i < x.size(); ++i) {
    product *= std::cos(x[i] / std::sqrt(static_cast<double>(i + 1)));
  }
  return 1 + x.square().sum() / 4000 - product;
}

/// One function with the box its swarm starts in, and what counts as solved.
struct StandardProblem {
  const char* name;
  StandardFunction f;
  double half;    // the start is uniform in [-half, half] of every coordinate
  double solved;  // goals of Trelea, Inf. Process. Lett. 85 (2003), for 30 dimensions
  double solved_well;
};
inline constexpr std::array<StandardProblem, 4> kStandardProblems{{
    {"sphere", sphere, 100, 1e-2, 1e-10},
    {"Rosenbrock", rosenbrock, 30, 100, 10},
    {"Rastrigin", rastrigin, 5.12, 100, 10},
    {"Griewank", griewank, 600, 0.1, 0.02},
}};

inline calibration::QpsoResult minimise(
    const StandardProblem& problem, int dimensions, int particles, int iterations,
    std::uint64_t seed, int threads = 1) {
  calibration::RandomSequence random(seed, 77);
  Eigen::ArrayXXd start(particles, dimensions);
  for (double& x : start.reshaped()) x = random.uniform(-problem.half, problem.half);
  calibration::QpsoSettings settings;
  settings.iterations = iterations;
  settings.seed = seed;
  settings.threads = threads;
  return calibration::minimise_qpso(
      [f = problem.f](
          const calibration::SwarmRows& particle, Eigen::Ref<Eigen::ArrayXd> values) {
        for (Eigen::Index i = 0; i < particle.rows(); ++i) {
          values[i] = f(particle.row(i).transpose());
        }
      },
      start, settings);
}

}  // namespace sixdial::testing
