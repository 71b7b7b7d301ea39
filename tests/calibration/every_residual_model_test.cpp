// One law suite for all residual models.
#include <gtest/gtest.h>

#include <cmath>
#include <cstdio>

#include "calibration/bpnn_kernel.h"
#include "calibration/random.h"
#include "calibration/residual_model.h"
#include "calibration/space_fit.h"
#include "tests/calibration/support.h"

namespace sixdial::calibration {
namespace {

struct Case {
  testing::SimulatedSession session;
  geometry::ParameterVector v;
  Eigen::MatrixX2d q;
  Eigen::MatrixX2d residual;
};

Case residuals(double non_kinematic, std::uint64_t seed) {
  testing::SessionPlan plan;
  plan.non_kinematic = non_kinematic;
  Case result;
  result.session = testing::simulate(plan, seed);
  result.v = fit_positions(result.session.g1, result.session.nominal).v;
  result.q = result.session.g1.q_rad.transpose();
  result.residual = position_residuals(result.session.g1, result.v).transpose();
  return result;
}

double mean_g2(const Case& c, const TrainedResidual& model) {
  Eigen::Matrix2Xd errors = position_residuals(c.session.g2, c.v);
  for (int i = 0; i < c.session.g2.size(); ++i) {
    errors.col(i) -= model.correction(c.session.g2.q_rad.col(i));
  }
  return errors.colwise().norm().mean();
}

class EveryResidualModel : public ::testing::TestWithParam<const ResidualModel*> {};

TEST_P(EveryResidualModel, ImprovesFreshPosesWhereThereIsSomethingToLearn) {
  const Case c = residuals(1.45, 1);
  const auto trained = train_residual(*GetParam(), c.q, c.residual);
  const double before = position_residuals(c.session.g2, c.v).colwise().norm().mean();
  const double after = mean_g2(c, trained);
  std::printf(
      "%-12s G2 mean %.4f -> %.4f mm; %s\n", GetParam()->name.data(), before, after,
      trained.note.c_str());
  if (GetParam()->name == "none") {
    EXPECT_EQ(after, before);
  } else {
    EXPECT_LT(after, 0.9 * before);
  }
  EXPECT_FALSE(trained.note.empty());
}

TEST_P(EveryResidualModel, IsBoundedAnywhere) {
  const Case c = residuals(1.45, 2);
  ResidualSettings settings;
  settings.bpnn_epochs = 2000;
  const auto trained = train_residual(*GetParam(), c.q, c.residual, settings);
  const double most =
      1.2 * (c.residual.colwise().maxCoeff() - c.residual.colwise().minCoeff()).norm();
  RandomSequence random(2);
  for (int i = 0; i < 500; ++i) {
    const Eigen::Vector2d q(random.uniform(-20, 20), random.uniform(-20, 20));
    const Eigen::Vector2d out = trained.correction(q);
    ASSERT_TRUE(out.allFinite());
    EXPECT_LT(out.norm(), most);
  }
}

TEST_P(EveryResidualModel, TwiceGivesTheSame) {
  const Case c = residuals(1.45, 3);
  ResidualSettings settings;
  settings.bpnn_epochs = 500;
  const auto one = train_residual(*GetParam(), c.q, c.residual, settings);
  const auto two = train_residual(*GetParam(), c.q, c.residual, settings);
  for (int i = 0; i < c.session.g2.size(); ++i) {
    EXPECT_EQ(
        one.correction(c.session.g2.q_rad.col(i)), two.correction(c.session.g2.q_rad.col(i)));
  }
}

TEST_P(EveryResidualModel, WhatIsLoadedAnswersAsWhatWasSavedBitForBit) {
  const Case c = residuals(1.45, 5);
  ResidualSettings settings;
  settings.bpnn_epochs = 500;
  const auto trained = train_residual(*GetParam(), c.q, c.residual, settings);
  const auto loaded = load_residual(*GetParam(), trained.saved);
  EXPECT_EQ(loaded.effective_parameters, trained.effective_parameters);
  EXPECT_EQ(static_cast<bool>(loaded.sd), static_cast<bool>(trained.sd));
  RandomSequence random(5);
  for (int i = 0; i < 200; ++i) {
    const Eigen::Vector2d q(random.uniform(-4, 4), random.uniform(-4, 4));
    EXPECT_EQ(loaded.correction(q), trained.correction(q));
    if (trained.sd) {
      EXPECT_EQ(loaded.sd(q), trained.sd(q));
    }
  }
  for (int i = 0; i < c.session.g2.size(); ++i) {
    const Eigen::Vector2d q = c.session.g2.q_rad.col(i);
    EXPECT_EQ(loaded.correction(q), trained.correction(q));
  }
  EXPECT_EQ(loaded.saved, trained.saved);
}

TEST_P(EveryResidualModel, NamesTheSavedMatrixThatIsMissingOrDoesNotFit) {
  const Case c = residuals(1.45, 6);
  ResidualSettings settings;
  settings.bpnn_epochs = 500;
  const auto trained = train_residual(*GetParam(), c.q, c.residual, settings);
  for (const auto& [name, matrix] : trained.saved) {
    SavedResidual without = trained.saved;
    without.erase(name);
    const bool unused = name.ends_with(".slope");  // of bell functions only
    if (unused) continue;
    SavedResidual other = trained.saved;
    other[name] = Eigen::MatrixXd::Ones(matrix.rows() + 1, matrix.cols() + 1);
    for (const SavedResidual& broken : {without, other}) {
      try {
        (void)load_residual(*GetParam(), broken);
        ADD_FAILURE() << name << " was not missed";
      } catch (const std::invalid_argument& error) {
        EXPECT_NE(std::string(error.what()).find('"'), std::string::npos);
      }
    }
  }
}

TEST_P(EveryResidualModel, RefusesTooFewSamples) {
  EXPECT_THROW(
      (void)train_residual(
          *GetParam(), Eigen::MatrixX2d::Zero(2, 2), Eigen::MatrixX2d::Zero(2, 2)),
      std::invalid_argument);
}

INSTANTIATE_TEST_SUITE_P(
    , EveryResidualModel, ::testing::ValuesIn(all_residual_models()),
    [](const auto& each) { return std::string{each.param->name}; });

TEST(ResidualModels, TheProcessKnowsHowSureItIs) {
  const Case c = residuals(1.45, 4);
  const auto trained = train_residual(*find_residual_model("gp"), c.q, c.residual);
  ASSERT_TRUE(trained.sd);
  Eigen::Matrix2Xd errors = position_residuals(c.session.g2, c.v);
  int inside = 0;
  for (int i = 0; i < c.session.g2.size(); ++i) {
    const Eigen::Vector2d q = c.session.g2.q_rad.col(i);
    const Eigen::Vector2d e = errors.col(i) - trained.correction(q);
    const Eigen::Vector2d sd = trained.sd(q);
    for (int axis = 0; axis < 2; ++axis) {
      EXPECT_GT(sd[axis], 0.0);
      inside += std::abs(e[axis]) < 2 * std::hypot(sd[axis], 0.003) ? 1 : 0;
    }
  }
  EXPECT_GE(inside, 85);  // of 100, at two standard deviations
}

TEST(ResidualModels, TheProcessAndAnfisKeepQuietOnNoise) {
  for (const char* name : {"anfis", "gp"}) {
    int worse = 0;
    for (std::uint64_t seed = 20; seed < 35; ++seed) {
      const Case c = residuals(0.0, seed);
      const double before = position_residuals(c.session.g2, c.v).colwise().norm().mean();
      worse += mean_g2(c, train_residual(*find_residual_model(name), c.q, c.residual)) >
                       1.05 * before
                   ? 1
                   : 0;
    }
    EXPECT_LE(worse, 1) << name;
  }
}

// Every pose is there three times, with an error of its own that no other pose shares. Whoever
// leaves out one of the three "predicts" it from the other two.
TEST(ResidualModels, CopiesOfAPoseTeachAnfisNothing) {
  int networks = 0;
  for (std::uint64_t seed = 60; seed < 75; ++seed) {
    const Case c = residuals(0.0, seed);
    RandomSequence random(seed + 1);
    const Eigen::Index n = c.q.rows();
    Eigen::MatrixXd joints(3 * n, 2);
    Eigen::MatrixXd residual(3 * n, 2);
    for (Eigen::Index i = 0; i < n; ++i) {
      const Eigen::RowVector2d own(0.01 * random.normal(), 0.01 * random.normal());
      for (Eigen::Index k = 0; k < 3; ++k) {
        const Eigen::RowVector2d jitter(random.uniform(-1, 1), random.uniform(-1, 1));
        joints.row(3 * i + k) = c.q.row(i) + 2e-5 * jitter;
        residual.row(3 * i + k) = c.residual.row(i) + own + 0.001 * jitter;
      }
    }
    const auto trained = train_residual(*find_residual_model("anfis"), joints, residual);
    networks += (trained.effective_parameters.array() > 0.0).count() > 0 ? 1 : 0;
  }
  EXPECT_LE(networks, 2);
}

TEST(Bpnn, GradientIsTheDerivativeOfTheError) {
  constexpr int kHidden = 3;
  constexpr int kPadded = 16;
  RandomSequence random(5);
  Eigen::MatrixXd arrays(kPadded, 5);
  for (double& each : arrays.reshaped()) each = random.uniform(-1, 1);
  arrays.col(4).setOnes();
  arrays(15, 4) = 0.0;  // padding
  const BpnnShape shape{2, kHidden, 2};
  Eigen::VectorXd weights(shape.weights());
  for (double& each : weights) each = random.uniform(-1, 1);
  Eigen::VectorXd gradient(weights.size());
  Eigen::VectorXd scratch((2 + kHidden) * kPadded);
  const auto error = [&](const Eigen::VectorXd& w, double* g) {
    return bpnn_error(
        shape, kPadded, arrays.col(0).data(), arrays.col(2).data(), arrays.col(4).data(),
        w.data(), g, scratch.data());
  };
  const double value = error(weights, gradient.data());
  double plain = 0.0;
  for (int a = 0; a < 15; ++a) {
    Eigen::Vector2d out = weights.tail<2>();
    for (int h = 0; h < kHidden; ++h) {
      const auto w = weights.segment<5>(5 * h);
      out += std::tanh(w[0] * arrays(a, 0) + w[1] * arrays(a, 1) + w[2]) * w.tail<2>();
    }
    plain += (out - arrays.block<1, 2>(a, 2).transpose()).squaredNorm();
  }
  EXPECT_NEAR(value, plain, 1e-12 * plain);
  for (Eigen::Index i = 0; i < weights.size(); ++i) {
    Eigen::VectorXd moved = weights;
    moved[i] += 1e-6;
    const double high = error(moved, nullptr);
    moved[i] -= 2e-6;
    EXPECT_NEAR((high - error(moved, nullptr)) / 2e-6, gradient[i], 1e-6);
  }
}

}  // namespace
}  // namespace sixdial::calibration
