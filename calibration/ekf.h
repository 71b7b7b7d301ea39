// The extended Kalman filter of equations (17)-(22): a general filter for a constant state, and
// its run over measured positions.
#pragma once

#include <Eigen/Core>
#include <vector>

#include "calibration/observations.h"

namespace sixdial::calibration {

/// State x (n) with covariance P (n x n), symmetric positive definite throughout.
class Ekf {
 public:
  Ekf(Eigen::VectorXd x, Eigen::MatrixXd P);
  /// (17), (18): the state stays, P grows by Q (n x n).
  void predict(const Eigen::MatrixXd& Q);
  /// (20)-(22) in Joseph form. innovation = measured - predicted (m); J = d(predicted)/dx (m x
  /// n); R (m x m). Returns the Kalman gain, n x m.
  Eigen::MatrixXd update(
      const Eigen::VectorXd& innovation, const Eigen::MatrixXd& J, const Eigen::MatrixXd& R);

  [[nodiscard]] const Eigen::VectorXd& x() const { return x_; }
  [[nodiscard]] const Eigen::MatrixXd& P() const { return P_; }

 private:
  Eigen::VectorXd x_;
  Eigen::MatrixXd P_;
};

/// Where f and J are taken.
enum class Linearisation {
  kNominal,   // as printed, (11): a linear filter
  kEstimate,  // at the current estimate: what "extended" means
};

/// Diagonals of Q (10) and R (2) in [mm^2], [rad^2].
struct FilterNoise {
  geometry::ParameterVector q = geometry::ParameterVector::Constant(1e-4);
  Eigen::Vector2d r = Eigen::Vector2d::Constant(1e-4);
};

struct FilterSettings {
  Linearisation linearisation = Linearisation::kEstimate;
  geometry::ParameterVector p0 = geometry::ParameterVector::Ones();  // diagonal of P0
  FilterNoise noise;
};

struct FilterRun {
  geometry::ParameterVector v;  // nominal + estimated errors
  geometry::ParameterMatrix P;
  std::vector<geometry::ParameterVector>
      history;  // estimated errors after each sample (Fig. 9)
  std::vector<geometry::ParameterVector> variance;  // diagonal of P after each sample
  int unreachable = 0;  // samples without a pose at the linearisation point, passed over
};

/// One pass over the samples in order, state = parameter errors from 0.
[[nodiscard]] FilterRun filter_positions(
    const PositionObservations& observations, const geometry::ParameterVector& nominal,
    const FilterSettings& settings = {});

}  // namespace sixdial::calibration
