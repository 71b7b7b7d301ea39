#include "calibration/ekf.h"

#include <Eigen/Cholesky>
#include <limits>
#include <stdexcept>
#include <utility>

#include "geometry/long_work.h"

namespace sixdial::calibration {
namespace {

constexpr int kLookEvery = 256;  // samples, whether the work is to end

using Eigen::MatrixXd;
using Eigen::VectorXd;

int channel_of(const ObservationSpace& space, int sample, int row) {
  const int first = space.first_row[static_cast<std::size_t>(sample)];
  return space.channel[static_cast<std::size_t>(first + row)];
}

}  // namespace

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

Eigen::VectorXd diagonal_of(
    const Eigen::VectorXd& values, Eigen::Index n, double otherwise,
    const std::vector<char>& fixed) {
  Eigen::VectorXd result = values.size() > 0 ? values : Eigen::VectorXd::Constant(n, otherwise);
  if (result.size() != n) {
    throw std::invalid_argument("filter: one value for each parameter or channel is needed");
  }
  for (Eigen::Index i = 0; i < n; ++i) {
    if (is_fixed(fixed, static_cast<int>(i))) result[i] = 0.0;
  }
  return result;
}

FilterRun run_filter(const ObservationSpace& space, const FilterSettings& settings) {
  return run_filter_from(space, space.nominal, settings);
}

FilterRun run_filter_from(
    const ObservationSpace& space, const Eigen::VectorXd& start,
    const FilterSettings& settings) {
  const int n = space.parameters();
  const Eigen::VectorXd p0 = diagonal_of(settings.p0, n, 1.0);
  const Eigen::VectorXd r = diagonal_of(settings.noise.r, space.channels(), kFirstVariance);
  Ekf filter(Eigen::VectorXd::Zero(n), Eigen::MatrixXd(p0.asDiagonal()));
  const Eigen::MatrixXd Q = diagonal_of(settings.noise.q, n, kFirstVariance).asDiagonal();
  const bool linear = settings.linearisation == Linearisation::kNominal;
  FilterRun run;
  for (int i = 0; i < space.samples(); ++i) {
    if (i % kLookEvery == 0) geometry::check_end();
    filter.predict(Q);
    const Eigen::VectorXd x = filter.x();
    const int rows = space.rows(i);
    Eigen::VectorXd innovation(rows);
    Eigen::MatrixXd J(rows, n);
    if (space.evaluate(i, linear ? start : Eigen::VectorXd(start + x), innovation, &J)) {
      if (linear) innovation -= J * x;
      Eigen::MatrixXd R = Eigen::MatrixXd::Zero(rows, rows);
      for (int row = 0; row < rows; ++row) R(row, row) = r[channel_of(space, i, row)];
      filter.update(innovation, J, R);
    } else {
      ++run.unreachable;
    }
    run.history.emplace_back(filter.x());
    run.variance.emplace_back(filter.P().diagonal());
  }
  run.v = start + filter.x();
  run.P = filter.P();
  return run;
}

VectorXd filter_errors(
    const ObservationSpace& space, const FilterSettings& settings, MatrixXd* unit_covariance) {
  const int n = space.parameters();
  const VectorXd q = diagonal_of(settings.noise.q, n, kFirstVariance);
  const VectorXd r = diagonal_of(settings.noise.r, space.channels(), kFirstVariance);
  const bool linear = settings.linearisation == Linearisation::kNominal;
  const double mean_sigma = space.mean_sigma();
  if (unit_covariance != nullptr) unit_covariance->setZero(n, n);
  VectorXd x = VectorXd::Zero(n);
  MatrixXd P = diagonal_of(settings.p0, n, 1.0).asDiagonal();
  VectorXd e;
  MatrixXd J;
  for (int i = 0; i < space.samples(); ++i) {
    if (i % kLookEvery == 0) geometry::check_end();
    P.diagonal() += q;
    const int rows = space.rows(i);
    e.resize(rows);
    J.resize(rows, n);
    const VectorXd at = linear ? space.nominal : VectorXd(space.nominal + x);
    if (!space.evaluate(i, at, e, &J)) {
      return VectorXd::Constant(n, std::numeric_limits<double>::quiet_NaN());
    }
    const VectorXd origin = linear ? VectorXd::Zero(n) : x;
    for (int row = 0; row < rows; ++row) {
      // Independent rows one at a time: equal to (20)-(22), without an inverse.
      const VectorXd h = J.row(row);
      const VectorXd Ph = P * h;
      const VectorXd K = Ph / (h.dot(Ph) + r[channel_of(space, i, row)]);
      x += K * (e[row] - h.dot(x - origin));
      P -= K * Ph.transpose();
      if (unit_covariance != nullptr) {
        // Whatever P says: x passes on its own errors less what the gain takes, and adds the
        // reading's.
        MatrixXd& C = *unit_covariance;
        const double sigma =
            space.sigma_mm[space.first_row[static_cast<std::size_t>(i)] + row] / mean_sigma;
        C -= K * (h.transpose() * C);
        C -= (C * h) * K.transpose();
        C += (sigma * sigma) * K * K.transpose();
      }
    }
    P = (0.5 * (P + P.transpose())).eval();
  }
  return x;
}

}  // namespace sixdial::calibration
