// What the data say about each parameter, and what they cannot tell: uncertainties,
// correlations, singular values of the scaled Jacobian, and by name the directions that were
// held.
#pragma once

#include <Eigen/Core>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "calibration/least_squares.h"
#include "geometry/robot_kind.h"

namespace sixdial::calibration {

inline constexpr double kHighCorrelation = 0.9;
/// Condition number from which on nothing is left of the least singular value but rounding.
inline constexpr double kOpenCondition = 1e10;

struct Correlation {
  int first = 0;  // parameter indices
  int second = 0;
  double coefficient = 0.0;
};

struct HeldDirection {
  Eigen::VectorXd direction;  // unit vector in scaled parameters
  double singular_value = 0.0;
  std::string words;  // "length rises while offset1 and offset2 fall"
};

struct Identifiability {
  Eigen::VectorXd singular_values;  // falling
  double condition = 1.0;           // largest / smallest
  double observability = 0.0;       // (product of singular values)^(1/n) / sqrt(samples)
  std::vector<HeldDirection> held;
  std::vector<Correlation> correlations;  // above kHighCorrelation, strongest first
};

/// `names`: of all parameters of the fit. `samples`: how many were fitted. `known`: directions
/// that the robot's kind has words for.
[[nodiscard]] Identifiability identifiability(
    const LeastSquaresFit& fit, std::span<const std::string_view> names, int samples,
    std::span<const geometry::NamedDirection> known = {});

struct ParameterEstimate {
  std::string name;
  double nominal = 0.0;  // stored units: mm, rad
  double value = 0.0;
  double sd = 0.0;
  double low_95 = 0.0;  // Student's t with the fit's degrees of freedom
  double high_95 = 0.0;
  bool fixed = false;
  /// Part of a direction the data do not determine: the value leans on the nominal one and sd
  /// says nothing about the held part.
  bool partly_held = false;
};

/// Two-sided 95 % quantile of Student's t; the normal one above 1e6 degrees of freedom.
[[nodiscard]] double student_95(int degrees_of_freedom);

[[nodiscard]] std::vector<ParameterEstimate> parameter_estimates(
    const LeastSquaresFit& fit, const Eigen::VectorXd& nominal,
    const Eigen::MatrixXd& covariance, std::span<const std::string_view> names);

}  // namespace sixdial::calibration
