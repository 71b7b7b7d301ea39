#include "diagnosis/command_fit.h"

#include <Eigen/Dense>

namespace sixdial::diagnosis {

Eigen::MatrixXd covariance_with_structure(const JointFit& plain, const JointFit& structured) {
  const Whitening whitening = plain.whitening();
  const Eigen::Index n = plain.J.rows();
  const Eigen::Index p = plain.J.cols();
  const Eigen::Index m = plain.random.cols();
  Eigen::MatrixXd A = Eigen::MatrixXd::Zero(n + m, p + m);
  A.topLeftCorner(n, p) = whitening(plain.J);
  if (m > 0) {
    A.topRightCorner(n, m) = whitening(plain.random);
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
  const Eigen::MatrixXd smooth = estimate * whitening(structured.random);
  const double variance = structured.s_mm * structured.s_mm;
  return variance * (estimate * estimate.transpose() + smooth * smooth.transpose());
}

JointFit command_fit(const Readings& readings, const NamedCauses& named) {
  if (named.unknown.empty()) return named.extended;
  JointFit fit = fit_jointly(readings, named.extended.model, named.extended.effects);
  fit.covariance = covariance_with_structure(fit, named.extended);
  return fit;
}

}  // namespace sixdial::diagnosis
