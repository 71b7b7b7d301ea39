#include "diagnosis/command_fit.h"

#include <Eigen/Dense>
#include <cmath>
#include <numbers>

#include "diagnosis/eliminated.h"
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
  const Eigen::Index p = plain.J.cols();
  const Eigen::Index m = plain.random.cols();
  Eigen::MatrixXd A(plain.J.rows(), p + m);
  A.leftCols(p) = whitening(plain.J);
  A.rightCols(m) = whitening(plain.scaled_random());
  // Scaled: millimetres stand beside radians. The prior of each u is a row with a one.
  Eigen::VectorXd squares = A.colwise().squaredNorm();
  squares.tail(m).array() += 1.0;
  const Eigen::VectorXd scale =
      squares.unaryExpr([](double each) { return each > 0 ? 1.0 / std::sqrt(each) : 0.0; });
  A *= scale.asDiagonal();
  Eigen::MatrixXd normal = gram(A);
  normal.diagonal().tail(m) += scale.tail(m).cwiseAbs2();
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> eigen(normal);
  constexpr double kUnseen = 1e-13;  // of the largest: rounding
  const Eigen::VectorXd inverse = eigen.eigenvalues().unaryExpr([&](double each) {
    return each > kUnseen * eigen.eigenvalues().maxCoeff() ? 1.0 / each : 0.0;
  });
  // Parameters by A'(whitened readings): the readings themselves are too many to be columns.
  const Eigen::MatrixXd estimate = scale.head(p).asDiagonal() *
                                   eigen.eigenvectors().topRows(p) * inverse.asDiagonal() *
                                   eigen.eigenvectors().transpose();
  const auto bent_by = [&](const Eigen::MatrixXd& columns) -> Eigen::MatrixXd {
    const Eigen::MatrixXd seen = A.transpose() * whitening(columns);
    return estimate * seen;
  };
  const Eigen::MatrixXd smooth = bent_by(structured.scaled_random());
  const Eigen::MatrixXd bent = bent_by(curves);
  const double variance = structured.s_mm * structured.s_mm;
  return variance * (estimate * gram(A) * estimate.transpose() + smooth * smooth.transpose()) +
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
