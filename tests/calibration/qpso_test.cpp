// The swarm: standard functions, repeatability, bad particles, cancelling.
#include "calibration/qpso.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstdio>
#include <limits>
#include <stdexcept>

#include "calibration/random.h"
#include "tests/support/standard_functions.h"

namespace sixdial::calibration {
namespace {

using sixdial::testing::griewank;
using sixdial::testing::rastrigin;
using sixdial::testing::sphere;
using sixdial::testing::StandardFunction;

SwarmObjective objective_of(StandardFunction f) {
  return [f](const SwarmRows& particles, Eigen::Ref<Eigen::ArrayXd> values) {
    for (Eigen::Index i = 0; i < particles.rows(); ++i) {
      values[i] = f(particles.row(i).transpose());
    }
  };
}

Eigen::ArrayXXd box_start(int particles, int dimensions, double half, std::uint64_t seed) {
  RandomSequence random(seed, 77);
  Eigen::ArrayXXd start(particles, dimensions);
  for (double& x : start.reshaped()) x = random.uniform(-half, half);
  return start;
}

// Required of the quick runs below; bench/qpso_study has the whole table.
struct Rate {
  double goal;
  int of_50;
};
constexpr Rate kIn10Dimensions[] = {{1e-8, 50}, {10.0, 40}, {10.0, 45}, {0.15, 38}};

TEST(Qpso, SolvesTheStandardFunctionsFrom50Seeds) {
  std::size_t k = 0;
  for (const auto& problem : sixdial::testing::kStandardProblems) {
    const Rate& required = kIn10Dimensions[k++];
    int solved = 0;
    for (std::uint64_t seed = 1; seed <= 50; ++seed) {
      const auto result = sixdial::testing::minimise(problem, 10, 40, 600, seed);
      solved += result.value <= required.goal ? 1 : 0;
      EXPECT_DOUBLE_EQ(result.value, problem.f(result.best.array()));
    }
    std::printf(
        "QPSO %-10s 10 dimensions: %d of 50 below %g\n", problem.name, solved, required.goal);
    EXPECT_GE(solved, required.of_50) << problem.name;
  }
  EXPECT_EQ(k, std::size(kIn10Dimensions));
}

TEST(Qpso, ReachesTheUsualGoalsIn30Dimensions) {
  for (const auto& problem : sixdial::testing::kStandardProblems) {
    int solved = 0;
    for (std::uint64_t seed = 1; seed <= 5; ++seed) {
      solved += sixdial::testing::minimise(problem, 30, 80, 2000, seed).value <= problem.solved
                    ? 1
                    : 0;
    }
    std::printf(
        "QPSO %-10s 30 dimensions: %d of 5 below %g\n", problem.name, solved, problem.solved);
    // 41 of 50 solve Rosenbrock's, all the others.
    EXPECT_GE(solved, problem.f == sixdial::testing::rosenbrock ? 2 : 5) << problem.name;
  }
}

TEST(StandardFunctions, AreLeastWhereTheyShouldBe) {
  for (const auto& problem : sixdial::testing::kStandardProblems) {
    const double at = problem.f == sixdial::testing::rosenbrock ? 1.0 : 0.0;
    const Eigen::ArrayXd best = Eigen::ArrayXd::Constant(7, at);
    EXPECT_LT(std::abs(problem.f(best)), 1e-13) << problem.name;
    for (const double step : {-0.01, 0.01}) {
      for (Eigen::Index i = 0; i < 7; ++i) {
        Eigen::ArrayXd x = best;
        x[i] += step;
        EXPECT_GT(problem.f(x), 1e-6) << problem.name;
      }
    }
  }
}

TEST(Qpso, IsTheSameBitForBitWithAnyNumberOfThreads) {
  QpsoSettings settings;
  settings.iterations = 60;
  settings.keep_positions = true;
  const auto start = box_start(50, 12, 5.0, 3);
  const auto one = minimise_qpso(objective_of(rastrigin), start, settings);
  for (const int threads : {2, 3, 7}) {
    settings.threads = threads;
    const auto many = minimise_qpso(objective_of(rastrigin), start, settings);
    EXPECT_EQ(one.history, many.history);
    EXPECT_EQ(one.best, many.best);
    EXPECT_EQ(one.best_positions, many.best_positions);
  }
  settings.threads = 1;
  settings.seed = 2;
  EXPECT_NE(one.history, minimise_qpso(objective_of(rastrigin), start, settings).history);
}

TEST(Qpso, HistoryNeverRisesAndEndsAtTheValue) {
  QpsoSettings settings;
  settings.iterations = 80;
  const auto result =
      minimise_qpso(objective_of(griewank), box_start(20, 6, 50.0, 4), settings);
  ASSERT_EQ(result.history.size(), 81U);
  for (std::size_t t = 1; t < result.history.size(); ++t) {
    EXPECT_LE(result.history[t], result.history[t - 1]);
  }
  EXPECT_EQ(result.history.back(), result.value);
  EXPECT_EQ(result.evaluations, 20 * 81);
}

TEST(Qpso, ParticlesThatAreNotFiniteAreInfinitelyBadNotZero) {
  const SwarmObjective half_broken = [](const SwarmRows& particles,
                                        Eigen::Ref<Eigen::ArrayXd> values) {
    for (Eigen::Index i = 0; i < particles.rows(); ++i) {
      const double x = particles(i, 0);
      values[i] = x < 0 ? std::nan("") : 1.0 + x * x;
      if (x < -5) values[i] = -std::numeric_limits<double>::infinity();
    }
  };
  QpsoSettings settings;
  settings.iterations = 100;
  const auto result = minimise_qpso(half_broken, box_start(30, 2, 10.0, 5), settings);
  EXPECT_GE(result.best[0], 0.0);
  EXPECT_GE(result.value, 1.0);
  EXPECT_GT(result.not_finite, 0);
  const SwarmObjective broken = [](const SwarmRows&, Eigen::Ref<Eigen::ArrayXd> values) {
    values.setConstant(std::nan(""));
  };
  EXPECT_TRUE(std::isinf(minimise_qpso(broken, box_start(30, 2, 10.0, 5), settings).value));
}

TEST(Qpso, StaysInsideItsBounds) {
  QpsoSettings settings;
  settings.iterations = 50;
  settings.lower = Eigen::Vector2d(2.0, -1.0);
  settings.upper = Eigen::Vector2d(3.0, -0.5);
  bool inside = true;
  const SwarmObjective watch = [&](const SwarmRows& particles,
                                   Eigen::Ref<Eigen::ArrayXd> values) {
    for (Eigen::Index i = 0; i < particles.rows(); ++i) {
      const Eigen::Vector2d x = particles.row(i).transpose();
      inside &= (x.array() >= settings.lower.array()).all() &&
                (x.array() <= settings.upper.array()).all();
      values[i] = x.squaredNorm();
    }
  };
  const auto result = minimise_qpso(watch, box_start(20, 2, 9.0, 6), settings);
  EXPECT_TRUE(inside);
  EXPECT_EQ(result.best, Eigen::Vector2d(2.0, -0.5));
}

TEST(Qpso, CanBeCancelledAndKeepsWhatItHad) {
  std::stop_source stop;
  QpsoSettings settings;
  settings.iterations = 1000;
  const auto result = minimise_qpso(
      objective_of(sphere), box_start(20, 4, 9.0, 7), settings,
      [&](const QpsoProgress& progress) {
        EXPECT_EQ(progress.iterations, 1000);
        if (progress.iteration == 25) stop.request_stop();
      },
      stop.get_token());
  EXPECT_TRUE(result.cancelled);
  EXPECT_EQ(result.history.size(), 26U);
  EXPECT_TRUE(std::isfinite(result.value));
}

TEST(Qpso, PassesOnWhatItsObjectiveThrows) {
  QpsoSettings settings;
  settings.threads = 2;
  const SwarmObjective thrower = [](const SwarmRows&, Eigen::Ref<Eigen::ArrayXd>) {
    throw std::runtime_error("objective");
  };
  EXPECT_THROW(
      (void)minimise_qpso(thrower, box_start(20, 2, 1.0, 8), settings), std::runtime_error);
}

TEST(Qpso, RefusesAStartWithoutParticlesAndBoundsThatDoNotFit) {
  QpsoSettings settings;
  EXPECT_THROW(
      (void)minimise_qpso(objective_of(sphere), Eigen::ArrayXXd(0, 3), settings),
      std::invalid_argument);
  settings.lower = Eigen::VectorXd::Zero(2);
  EXPECT_THROW(
      (void)minimise_qpso(objective_of(sphere), box_start(5, 3, 1.0, 9), settings),
      std::invalid_argument);
}

TEST(Qpso, SettledAfterIsTheFirstIterationWithinOnePercent) {
  const double history[] = {10, 5, 2, 1.005, 1.0, 1.0};
  EXPECT_EQ(settled_after(history), 3);
}

TEST(Random, IsAFunctionOfItsCounterAndLooksUniformAndNormal) {
  EXPECT_EQ(random_words(1, 2, 3, 4, 5), random_words(1, 2, 3, 4, 5));
  EXPECT_NE(random_words(1, 2, 3, 4, 5), random_words(2, 2, 3, 4, 5));
  EXPECT_NE(random_words(1, 2, 3, 4, 5), random_words(1, 2, 3, 4, 6));
  RandomSequence random(11);
  double sum = 0.0;
  double squares = 0.0;
  double normal = 0.0;
  double normal_squares = 0.0;
  constexpr int kCount = 40000;
  for (int i = 0; i < kCount; ++i) {
    const double u = random.uniform();
    ASSERT_GT(u, 0.0);
    ASSERT_LT(u, 1.0);
    sum += u;
    squares += u * u;
    const double z = random.normal();
    normal += z;
    normal_squares += z * z;
  }
  EXPECT_LT(std::abs(sum / kCount - 0.5), 0.007);  // five standard errors
  EXPECT_LT(std::abs(squares / kCount - 1.0 / 3), 0.008);
  EXPECT_LT(std::abs(normal / kCount), 0.025);
  EXPECT_LT(std::abs(normal_squares / kCount - 1.0), 0.036);
}

}  // namespace
}  // namespace sixdial::calibration
