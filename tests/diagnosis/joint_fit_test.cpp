// The fit of robot and effects together: at the optimum, by an independent optimiser's word.
#include "diagnosis/joint_fit.h"

#include <ceres/ceres.h>
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <ostream>
#include <string>
#include <vector>

#include "diagnosis/thresholds.h"
#include "tests/diagnosis/made_session.h"

namespace sixdial::diagnosis {
namespace {

using simulation::ActiveEffect;

struct Case {
  std::string cause, where;
  double times;  // of the plausible size
  friend void PrintTo(const Case& each, std::ostream* out) {
    *out << each.cause << "@" << each.where << " x " << each.times;
  }
};

std::vector<Case> all_cases() {
  std::vector<Case> cases;
  const geometry::Rig rig = geometry::default_rig();
  for (const simulation::Effect* effect : simulation::all_effects()) {
    if (effect->exchanges_dials) continue;
    for (const simulation::Place& place : effect->places(rig)) {
      cases.push_back({std::string(effect->cause), place.name, 2.0});
    }
  }
  // Nearly absorbed by the parameters: a wrong ratio of one to two per cent.
  cases.push_back({"joint_gain", "joint1", 6.0});
  cases.push_back({"joint_gain", "joint2", 6.0});
  return cases;
}

/// Minus the log likelihood of joint_fit.h, at its scale and share of gross errors, as a sum of
/// squares, for a solver that takes its derivatives by differences of the whole simulation.
class Likelihood {
 public:
  Likelihood(const Readings& readings, const JointFit& fit) : readings_(readings), fit_(fit) {
    for (const ActiveEffect& active : fit.effects) fitted_ += fitted_count(*active.effect);
  }
  [[nodiscard]] int count() const { return static_cast<int>(fit_.model.size()) + fitted_; }

  /// z = 1 at the fit, one more for a plausible change of a parameter.
  void place(
      const double* z, simulation::ModelVector& model,
      std::vector<ActiveEffect>& effects) const {
    model = fit_.model;
    effects = fit_.effects;
    for (Eigen::Index k = 0; k < model.size(); ++k) {
      model[k] +=
          (*z++ - 1) * readings_.model().parameters()[static_cast<std::size_t>(k)].change;
    }
    for (ActiveEffect& active : effects) {
      for (int i = 0; i < fitted_count(*active.effect); ++i) {
        const auto k = static_cast<std::size_t>(i);
        active.x[k] += (*z++ - 1) * active.effect->parameters[k].sigma;
      }
    }
  }

  bool operator()(double const* const* z, double* residual) const {
    simulation::ModelVector model;
    std::vector<ActiveEffect> effects;
    place(z[0], model, effects);
    const Eigen::VectorXd e =
        readings_.measured_mm() -
        readings_.simulate(model, simulation::ExtendedModel(readings_.model(), effects));
    if (!e.allFinite()) return false;
    for (Eigen::Index i = 0; i < e.size(); ++i) {
      const double s_mm = fit_.s_mm * fit_.noise[i];
      const double top = std::log(mixture(0.0, s_mm));
      const double rho = -2 * (std::log(mixture(e[i] / s_mm, s_mm)) - top);
      residual[i] = std::copysign(std::sqrt(std::max(0.0, rho)), e[i]);
    }
    return true;
  }

