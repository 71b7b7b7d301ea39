// Every method on a robot that is no five-bar: three joints, five parameters, positions in
// space. And the rows of the tables that are added while the program runs.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <string>

#include "calibration/comparison.h"
#include "calibration/pipeline.h"
#include "calibration/uncertainty.h"
#include "tests/calibration/spatial_arm.h"

namespace sixdial::calibration {
namespace {

using testing::measured_arm;
using testing::SpatialArm;

constexpr double kNoise_mm = 0.003;

ComparisonSettings quick() {
  ComparisonSettings settings;
  settings.identify.qpso1 = {20, 20};
  settings.identify.qpso2 = {30, 150};
  settings.residual.anfis.epochs = 5;
  settings.residual.bpnn_epochs = 500;
  return settings;
}

TEST(AnyRobot, TheJacobianIsTheDerivative) {
  const SpatialArm arm = measured_arm(1);
  const Eigen::VectorXd scale = arm.g1.scale();
  Eigen::VectorXd e(3);
  Eigen::VectorXd high(3);
  Eigen::VectorXd low(3);
  Eigen::MatrixXd J(3, 5);
  ASSERT_TRUE(arm.g1.evaluate(7, arm.truth, e, &J));
  for (int k = 0; k < 5; ++k) {
    Eigen::VectorXd x = arm.truth;
    x[k] += 1e-4 * scale[k];
    ASSERT_TRUE(arm.g1.evaluate(7, x, high, nullptr));
    x[k] -= 2e-4 * scale[k];
    ASSERT_TRUE(arm.g1.evaluate(7, x, low, nullptr));
    EXPECT_LT((J.col(k) + (high - low) / (2e-4 * scale[k])).norm() * scale[k], 1e-6) << k;
  }
}

class IdentifierOnAnyRobot : public ::testing::TestWithParam<const Identifier*> {};

TEST_P(IdentifierOnAnyRobot, FindsTheParameters) {
  const SpatialArm arm = measured_arm(2);
  const Identified found = identify(*GetParam(), arm.g1, quick().identify);
  ASSERT_EQ(found.x.size(), 5);
  // A single linear step leaves what is not linear, some ten micrometres from half a
  // millimetre; and a filter with Q = 1e-4 for everything lets angles wander.
  const bool rough = GetParam()->name == "lse" || GetParam()->name == "ekf";
  EXPECT_LT(found.rmse, rough ? 0.05 : 0.02);
  EXPECT_LT(
      (found.x - arm.truth).cwiseQuotient(arm.g1.scale()).cwiseAbs().maxCoeff(),
      rough ? 0.1 : 0.02);
  EXPECT_EQ(found.covariance.rows(), 5);
  EXPECT_EQ(found.fit.held, 0);
}

TEST_P(IdentifierOnAnyRobot, LeavesFixedParametersAlone) {
  const SpatialArm arm = measured_arm(3);
  IdentifySettings settings = quick().identify;
  settings.fixed = fixed_by_name(arm.g1, std::vector<std::string>{"height", "elbow"}).value();
  const Identified found = identify(*GetParam(), arm.g1, settings);
  EXPECT_EQ(found.x[0], 150.0);
  EXPECT_EQ(found.x[4], 0.0);
}

INSTANTIATE_TEST_SUITE_P(
    , IdentifierOnAnyRobot, ::testing::ValuesIn(all_identifiers()),
    [](const auto& each) { return std::string{each.param->name}; });

TEST(AnyRobot, EveryMethodGoesWithEveryResidualModel) {
  const SpatialArm arm = measured_arm(4, kNoise_mm, 0.03);
  std::vector<MethodChoice> choices{method_choice("before").value()};
  for (const ResidualModel* model : all_residual_models()) {
    choices.push_back(method_choice("lm+" + std::string(model->name)).value());
  }
  for (const Identifier* identifier : all_identifiers()) {
    choices.push_back(method_choice(std::string(identifier->name) + "+rbf").value());
  }
  const auto compared = compare_methods(arm.g1, arm.g1, arm.g2, choices, quick());
  ASSERT_TRUE(compared) << compared.error().message;
  ASSERT_EQ(compared->methods.size(), choices.size());
  EXPECT_TRUE(compared->before_uses_targets);
  const double before_mm = compared->methods.front().errors.g2.mean_mm;
  EXPECT_GT(before_mm, 0.1);
  for (const ComparedMethod& method : compared->methods) {
    if (!method.robot) continue;
    EXPECT_LT(method.errors.g2.mean_mm, 0.5 * before_mm) << method.choice.id;
    EXPECT_EQ(method.residual.correction(arm.g1.joints.col(0)).size(), 3) << method.choice.id;
    EXPECT_EQ(method.residual.effective_parameters.size(), 3) << method.choice.id;
  }
}

TEST(AnyRobot, ANetworkLearnsWhatNoParameterExplains) {
  const SpatialArm arm = measured_arm(5, kNoise_mm, 0.05, 200);
  const auto compared = compare_methods(
      arm.g1, arm.g1, arm.g2,
      {method_choice("lm").value(), method_choice("lm+gp").value(),
       method_choice("lm+rbf").value()},
      quick());
  ASSERT_TRUE(compared) << compared.error().message;
  const double alone_mm = compared->methods[0].errors.g2.mean_mm;
  EXPECT_LT(compared->methods[1].errors.g2.mean_mm, 0.5 * alone_mm);
  EXPECT_LT(compared->methods[2].errors.g2.mean_mm, 0.8 * alone_mm);
}

TEST(AnyRobot, ThePapersMethodRunsFromEndToEnd) {
  const SpatialArm arm = measured_arm(6);
  PipelineSettings settings;
  settings.qpso1 = {20, 20};
  settings.anfis.epochs = 5;
  const auto result = run_dqpso_anfis(arm.g1, arm.g2, settings);
  ASSERT_TRUE(result) << result.error().message;
  EXPECT_EQ(result->networks.size(), 3U);
  EXPECT_EQ(result->noise.q.size(), 5);
  EXPECT_EQ(result->noise.r.size(), 3);
  EXPECT_LT(std::abs(result->above_minimum_mm), 1e-5);
  EXPECT_LT(result->errors("ekf_dqpso").g2.mean_mm, 0.01);
  ASSERT_EQ(result->parameters.size(), 5U);
  EXPECT_EQ(result->parameters[1].name, "upper");
  for (std::size_t k = 0; k < 5; ++k) {
    const auto i = static_cast<Eigen::Index>(k);
    EXPECT_LT(std::abs(result->v[i] - arm.truth[i]), 4.5 * result->parameters[k].sd) << k;
  }
}

TEST(AnyRobot, TheFilterEndsNearTheTruth) {
  const SpatialArm arm = measured_arm(7);
  const FilterRun run = run_filter(arm.g1);
  EXPECT_EQ(run.unreachable, 0);
  EXPECT_EQ(run.history.size(), 80U);
  EXPECT_LT(position_rmse(arm.g1, run.v), 0.02);
  // Rows one after the other come to the same.
  const Eigen::VectorXd quick_errors = filter_errors(arm.g1, {});
  EXPECT_LT((arm.g1.nominal + quick_errors - run.v).norm(), 1e-9);
}

TEST(AnyRobot, SaysWhatTheDataCannotTell) {
  SpatialArm arm = measured_arm(8);
  // Height is added to z alone: without z, nobody knows it.
  const auto with_z = arm.g1.evaluate;
  arm.g1.evaluate = [with_z](
                        int i, const Eigen::VectorXd& x, Eigen::Ref<Eigen::VectorXd> e,
                        Eigen::MatrixXd* J) {
    const bool reached = with_z(i, x, e, J);
    e[2] = 0.0;
    if (J != nullptr) J->row(2).setZero();
    return reached;
  };
  const SpaceFit fit = fit_space(arm.g1);
  const auto what = identifiability(fit.fit, arm.g1.parameter_names(), arm.g1.samples());
  ASSERT_EQ(what.held.size(), 1U);
  EXPECT_EQ(what.held[0].words, "height alone");
  EXPECT_EQ(fit.v[0], 150.0);
}

TEST(AnyRobot, UncertaintyRestsOnTheNoiseOfItsResiduals) {
  const SpatialArm arm = measured_arm(9);
  const Identified found = identify(*find_identifier("lm"), arm.g1);
  const NoiseEstimate noise = noise_estimate(arm.g1, found.fit);
  EXPECT_EQ(noise.source, NoiseSource::kResidual);
  EXPECT_EQ(noise.degrees_of_freedom, 3 * 80 - 5);
  EXPECT_LT(std::abs(noise.sigma_mm / kNoise_mm - 1.0), 0.2);
  Eigen::MatrixXd covariance;
  const auto estimates =
      estimates_with_noise(arm.g1, found.fit, weighting_of(arm.g1, {}), noise, {}, covariance);
  ASSERT_EQ(estimates.size(), 5U);
  for (std::size_t k = 0; k < 5; ++k) {
    EXPECT_GT(estimates[k].sd, 0.0);
    EXPECT_LT(
        std::abs(estimates[k].value - arm.truth[static_cast<Eigen::Index>(k)]),
        4.5 * estimates[k].sd);
  }
}

TEST(AnyRobot, RowsMayBeWeighedByTheCovarianceOfTheirSample) {
  SpatialArm arm = measured_arm(10);
  SpaceFitSettings settings;
  settings.weighting = Weighting::kByCovariance;
  const SpaceFit alike = fit_space(arm.g1);
  const SpaceFit weighed = fit_space(arm.g1, settings);  // equal covariances: the same
  EXPECT_LT((alike.v - weighed.v).cwiseQuotient(arm.g1.scale()).norm(), 1e-8);
  // A sample that is known to be bad does not pull.
  arm.g1.measured_mm[0] += 1.0;
  arm.g1.covariance_mm2[0] *= 1e8;
  const SpaceFit fit = fit_space(arm.g1, settings);
  EXPECT_LT((fit.v - alike.v).cwiseQuotient(arm.g1.scale()).norm(), 0.01);
}

TEST(ResidualModels, AGridOfTooManyRulesIsRefusedInWords) {
  Eigen::MatrixXd joints(30, 6);
  Eigen::MatrixXd residual(30, 1);
  for (Eigen::Index i = 0; i < joints.rows(); ++i) {
    for (Eigen::Index k = 0; k < 6; ++k) {
      joints(i, k) = std::sin(static_cast<double>((k + 1) * i));
    }
    residual(i, 0) = 0.1 * joints(i, 2);
  }
  ResidualSettings settings;
  settings.anfis.epochs = 3;
  try {
    static_cast<void>(
        train_residual(*find_residual_model("anfis_paper"), joints, residual, settings));
    FAIL() << "6^6 rules were trained";
  } catch (const std::invalid_argument& error) {
    EXPECT_NE(std::string(error.what()).find("fewer inputs"), std::string::npos);
  }
  // Two of the six joints are few enough; the answer then depends on these alone.
  settings.inputs = {2, 4};
  const auto trained =
      train_residual(*find_residual_model("anfis_paper"), joints, residual, settings);
  Eigen::VectorXd at = joints.row(3).transpose();
  const double here = trained.correction(at)[0];
  at[0] += 1.0;
  EXPECT_EQ(trained.correction(at)[0], here);
  settings.inputs = {6};
  EXPECT_THROW(
      static_cast<void>(
          train_residual(*find_residual_model("rbf"), joints, residual, settings)),
      std::invalid_argument);
}

/// The same correction everywhere.
TrainedResidual constant(const Eigen::RowVectorXd& mean) {
  TrainedResidual trained;
  trained.correction = [mean](const Eigen::VectorXd&) {
    return Eigen::VectorXd(mean.transpose());
  };
  trained.effective_parameters = Eigen::VectorXd::Ones(mean.size());
  trained.saved["mean"] = mean;
  return trained;
}

TEST(Tables, TakeRowsAtRunTime) {
  const std::size_t identifiers = all_identifiers().size();
  const std::size_t models = all_residual_models().size();
  static int called;  // the row outlives this test
  called = 0;
  // Both keep the laws of their tables: other tests of this process may meet them.
  const Identifier& again = add_identifier(
      "lm_again", "least squares, called by another name",
      [](const ObservationSpace& space, const IdentifySettings& settings,
         const SearchProgress& progress, const std::stop_token& stop) {
        ++called;
        return find_identifier("lm")->identify(space, settings, progress, stop);
      });
  add_residual_model(
      "mean", "the mean residual, everywhere",
      [](const Eigen::MatrixXd&, const Eigen::MatrixXd& residual_mm, const ResidualSettings&,
         const std::stop_token&) {
        TrainedResidual trained = constant(residual_mm.colwise().mean());
        trained.note = "a constant";
        return trained;
      },
      [](const SavedResidual& saved) { return constant(saved_matrix(saved, "mean", 1, -1)); });
  EXPECT_EQ(all_identifiers().size(), identifiers + 1);
  EXPECT_EQ(all_identifiers().back(), &again);
  EXPECT_EQ(all_residual_models().size(), models + 1);
  EXPECT_EQ(find_identifier("lm_again"), &again);

  const SpatialArm arm = measured_arm(11, kNoise_mm, 0.03);
  const auto compared = compare_methods(
      arm.g1, arm.g1, arm.g2,
      {method_choice("lm").value(), method_choice("lm_again+mean").value()}, quick());
  ASSERT_TRUE(compared) << compared.error().message;
  EXPECT_EQ(called, 1);
  EXPECT_EQ(compared->robots[1].found.x, compared->robots[0].found.x);
  const TrainedResidual& mean = compared->methods[1].residual;
  const Eigen::VectorXd somewhere = arm.g2.joints.col(3);
  EXPECT_LT(
      (mean.correction(somewhere) -
       position_errors(arm.g1, compared->robots[0].found.x).rowwise().mean())
          .norm(),
      1e-12);
  const TrainedResidual loaded = load_residual(*find_residual_model("mean"), mean.saved);
  EXPECT_EQ(loaded.correction(somewhere), mean.correction(somewhere));

  const auto nothing = [](const ObservationSpace&, const IdentifySettings&,
                          const SearchProgress&,
                          const std::stop_token&) -> Identified { return {}; };
  for (const char* name : {"lm_again", "lm", "before", "", "lm+gp"}) {
    EXPECT_THROW(add_identifier(name, "", nothing), std::invalid_argument) << name;
  }
}

}  // namespace
}  // namespace sixdial::calibration
