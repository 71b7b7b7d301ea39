// The mock rig's own sessions through bundle, trials and calibration; Ceres is the judge of the
// least-squares minimum.
#include <ceres/ceres.h>
#include <gtest/gtest.h>

#include <cmath>
#include <string>
#include <vector>

#include "calibration/five_bar/spaces.h"
#include "calibration/pipeline.h"
#include "mock_devices/session_generator.h"
#include "session/bundle.h"
#include "session/trials.h"

namespace sixdial {
namespace {

constexpr double kAtMinimum_mm = 1e-5;  // issue: DQPSO against the least-squares minimum
constexpr double kNoHarm = 1.05;        // issue: at most 5 % worse where nothing is to learn

struct Measured {
  geometry::Rig rig;
  calibration::PositionObservations g1, g2;
  [[nodiscard]] calibration::ObservationSpace g1_space() const {
    return calibration::position_space(g1, rig.robot.nominal);
  }
  [[nodiscard]] calibration::ObservationSpace g2_space() const {
    return calibration::position_space(g2, rig.robot.nominal);
  }
};

Measured mock_session(std::uint64_t seed, double warp_mm, bool table_2) {
  mock_devices::World world;
  world.seed = seed;
  world.robot = mock_devices::drawn_robot(world.rig, seed);
  if (table_2) world.robot.parameters = geometry::table_2_robot();
  world.dials.curve_mm = 0.0;
  world.dials.hysteresis_mm = 0.0;
  world.warp.amplitude_mm = warp_mm;
  const auto rows =
      mock_devices::generate_session(world, mock_devices::random_plan(world.rig, seed));
  const auto session = session::parse_session(
      mock_devices::session_csv(rows, world.rig, "2026-03-02T08:30:00.000Z"), "session.csv",
      mock_devices::rig_toml(world.rig), "rig.toml");
  return {
      session.rig, calibration::position_observations(session::trials_of(session, "G1")),
      calibration::position_observations(session::trials_of(session, "G2"))};
}

/// RMSE [mm] that Ceres reaches from the nominal parameters, by differences of f alone.
double ceres_minimum_mm(const Measured& measured) {
  struct Residual {
    const Measured* measured;
    Eigen::Index i;
    bool operator()(const double* v, double* residual) const {
      const geometry::ParameterVector parameters(v);
      const auto pose = geometry::forward(
          parameters, measured->g1.q_rad.col(i),
          measured->g1.assembly[static_cast<std::size_t>(i)]);
      if (!pose) return false;
      const Eigen::Vector2d e = measured->g1.p_WE.col(i) - pose->p_WE;
      residual[0] = e.x();
      residual[1] = e.y();
      return true;
    }
  };
  geometry::ParameterVector v = measured.rig.robot.nominal;
  ceres::Problem problem;
  for (Eigen::Index i = 0; i < measured.g1.size(); ++i) {
    problem.AddResidualBlock(
        new ceres::NumericDiffCostFunction<Residual, ceres::CENTRAL, 2, 10>(
            new Residual{&measured, i}),
        nullptr, v.data());
  }
  ceres::Solver::Options options;
  options.linear_solver_type = ceres::DENSE_QR;
  options.function_tolerance = 1e-16;
  options.parameter_tolerance = 1e-14;
  options.max_num_iterations = 200;
  options.logging_type = ceres::SILENT;
  ceres::Solver::Summary summary;
  ceres::Solve(options, &problem, &summary);
  return std::sqrt(2 * summary.final_cost / measured.g1.size());
}

double g2_mean(const calibration::Result& result, const std::string& method) {
  return result.errors(method).g2.mean_mm;
}

TEST(MockSession, DqpsoReachesTheLeastSquaresMinimumThatCeresFinds) {
  for (const std::uint64_t seed : {11U, 12U, 13U}) {
    const Measured measured = mock_session(seed, 0.0, seed == 11);
    const auto result = calibration::run_dqpso_anfis(measured.g1_space(), measured.g2_space());
    ASSERT_TRUE(result) << result.error().message;
    const double reached = result->stage("ekf_dqpso").rmse_g1_mm;
    EXPECT_LT(std::abs(reached - ceres_minimum_mm(measured)), kAtMinimum_mm) << "seed " << seed;
  }
}

TEST(MockSession, AnfisImprovesG2WhereASmoothErrorIsThere) {
  for (const std::uint64_t seed : {21U, 22U, 23U, 24U}) {
    const Measured measured = mock_session(seed, 0.03, false);
    const auto result = calibration::run_dqpso_anfis(measured.g1_space(), measured.g2_space());
    ASSERT_TRUE(result) << result.error().message;
    EXPECT_LT(g2_mean(*result, "ekf_dqpso+anfis"), 0.8 * g2_mean(*result, "ekf_dqpso"))
        << "seed " << seed;
  }
}

TEST(MockSession, AnfisDoesNoHarmWhereNothingIsToLearn) {
  for (std::uint64_t seed = 31; seed < 47; ++seed) {
    const Measured measured = mock_session(seed, 0.0, false);
    const auto result = calibration::run_dqpso_anfis(measured.g1_space(), measured.g2_space());
    ASSERT_TRUE(result) << result.error().message;
    EXPECT_LT(g2_mean(*result, "ekf_dqpso+anfis"), kNoHarm * g2_mean(*result, "ekf_dqpso"))
        << "seed " << seed;
  }
}

}  // namespace
}  // namespace sixdial