 private:
  [[nodiscard]] double mixture(double z, double s_mm) const {
    const double good = std::exp(-0.5 * z * z) / (s_mm * std::sqrt(2 * std::numbers::pi));
    return (1 - fit_.gross_share) * good + fit_.gross_share / kGrossRange_mm;
  }
  const Readings& readings_;
  const JointFit& fit_;
  int fitted_ = 0;
};

/// Minus the log likelihood at the optimum that Ceres finds from z.
double by_ceres(const Readings& readings, const JointFit& fit, std::vector<double> z) {
  auto* likelihood = new Likelihood(readings, fit);
  ceres::NumericDiffOptions how;
  how.relative_step_size = 1e-4;
  auto* cost = new ceres::DynamicNumericDiffCostFunction<Likelihood, ceres::CENTRAL>(
      likelihood, ceres::TAKE_OWNERSHIP, how);
  cost->AddParameterBlock(likelihood->count());
  cost->SetNumResiduals(static_cast<int>(readings.count()));
  ceres::Problem problem;
  problem.AddResidualBlock(cost, nullptr, z.data());
  ceres::Solver::Options options;
  options.linear_solver_type = ceres::DENSE_QR;
  options.max_num_iterations = 200;
  options.function_tolerance = 1e-10;
  options.parameter_tolerance = 1e-12;
  options.logging_type = ceres::SILENT;
  ceres::Solver::Summary summary;
  ceres::Solve(options, &problem, &summary);
  EXPECT_TRUE(summary.IsSolutionUsable()) << summary.BriefReport();
  return summary.final_cost;
}

class EveryEffectsFit : public testing::TestWithParam<Case> {};

TEST_P(EveryEffectsFit, IsAtTheOptimumOfAnIndependentOptimiser) {
  const Case& each = GetParam();
  const geometry::Rig rig = geometry::default_rig();
  ActiveEffect truth = effect_of(rig, each.cause.c_str(), each.where.c_str(), {});
  const simulation::Effect& effect = *truth.effect;
  for (std::size_t k = 0; k < effect.parameters.size(); ++k) {
    const auto here = simulation::parameter_at(effect, truth.place, static_cast<int>(k));
    truth.x.push_back(here ? each.times * here->sigma : 0.0);
  }
  if (effect.is_step) truth.x.back() = 60;
  const Session session = session_of({.effects = {truth}, .points = 100, .seed = 31});
  Readings readings(session.model, session.trials);
  readings.place_tool(session.truth);
  // As a search starts it: from the plain robot, at no size.
  const JointFit baseline = fit_jointly(readings, session.model.nominal(), {});
  EXPECT_TRUE(baseline.converged);
  ActiveEffect start = truth;
  for (int i = 0; i < linear_count(effect); ++i) start.x[static_cast<std::size_t>(i)] = 0.0;
  const JointFit fit = fit_jointly(readings, baseline.model, {start}, &baseline);
  ASSERT_TRUE(fit.converged);

  const Likelihood here(readings, fit);
  const std::vector<double> at_fit(static_cast<std::size_t>(here.count()), 1.0);
  std::vector<double> residual(static_cast<std::size_t>(readings.count()));
  const double* z = at_fit.data();
  ASSERT_TRUE(here(&z, residual.data()));
  double ours = 0.0;
  for (const double r : residual) ours += 0.5 * r * r;

  std::vector<double> at_truth = at_fit;
  for (Eigen::Index k = 0; k < fit.model.size(); ++k) {
    const auto i = static_cast<std::size_t>(k);
    at_truth[i] += (session.truth[k] - fit.model[k]) / session.model.parameters()[i].change;
  }
  for (int i = 0; i < fitted_count(effect); ++i) {
    const auto k = static_cast<std::size_t>(i);
    at_truth[static_cast<std::size_t>(fit.model.size()) + k] +=
        (truth.x[k] - fit.effects[0].x[k]) / effect.parameters[k].sigma;
  }
  // Of the log likelihood: a seventh of a standard deviation of one parameter.
  constexpr double kAsGood = 0.01;
  EXPECT_LT(ours - by_ceres(readings, fit, at_fit), kAsGood);
  EXPECT_LT(ours - by_ceres(readings, fit, at_truth), kAsGood);
  // And the size is what it says it is.
  for (int i = 0; i < linear_count(effect); ++i) {
    const auto k = static_cast<std::size_t>(i);
    const Eigen::Index column = fit.model.size() + i;
    if (fit.J.col(column).squaredNorm() <= 0) continue;
    const double sd = std::sqrt(fit.covariance(column, column));
    EXPECT_LT(std::abs(fit.effects[0].x[k] - truth.x[k]), 4.5 * sd) << k;
  }
}

INSTANTIATE_TEST_SUITE_P(
    , EveryEffectsFit, testing::ValuesIn(all_cases()), [](const auto& each) {
      return each.param.cause + "_" + each.param.where + (each.param.times > 2 ? "_large" : "");
    });

}  // namespace
}  // namespace sixdial::diagnosis
