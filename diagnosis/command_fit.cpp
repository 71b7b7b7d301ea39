#include "diagnosis/command_fit.h"

#include <Eigen/Dense>
#include <cmath>
#include <numbers>

#include "diagnosis/unnamed.h"

namespace sixdial::diagnosis {

Eigen::MatrixXd error_curves(const Readings& readings) {
  // A constant and four cosines: a curve bends a few times over the range that was read.
  constexpr int kWaves = 5;
  if (!readings.has_dials()) return Eigen::MatrixXd(readings.count(), 0);
  const auto& dials = readings.model().rig().dials;
  Eigen::MatrixXd curves =
      Eigen::MatrixXd::Zero(readings.count(), kWaves * static_cast<Eigen::Index>(dials.size()));
  const Eigen::VectorXd& measured_mm = readings.measured_mm();
  for (std::size_t dial = 0; dial < dials.size(); ++dial) {
    const auto& rows = readings.rows_of_dial(dial);
    if (rows.empty()) continue;
    const Eigen::VectorXd x = measured_mm(rows);
    const double low = x.minCoeff();
    const double range = x.maxCoeff() - low;
    // All waves alike; a cosine's square is a half on average.
    const double sd_mm = dials[dial].accuracy_mm / std::sqrt(3.0);
    const double each_mm = sd_mm / std::sqrt(1.0 + 0.5 * (kWaves - 1));
    for (std::size_t i = 0; i < rows.size(); ++i) {
      const double at = range > 0.0 ? (x[static_cast<Eigen::Index>(i)] - low) / range : 0.0;
      for (int wave = 0; wave < kWaves; ++wave) {
        curves(rows[i], kWaves * static_cast<Eigen::Index>(dial) + wave) =
            each_mm * std::cos(std::numbers::pi * wave * at);
      }
    }
  }
  return curves;
}

Eigen::MatrixXd covariance_with_structure(
    const JointFit& plain, const JointFit& structured, const Eigen::MatrixXd& curves) {
  const Whitening whitening = plain.whitening();
  const Eigen::Index n = plain.J.rows();
  const Eigen::Index p = plain.J.cols();
  const Eigen::Index m = plain.random.cols();
  Eigen::MatrixXd A = Eigen::MatrixXd::Zero(n + m, p + m);
  A.topLeftCorner(n, p) = whitening(plain.J);
  if (m > 0) {
    A.topRightCorner(n, m) = whitening(plain.scaled_random());
    A.bottomRightCorner(m, m).setIdentity();
  }
  // Scaled: millimetres stand beside radians.
  const Eigen::VectorXd scale = A.colwise().norm().transpose().unaryExpr(
      [](double norm) { return norm > 0 ? 1.0 / norm : 0.0; });
  constexpr double kUnseen = 1e-9;
  Eigen::CompleteOrthogonalDecomposition<Eigen::MatrixXd> solver;
  solver.setThreshold(kUnseen);
  solver.compute(A * scale.asDiagonal());
  // Parameters by whitened reading.
  const Eigen::MatrixXd estimate =
      (scale.asDiagonal() * solver.pseudoInverse()).topLeftCorner(p, n);
  const Eigen::MatrixXd smooth = estimate * whitening(structured.scaled_random());
  const Eigen::MatrixXd bent = estimate * whitening(curves);
  const double variance = structured.s_mm * structured.s_mm;
  return variance * (estimate * estimate.transpose() + smooth * smooth.transpose()) +
         bent * bent.transpose();
}

JointFit command_fit(const Readings& readings, const NamedCauses& named) {
  const JointFit& extended = named.extended;
  JointFit fit = named.unknown.empty()
                     ? extended
                     : fit_jointly(
                           readings, extended.model, extended.effects, nullptr,
                           random_columns(readings.count(), named.background));
  const JointFit& structured = named.unknown.empty() ? fit : extended;
  const Eigen::MatrixXd curves = error_curves(readings);
  const Eigen::MatrixXd unnamed = unnamed_columns(readings, fit);
  Eigen::MatrixXd bends(readings.count(), curves.cols() + unnamed.cols());
  bends << curves, unnamed;
  fit.covariance = covariance_with_structure(fit, structured, bends);
  return fit;
}

}  // namespace sixdial::diagnosis
