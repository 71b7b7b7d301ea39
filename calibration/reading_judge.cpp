#include "calibration/reading_judge.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <boost/math/distributions/students_t.hpp>
#include <cmath>

namespace sixdial::calibration {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

constexpr double kLeastSigma_mm = 3e-4;  // rounding of a 0.001 mm display
/// Real structure is not as smooth as the random function that stands for it: so much of it
/// comes from pose to pose.
constexpr double kRoughShare = 0.1;
constexpr double kLeastVisible = 1e-3;

}  // namespace

ReadingJudge::ReadingJudge(const ObservationSpace& space, const LeastSquaresFit& fit)
    : structure_(smooth_structure(space, fit, Weighting::kBySigma)),
      mean_sigma_mm_(space.mean_sigma()),
      x_(fit.x) {
  const Index determined = fit.singular_values.size() - fit.held;
  to_determined_ = fit.scale.asDiagonal() * fit.directions.leftCols(determined);
  MatrixXd shapes(space.samples(), 0);
  if (structure_.sd_mm > 0.0) {
    basis_.emplace(space, structure_.over, structure_.length);
    shapes = (*basis_)(space);
  }
  MatrixXd B(fit.J.rows(), 0);
  for (int i = 0; i < space.samples(); ++i) {
    const Index first = space.first_row[static_cast<std::size_t>(i)];
    const MatrixXd J =
        weights(space, i).cwiseInverse().asDiagonal() * fit.J.middleRows(first, space.rows(i));
    const MatrixXd rows = columns(space, i, J, shapes.row(i));
    if (B.cols() == 0) B.resize(fit.J.rows(), rows.cols());
    B.middleRows(first, space.rows(i)) = rows;
  }
  MatrixXd normal = B.transpose() * B;
  normal.diagonal().tail(B.cols() - determined).array() += 1.0;  // N(0, 1) of each shape
  inverse_ = normal.ldlt().solve(MatrixXd::Identity(normal.rows(), normal.cols()));
  coefficient_ = inverse_ * (B.transpose() * fit.residual);
  // Generalised least squares, as for positions. Each sample's own unknowns cost a degree of
  // freedom as well.
  freedom_ = static_cast<double>(
      fit.residual.size() - determined -
      static_cast<Index>(space.unknowns_per_sample) * space.samples());
  const double left = fit.residual.dot(fit.residual - B * coefficient_);
  if (freedom_ > 0.0) {
    sigma_mm_ = std::max(std::sqrt(std::max(left, 0.0) / freedom_), kLeastSigma_mm);
    rough_ = std::pow(kRoughShare * structure_.sd_mm / sigma_mm_, 2);
  }
}

VectorXd ReadingJudge::weights(const ObservationSpace& space, int sample) const {
  const auto k = static_cast<std::size_t>(sample);
  return mean_sigma_mm_ *
         space.sigma_mm.segment(space.first_row[k], space.rows(sample)).cwiseInverse();
}

MatrixXd ReadingJudge::moves(const ObservationSpace& space, int sample) const {
  if (structure_.acts == SmoothActs::kTool && space.by_tool) return space.by_tool(sample, x_);
  MatrixXd by = MatrixXd::Zero(space.rows(sample), space.channels());
  for (int row = 0; row < space.rows(sample); ++row) {
    const auto at =
        static_cast<std::size_t>(space.first_row[static_cast<std::size_t>(sample)] + row);
    by(row, space.channel[at]) = 1.0;
  }
  return by;
}

MatrixXd ReadingJudge::columns(
    const ObservationSpace& space, int sample, const MatrixXd& J,
    const Eigen::RowVectorXd& shapes) const {
  const VectorXd w = weights(space, sample);
  const Index determined = to_determined_.cols();
  if (shapes.size() == 0) return w.asDiagonal() * J * to_determined_;
  const MatrixXd by = structure_.sd_mm / structure_.noise_mm * moves(space, sample);
  MatrixXd result(J.rows(), determined + by.cols() * shapes.size());
  result.leftCols(determined) = w.asDiagonal() * J * to_determined_;
  for (Index f = 0; f < by.cols(); ++f) {
    result.middleCols(determined + f * shapes.size(), shapes.size()) =
        w.cwiseProduct(by.col(f)) * shapes;
  }
  return result;
}

std::optional<double> ReadingJudge::chance(
    const ObservationSpace& of, const VectorXd& n) const {
  if (!(freedom_ > 0.0) || of.samples() != 1 || n.size() != of.rows()) return std::nullopt;
  VectorXd e(of.rows());
  MatrixXd J(of.rows(), x_.size());
  const double visible = n.squaredNorm();
  if (!(visible > kLeastVisible) || !of.evaluate(0, x_, e, &J)) return std::nullopt;
  Eigen::RowVectorXd shapes(0);
  if (basis_) shapes = (*basis_)(of).row(0);
  const VectorXd w = weights(of, 0);
  const MatrixXd B = columns(of, 0, J, shapes);
  const VectorXd left = w.cwiseProduct(-e) - B * coefficient_;  // predicted - measured
  const Eigen::RowVectorXd b = n.transpose() * B;
  double variance = visible + b.dot(inverse_ * b.transpose());
  if (basis_) {
    // What the shapes do not reach is as uncertain as the structure is large.
    const double unseen = std::max(0.0, 1.0 - shapes.squaredNorm());
    const double times = structure_.sd_mm / structure_.noise_mm;
    const VectorXd moved = moves(of, 0).transpose() * w.cwiseProduct(n);
    variance += (rough_ + times * times * unseen) * moved.squaredNorm();
  }
  const double t = std::abs(n.dot(left)) / (sigma_mm_ * std::sqrt(variance));
  const boost::math::students_t distribution(freedom_);
  return 2.0 * boost::math::cdf(boost::math::complement(distribution, t));
}

}  // namespace sixdial::calibration
