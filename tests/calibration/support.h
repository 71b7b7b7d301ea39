// Simulated and measured sessions for the calibration tests.
#pragma once

#include <cstdint>
#include <functional>
#include <initializer_list>
#include <stop_token>
#include <string>
#include <utility>
#include <vector>

#include "calibration/comparison.h"
#include "calibration/five_bar/spaces.h"
#include "calibration/pipeline.h"
#include "calibration/rig_spaces.h"
#include "calibration/space_fit.h"
#include "geometry/rig.h"
#include "geometry/tool.h"

namespace sixdial::calibration::testing {

struct Rectangle {
  double x_low_mm, x_high_mm, y_low_mm, y_high_mm;
};
inline constexpr Rectangle kDefaultWorkspace{16, 40, 30, 66};
inline constexpr Rectangle kTable6Workspace{30, 40, 25, 65};

struct SessionPlan {
  geometry::WorkingMode mode{+1, +1};
  Rectangle workspace = kDefaultWorkspace;
  int g1_points = 100;
  int g2_points = 50;
  double noise_mm = 0.003;     // standard deviation of each axis
  double non_kinematic = 0.0;  // 1: gear eccentricity and compliance as peers/calibration make
  geometry::ParameterVector nominal = geometry::default_rig().robot.nominal;
  geometry::ParameterVector robot = geometry::table_2_robot();
};

struct SimulatedSession {
  geometry::ParameterVector nominal, robot;
  PositionObservations g1, g2;
};

/// Targets stratified over the workspace, commanded by nominal inverse kinematics.
[[nodiscard]] SimulatedSession simulate(const SessionPlan& plan, std::uint64_t seed);

/// The same plan measured by the dials of the default rig: noise on each reading, and a clamp
/// angle that nobody knows. Positions are those of the best active three.
struct DialSession {
  geometry::Rig rig;
  geometry::ParameterVector robot;
  double clamp_rad = 0.0;
  std::vector<simulation::Trial> g1, g2;
};
[[nodiscard]] DialSession simulate_dials(
    const SessionPlan& plan, std::uint64_t seed,
    geometry::Mount mount = geometry::Mount::kDistal2);

/// A robot near nominal: lengths within 0.5 mm, frame within 1 mm, angles within 1 degree.
[[nodiscard]] geometry::ParameterVector random_robot(
    const geometry::ParameterVector& nominal, std::uint64_t seed);

/// A rectangle that each working mode reaches with the default nominal robot, away from
/// singularities.
[[nodiscard]] Rectangle workspace_of(geometry::WorkingMode mode);

/// tests/data/session_00 with positions of the best active three.
struct MeasuredSession {
  geometry::ParameterVector nominal, robot;
  PositionObservations g1, g2;
};
[[nodiscard]] MeasuredSession measured_session_00();

/// A list that holds these parameters of the five-bar's ten at nominal.
[[nodiscard]] std::vector<char> fixed(std::initializer_list<int> parameters);

}  // namespace sixdial::calibration::testing

// The methods on measured positions of a five-bar: each makes the space.
namespace sixdial::calibration {

[[nodiscard]] inline FilterRun filter_positions(
    const PositionObservations& set, const geometry::ParameterVector& nominal,
    const FilterSettings& settings = {}) {
  return run_filter(position_space(set, nominal), settings);
}
[[nodiscard]] inline SpaceFit fit_positions(
    const PositionObservations& set, const geometry::ParameterVector& nominal,
    const SpaceFitSettings& settings = {}) {
  return fit_space(position_space(set, nominal), settings);
}
[[nodiscard]] inline SpaceFit assess_positions(
    const PositionObservations& set, const geometry::ParameterVector& nominal,
    const geometry::ParameterVector& v) {
  return assess_space(position_space(set, nominal), v);
}
[[nodiscard]] inline Eigen::Matrix2Xd position_residuals(
    const PositionObservations& set, const geometry::ParameterVector& v) {
  return position_errors(position_space(set, v), v);
}
[[nodiscard]] inline double position_rmse(
    const PositionObservations& set, const geometry::ParameterVector& v) {
  return position_rmse(position_space(set, v), v);
}
[[nodiscard]] inline LeastSquaresProblem position_problem(const PositionObservations& set) {
  return position_space(set, geometry::table_2_robot()).problem(Weighting::kAlike);
}
[[nodiscard]] inline tl::expected<Result, Trouble> run_dqpso_anfis(
    const PositionObservations& g1, const PositionObservations& g2,
    const geometry::ParameterVector& nominal, const PipelineSettings& settings = {},
    const PipelineProgressCallback& progress = {}, std::stop_token stop = {}) {
  return run_dqpso_anfis(
      position_space(g1, nominal), position_space(g2, nominal), settings, progress,
      std::move(stop));
}
[[nodiscard]] inline tl::expected<Comparison, Trouble> compare_methods(
    const ObservationSpace& space, const PositionObservations& g1,
    const PositionObservations& g2, const geometry::ParameterVector& nominal,
    const std::vector<MethodChoice>& methods, const ComparisonSettings& settings = {},
    const std::function<void(const ComparisonProgress&)>& progress = {},
    const std::stop_token& stop = {}) {
  return compare_methods(
      space, position_space(g1, nominal), position_space(g2, nominal), methods, settings,
      progress, stop);
}

}  // namespace sixdial::calibration
