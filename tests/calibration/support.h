// Simulated and measured sessions for the calibration tests.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "calibration/five_bar/positions.h"
#include "geometry/rig.h"

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

}  // namespace sixdial::calibration::testing
