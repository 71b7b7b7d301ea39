// ANFIS: formulas, training, bounds, and Jang's Mackey-Glass experiment.
#include "calibration/anfis.h"

#include <gtest/gtest.h>

#include <Eigen/Cholesky>
#include <Eigen/QR>
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>

#include "calibration/anfis_kernels.h"
#include "calibration/anfis_rules.h"
#include "calibration/random.h"
#include "tests/calibration/anfis_data.h"

namespace sixdial::calibration {
namespace {

using Eigen::MatrixXd;
using Eigen::VectorXd;

constexpr double kKernel = 1e-12;  // relative, exp and a few sums

double rmse_on(const AnfisModel& model, const MatrixXd& x, const VectorXd& y) {
  double sum = 0.0;
  for (Eigen::Index i = 0; i < x.rows(); ++i) {
    sum += std::pow(model.predict(x.row(i).transpose()) - y[i], 2);
  }
  return std::sqrt(sum / static_cast<double>(x.rows()));
}

TEST(Anfis, MembershipsAreEquation40AndJangsBell) {
  AnfisModel model = initial_anfis(random_inputs(20, 2, 1), MembershipKind::kGaussian, 3);
  model.input_mean[1] = 0.5;
  model.input_scale[1] = 2.0;
  model.centre(2, 1) = 0.25;
  model.width(2, 1) = 0.5;
  const double z = ((3.0 - 0.5) / 2.0 - 0.25) / 0.5;
  EXPECT_NEAR(model.membership(1, 3.0)[2], std::exp(-z * z), 1e-15);
  model.kind = MembershipKind::kBell;
  model.slope = MatrixXd::Constant(3, 2, 1.5);
  EXPECT_NEAR(model.membership(1, 3.0)[2], 1.0 / (1.0 + std::pow(z, 3.0)), 1e-15);
}

TEST(Anfis, FunctionsStartEvenlyAndCrossAtOneHalf) {
  for (const auto kind : {MembershipKind::kGaussian, MembershipKind::kBell}) {
    const MatrixXd x = random_inputs(60, 1, 2);
    const AnfisModel model = initial_anfis(x, kind, 5);
    const double low = x.minCoeff();
    const double gap = (x.maxCoeff() - low) / 4;
    for (int k = 0; k < 4; ++k) {
      const VectorXd mu = model.membership(0, low + gap * (k + 0.5));
      EXPECT_NEAR(mu[k], 0.5, 1e-12);
      EXPECT_NEAR(mu[k + 1], 0.5, 1e-12);
    }
  }
}

TEST(Anfis, RuleStrengthsAddUpToOne) {
  const MatrixXd x = random_inputs(30, 3, 3);
  const AnfisModel model = initial_anfis(x, MembershipKind::kGaussian, 3);
  const MatrixXd A = design_matrix(model, x);
  ASSERT_EQ(A.cols(), 27 * 4);
  for (Eigen::Index i = 0; i < A.rows(); ++i) {
    double sum = 0.0;
    for (int r = 0; r < 27; ++r) sum += A(i, 4 * r);
    EXPECT_NEAR(sum, 1.0, 1e-14);
  }
}

TEST(AnfisKernels, GramMatrixOfTheProductFormIsAATransposed) {
  for (const int inputs : {1, 2, 3}) {
    const MatrixXd x = random_inputs(21, inputs, 4);
    const AnfisModel model = initial_anfis(x, MembershipKind::kGaussian, 3);
    const MatrixXd A = design_matrix(model, x);
    const int padded = padded_size(21);
    MatrixXd xs = MatrixXd::Zero(padded, inputs + 1);
    MatrixXd nu(padded, 3 * inputs);
    MatrixXd scratch(padded, 3);
    MatrixXd scratch2(padded, 3);
    for (int i = 0; i < 21; ++i) {
      xs(i, 0) = 1.0;
      for (int k = 0; k < inputs; ++k) {
        xs(i, k + 1) = (x(i, k) - model.input_mean[k]) / model.input_scale[k];
      }
    }
    for (int k = 0; k < inputs; ++k) {
      anfis_memberships(
          model.kind, 3, padded, xs.col(k + 1).data(), model.centre.col(k).data(),
          model.width.col(k).data(), nullptr,
          {nu.col(3 * k).data(), scratch.data(), scratch2.data(), nullptr});
    }
    MatrixXd K = MatrixXd::Zero(padded, padded);
    anfis_gram_dual(inputs, 3, padded, xs.data(), nu.data(), K.data());
    const MatrixXd expected = A * A.transpose();
    for (int j = 0; j < 21; ++j) {
      for (int i = j; i < 21; ++i) {
        EXPECT_LT(std::abs(K(i, j) - expected(i, j)), kKernel * expected.maxCoeff());
      }
    }
    // and A'A from columns
    const auto columns = static_cast<int>(A.cols());
    MatrixXd padded_A = MatrixXd::Zero(padded, columns);
    padded_A.topRows(21) = A;
    const int ld = padded_size(columns);
    MatrixXd G = MatrixXd::Zero(ld, ld);
    gram_primal(columns, padded, padded_A.data(), ld, G.data());
    const MatrixXd primal = A.transpose() * A;
    for (int j = 0; j < columns; ++j) {
      for (int i = j; i < columns; ++i) {
        EXPECT_LT(std::abs(G(i, j) - primal(i, j)), kKernel * primal.maxCoeff());
      }
    }
  }
}

TEST(AnfisRules, DoWhatTheDesignDoes) {
  // 600 samples: more than a kernel takes at once.
  for (const auto& [inputs, functions, samples] :
       {std::array{1, 4, 21}, {2, 3, 600}, {3, 2, 40}, {5, 2, 77}, {6, 3, 19}}) {
    const MatrixXd x = random_inputs(samples, inputs, 6);
    const AnfisModel model = initial_anfis(x, MembershipKind::kGaussian, functions);
    const MatrixXd A = design_matrix(model, x);
    const int padded = padded_size(samples);
    const int per_rule = inputs + 1;
    MatrixXd xs = MatrixXd::Zero(padded, per_rule);
    MatrixXd nu = MatrixXd::Zero(padded, inputs * functions);
    for (int a = 0; a < samples; ++a) {
      xs(a, 0) = 1.0;
      for (int i = 0; i < inputs; ++i) {
        xs(a, i + 1) = (x(a, i) - model.input_mean[i]) / model.input_scale[i];
        const VectorXd mu = model.membership(i, x(a, i));
        nu.row(a).segment(i * functions, functions) = (mu / mu.sum()).transpose();
      }
    }
    RandomSequence random(7);
    VectorXd alpha = VectorXd::Zero(padded), B(A.cols());
    for (int a = 0; a < samples; ++a) alpha[a] = random.normal();
    for (double& each : B) each = random.normal();
    AnfisRules rules(inputs, functions, padded);
    rules.set(nu);
    VectorXd projected(A.cols()), out(padded);
    rules.project(xs, alpha, projected);
    const VectorXd expected = A.transpose() * alpha.head(samples);
    EXPECT_LT((projected - expected).norm(), kKernel * expected.norm()) << inputs;
    rules.answer(xs, B, out);
    EXPECT_LT((out.head(samples) - A * B).norm(), kKernel * (A * B).norm()) << inputs;
    // Of the rules that use one function of one input.
    MatrixXd sums = MatrixXd::Zero(padded, inputs * functions);
    rules.add_by_function(xs, B, sums);
    int stride = 1;
    for (int i = 0; i < inputs; ++i, stride *= functions) {
      for (int k = 0; k < functions; ++k) {
        const VectorXd some = sums.col(i * functions + k);
        VectorXd of_rules = VectorXd::Zero(samples);
        for (int r = 0; r < model.rules(); ++r) {
          if (r / stride % functions != k) continue;
          of_rules += A.middleCols(r * per_rule, per_rule) * B.segment(r * per_rule, per_rule);
        }
        EXPECT_LT((some.head(samples) - of_rules).norm(), kKernel * (A * B).norm())
            << inputs << ' ' << i << ' ' << k;
      }
    }
  }
}

TEST(AnfisKernels, CholeskySolvesEverySizeAndRefusesIndefiniteOnes) {
  for (int n = 1; n <= 90; ++n) {
    RandomSequence random(static_cast<std::uint64_t>(n));
    MatrixXd B(n, n);
    for (double& b : B.reshaped()) b = random.normal();
    const int ld = padded_size(n);
    MatrixXd K = MatrixXd::Constant(ld, ld, 9.0);  // scratch rows must not matter
    K.topLeftCorner(n, n) = B * B.transpose() + MatrixXd::Identity(n, n);
    const MatrixXd original = K.topLeftCorner(n, n);
    VectorXd b = VectorXd::Constant(ld, 7.0);
    for (int i = 0; i < n; ++i) b[i] = random.normal();
    const VectorXd right = b.head(n);
    ASSERT_TRUE(cholesky_solve(n, ld, K.data(), b.data()));
    EXPECT_LT((original * b.head(n) - right).norm(), 1e-10 * right.norm()) << n;
  }
  MatrixXd K = MatrixXd::Identity(8, 8);
  K(3, 3) = -1.0;
  VectorXd b = VectorXd::Ones(8);
  EXPECT_FALSE(cholesky_solve(8, 8, K.data(), b.data()));
}

TEST(Anfis, GradientStepsMakeTheTrainingErrorFall) {
  for (const auto kind : {MembershipKind::kGaussian, MembershipKind::kBell}) {
    for (const int inputs : {1, 2, 3}) {
      const MatrixXd x = random_inputs(120, inputs, 5);
      const VectorXd y = smooth(x);
      AnfisSettings settings;
      settings.kind = kind;
      settings.functions = 2;
      settings.epochs = 200;
      settings.ridge = 1e-9;
      const auto training = train_anfis(x, y, MatrixXd(0, inputs), VectorXd(0), settings);
      ASSERT_EQ(training.train_rmse.size(), 200U);
      EXPECT_LT(training.train_rmse[20], training.train_rmse[0]);
      EXPECT_LT(
          training.train_rmse[static_cast<std::size_t>(training.best_epoch) - 1],
          0.8 * training.train_rmse[0]);
      // the model that is kept answers as the best epoch did
      EXPECT_NEAR(
          rmse_on(training.model, x, y),
          training.train_rmse[static_cast<std::size_t>(training.best_epoch) - 1],
          1e-3 * training.train_rmse[0]);
    }
  }
}

TEST(Anfis, PremiseGradientIsTheDerivativeOfTheError) {
  // One tiny step falls by |gradient| * step: compared along the steepest direction by the
  // error of two trainings with the same consequents rule.
  const MatrixXd x = random_inputs(80, 2, 6);
  const VectorXd y = smooth(x);
  AnfisSettings settings;
  settings.functions = 2;
  settings.epochs = 2;
  settings.ridge = 1e-8;
  const auto fall = [&](double step) {
    settings.first_step = step;
    const auto training = train_anfis(x, y, MatrixXd(0, 2), VectorXd(0), settings);
    return std::pow(training.train_rmse[0], 2) - std::pow(training.train_rmse[1], 2);
  };
  const double small = fall(1e-5);
  EXPECT_GT(small, 0.0);
  EXPECT_NEAR(fall(2e-5) / small, 2.0, 0.01);  // linear in the step: a true descent direction
}

TEST(Anfis, StepGrowsAfterFourFallsInARow) {
  const MatrixXd x = random_inputs(100, 2, 7);
  AnfisSettings settings;
  settings.functions = 2;
  settings.epochs = 30;
  settings.first_step = 1e-4;
  settings.ridge = 1e-8;
  const auto training = train_anfis(x, smooth(x), MatrixXd(0, 2), VectorXd(0), settings);
  for (int e = 0; e < 5; ++e) EXPECT_EQ(training.step[static_cast<std::size_t>(e)], 1e-4);
  EXPECT_NEAR(training.step[5], 1.1e-4, 1e-18);
  EXPECT_NEAR(training.step[9], 1.21e-4, 1e-18);
}

TEST(Anfis, KeepsTheEpochWithTheLeastCheckingError) {
  const MatrixXd x = random_inputs(100, 2, 8);
  RandomSequence random(8);
  VectorXd y = smooth(x);
  for (double& each : y) each += 0.004 * random.normal();
  AnfisSettings settings;
  settings.epochs = 100;
  const auto training =
      train_anfis(x.topRows(80), y.head(80), x.bottomRows(20), y.tail(20), settings);
  const auto best = std::ranges::min_element(training.check_rmse);
  EXPECT_EQ(training.best_epoch, best - training.check_rmse.begin() + 1);
  EXPECT_EQ(training.target_reached, 1);  // 108 consequents on 80 samples
  EXPECT_GT(training.model.effective_parameters, 30.0);
  EXPECT_LT(training.model.effective_parameters, 80.0);
}

TEST(Anfis, StopsAtItsTargetWhereThatIsAsked) {
  const MatrixXd x = random_inputs(300, 2, 8);
  RandomSequence random(8);
  VectorXd y = smooth(x);
  for (double& each : y) each += 0.004 * random.normal();
  AnfisSettings settings;
  settings.functions = 2;
  settings.epochs = 60;
  const auto all = train_anfis(x, y, MatrixXd(0, 2), VectorXd(0), settings);
  ASSERT_EQ(all.train_rmse.size(), 60U);
  // A target that some epoch in the middle is the first to reach.
  settings.target_mse = std::pow(all.train_rmse[20], 2);
  settings.stop_at_target = true;
  const auto stopped = train_anfis(x, y, MatrixXd(0, 2), VectorXd(0), settings);
  ASSERT_GT(stopped.target_reached, 1);
  EXPECT_LE(stopped.target_reached, 21);
  EXPECT_EQ(std::ssize(stopped.train_rmse), stopped.target_reached);
  EXPECT_EQ(stopped.best_epoch, stopped.target_reached);
}

TEST(Anfis, IsBoundedOutsideWhatItLearned) {
  const MatrixXd x = random_inputs(80, 2, 9);
  const VectorXd y = smooth(x);
  const auto training = train_anfis(x, y, MatrixXd(0, 2), VectorXd(0), {});
  const double range = y.maxCoeff() - y.minCoeff();
  RandomSequence random(9);
  double largest = 0.0;
  for (int i = 0; i < 5000; ++i) {
    const Eigen::Vector2d far(random.uniform(-50, 50), random.uniform(-50, 50));
    const double out = training.model.predict(far);
    ASSERT_TRUE(std::isfinite(out));
    largest = std::max(largest, std::abs(out - y.mean()));
  }
  EXPECT_LT(largest, 1.3 * range);
}

TEST(Anfis, RidgeInDualAndPrimalFormAreTheSame) {
  const MatrixXd x = random_inputs(100, 2, 10);
  const VectorXd y = smooth(x);
  const AnfisModel start = initial_anfis(x, MembershipKind::kGaussian, 4);  // 48 consequents
  const MatrixXd A = design_matrix(start, x);
  for (const double ridge : {1e-4, 1e-1}) {
    const AnfisModel model = refit_consequents(start, x, y, ridge);
    const MatrixXd dual =
        A.transpose() *
        (A * A.transpose() + ridge * MatrixXd::Identity(100, 100)).llt().solve(y);
    for (int r = 0; r < 16; ++r) {
      for (int c = 0; c < 3; ++c)
        EXPECT_NEAR(model.consequents(r, c), dual(3 * r + c, 0), 1e-9);
    }
    const MatrixXd hat =
        A * (A.transpose() * A + ridge * MatrixXd::Identity(48, 48)).llt().solve(A.transpose());
    EXPECT_NEAR(model.effective_parameters, hat.trace(), 1e-8);
  }
}

TEST(Anfis, RefusesWhatItCannotTrain) {
  EXPECT_THROW(
      (void)initial_anfis(random_inputs(10, 8, 1), MembershipKind::kGaussian, 6),
      std::invalid_argument);
  EXPECT_THROW(
      (void)train_anfis(random_inputs(10, 2, 1), VectorXd(9), MatrixXd(0, 2), VectorXd(0), {}),
      std::invalid_argument);
  EXPECT_EQ(zero_anfis(2).predict(Eigen::Vector2d(3, 4)), 0.0);
}

/// x(t) of Jang 1993: Runge-Kutta of fourth order, delay 17, x(0) = 1.2, x(t < 0) = 0.
std::vector<double> mackey_glass(int last, double step) {
  const int per_unit = static_cast<int>(std::lround(1.0 / step));
  const int delay = 17 * per_unit;
  std::vector<double> x{1.2};
  const auto at = [&](int k) { return k < 0 ? 0.0 : x[static_cast<std::size_t>(k)]; };
  for (int k = 0; k < last * per_unit; ++k) {
    const auto slope = [](double now, double then) {
      return 0.2 * then / (1.0 + std::pow(then, 10)) - 0.1 * now;
    };
    const double d0 = at(k - delay);
    const double d1 = at(k - delay + 1);
    const double dm = 0.5 * (d0 + d1);
    const double now = x.back();
    const double k1 = slope(now, d0);
    const double k2 = slope(now + step / 2 * k1, dm);
    const double k3 = slope(now + step / 2 * k2, dm);
    const double k4 = slope(now + step * k3, d1);
    x.push_back(now + step / 6 * (k1 + 2 * k2 + 2 * k3 + k4));
  }
  std::vector<double> units;
  for (int t = 0; t <= last; ++t) units.push_back(at(t * per_unit));
  return units;
}

TEST(Anfis, PredictsTheMackeyGlassSeriesAsJangDid) {
  const auto series = mackey_glass(1123, 0.01);
  MatrixXd x(1000, 4);
  VectorXd y(1000);
  for (int i = 0; i < 1000; ++i) {
    const auto t = static_cast<std::size_t>(118 + i);
    x.row(i) << series[t - 18], series[t - 12], series[t - 6], series[t];
    y[i] = series[t + 6];
  }
  AnfisSettings settings;
  settings.kind = MembershipKind::kBell;
  settings.functions = 2;
  settings.epochs = 500;
  settings.ridge = 1e-8;
  const auto training =
      train_anfis(x.topRows(500), y.head(500), MatrixXd(0, 4), VectorXd(0), settings);
  EXPECT_EQ(training.model.consequents.size() + 3 * 8, 104);
  const double check = rmse_on(training.model, x.bottomRows(500), y.tail(500));
  std::printf(
      "Mackey-Glass: training RMSE %.5f, checking %.5f after %d epochs\n",
      training.train_rmse[static_cast<std::size_t>(training.best_epoch) - 1], check,
      training.best_epoch);
  EXPECT_LT(training.train_rmse[static_cast<std::size_t>(training.best_epoch) - 1], 0.0017);
  EXPECT_LT(check, 0.0021);
}

}  // namespace
}  // namespace sixdial::calibration
