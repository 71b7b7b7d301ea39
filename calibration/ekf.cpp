#include "calibration/ekf.h"

#include <Eigen/Cholesky>
#include <stdexcept>
#include <utility>

namespace sixdial::calibration {

Ekf::Ekf(Eigen::VectorXd x, Eigen::MatrixXd P) : x_(std::move(x)), P_(std::move(P)) {
  if (P_.rows() != x_.size() || P_.cols() != x_.size()) {
    throw std::invalid_argument("Ekf: P must be n x n for a state of n");
  }
}

void Ekf::predict(const Eigen::MatrixXd& Q) { P_ += Q; }

Eigen::MatrixXd Ekf::update(
    const Eigen::VectorXd& innovation, const Eigen::MatrixXd& J, const Eigen::MatrixXd& R) {
  const Eigen::MatrixXd JP = J * P_;
  const Eigen::MatrixXd S = JP * J.transpose() + R;
  const Eigen::MatrixXd K = S.ldlt().solve(JP).transpose();  // (20)
  x_ += K * innovation;                                      // (21)
  // (22) as (I - KJ) P (I - KJ)' + K R K', which rounding cannot make indefinite.
  const Eigen::MatrixXd IKJ = Eigen::MatrixXd::Identity(x_.size(), x_.size()) - K * J;
  P_ = (IKJ * P_ * IKJ.transpose() + K * R * K.transpose()).eval();
  P_ = (0.5 * (P_ + P_.transpose())).eval();
  return K;
}

FilterRun filter_positions(
    const PositionObservations& observations, const geometry::ParameterVector& nominal,
    const FilterSettings& settings) {
  Ekf filter(
      geometry::ParameterVector::Zero(), geometry::ParameterMatrix(settings.p0.asDiagonal()));
  const Eigen::MatrixXd Q = settings.noise.q.asDiagonal();
  const Eigen::MatrixXd R = settings.noise.r.asDiagonal();
  FilterRun run;
  for (int i = 0; i < observations.size(); ++i) {
    filter.predict(Q);
    const geometry::ParameterVector x = filter.x();
    const bool linear = settings.linearisation == Linearisation::kNominal;
    const auto d = geometry::forward_derivative(
        linear ? nominal : geometry::ParameterVector(nominal + x), observations.q_rad.col(i),
        observations.assembly[static_cast<std::size_t>(i)]);
    if (d) {
      Eigen::Vector2d innovation = observations.p_WE.col(i) - d->pose.p_WE;
      if (linear) innovation -= d->J_v * x;
      filter.update(innovation, d->J_v, R);
    } else {
      ++run.unreachable;
    }
    run.history.emplace_back(filter.x());
    run.variance.emplace_back(filter.P().diagonal());
  }
  run.v = nominal + geometry::ParameterVector(filter.x());
  run.P = filter.P();
  return run;
}

}  // namespace sixdial::calibration
