// The extended Kalman filter of equations (17)-(22): a general filter for a constant state, and
// its run over measured positions.
#pragma once

#include <Eigen/Core>
#include <vector>

#include "calibration/observation_space.h"

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

/// Diagonals of Q (by parameter) and R (by channel) in [mm^2], [rad^2]. An empty one stands for
/// 1e-4 everywhere, the paper's.
struct FilterNoise {
  Eigen::VectorXd q;
  Eigen::VectorXd r;
};

struct FilterSettings {
  Linearisation linearisation = Linearisation::kEstimate;
  Eigen::VectorXd p0;  // diagonal of P0; empty: 1 everywhere
  FilterNoise noise;
};

struct FilterRun {
  Eigen::VectorXd v;  // nominal + estimated errors
  Eigen::MatrixXd P;
  std::vector<Eigen::VectorXd> history;   // estimated errors after each sample (Fig. 9)
  std::vector<Eigen::VectorXd> variance;  // diagonal of P after each sample
  int unreachable = 0;  // samples without a pose at the linearisation point, passed over
};

/// One pass over the samples in order, state = parameter errors from 0.
[[nodiscard]] FilterRun run_filter(
    const ObservationSpace& space, const FilterSettings& settings = {});
/// The same from `start` instead of the nominal parameters.
[[nodiscard]] FilterRun run_filter_from(
    const ObservationSpace& space, const Eigen::VectorXd& start,
    const FilterSettings& settings);

/// Only the result of one pass, for searches that run it thousands of times. Takes the rows of
/// a sample one after the other, which equals (20)-(22) up to rounding. Returns the errors x -
/// nominal after the last sample; NaN where a pose could not be reached. `unit_covariance`:
/// their covariance for readings of mean sigma 1, to first order.
[[nodiscard]] Eigen::VectorXd filter_errors(
    const ObservationSpace& space, const FilterSettings& settings,
    Eigen::MatrixXd* unit_covariance = nullptr);

inline constexpr double kFirstVariance = 1e-4;  // Q and R as the paper starts with them
/// A diagonal of n numbers: `values`, or `otherwise` everywhere if that is empty; 0 for fixed
/// parameters.
[[nodiscard]] Eigen::VectorXd diagonal_of(
    const Eigen::VectorXd& values, Eigen::Index n, double otherwise,
    const std::vector<char>& fixed = {});

}  // namespace sixdial::calibration
