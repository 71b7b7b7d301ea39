// A smooth curve of each joint's own angle, fitted together with the geometry: what a joint's
// value is off by where gears, strain-wave drives or encoders err within a turn.
//
//   q_j (true) = q_j + c_j(q_j),  c_j(q) = sum over waves k of a_k cos(k q) + b_k sin(k q)
//
// Any number of waves; which of them are believed is settled by a prior whose size (joint by
// joint) and smoothness (one for all) are those that make the data most likely (evidence;
// MacKay 1992): a joint without an error of its own gets a curve of size zero. For any robot
// whose tool is measured and whose joints turn; prismatic joints have none. [rad, mm]
#pragma once

#include <Eigen/Core>
#include <optional>
#include <span>
#include <vector>

#include "geometry/rig.h"
#include "simulation/trial.h"

namespace sixdial::calibration {

struct JointCurves {
  int waves = 0;
  Eigen::MatrixXd coefficients;  // joints x 2 waves: cosines, then sines [rad]
  /// c(q), joint by joint [rad]; zero of joints that do not turn.
  [[nodiscard]] Eigen::VectorXd at(const Eigen::VectorXd& q) const;
  /// Root of the mean square of a joint's curve over a whole turn [rad].
  [[nodiscard]] double size_rad(Eigen::Index joint) const;
};

struct JointCurveSettings {
  int waves = 60;
  /// Smoothness is chosen of these: waves beyond 1 / value are hardly believed.
  std::vector<double> smoothness{0.02, 0.05, 0.1, 0.3};
  int rounds = 3;  // of Gauss and Newton
  int evidence_steps = 12;
};

struct JointCurveFit {
  Eigen::VectorXd v;  // the robot's parameters
  JointCurves curves;
  double sigma_mm = 0.0;      // of one coordinate
  double smoothness = 0.0;    // chosen
  Eigen::VectorXd prior_rad;  // by joint: the size that the data ask for
  Eigen::VectorXd told;       // by joint: how many of its coefficients the data tell
  double log_evidence = 0.0;
};

/// From parameters `start` (a fit without curves). Rows that stand out count less. Empty: fewer
/// coordinates than parameters, or poses out of reach.
[[nodiscard]] std::optional<JointCurveFit> fit_joint_curves(
    std::span<const simulation::Trial> trials, const geometry::Rig& rig,
    const Eigen::VectorXd& start, const JointCurveSettings& settings = {});

}  // namespace sixdial::calibration
