#include "calibration/sandwich.h"

namespace sixdial::calibration {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

/// Weight of each row by the fit's loss.
VectorXd loss_weights(const LeastSquaresFit& fit) {
  const Index rows = fit.residual.size();
  const auto blocks = static_cast<Index>(fit.block_weight.size());
  VectorXd result = VectorXd::Ones(rows);
  if (blocks == 0) return result;
  const Index block = rows / blocks;
  for (Index i = 0; i < rows; ++i) {
    result[i] = fit.block_weight[static_cast<std::size_t>(i / block)];
  }
  return result;
}

/// Covariance of a sample's rows, in any unit.
MatrixXd known_covariance(const ObservationSpace& space, int sample) {
  const auto k = static_cast<std::size_t>(sample);
  const Index rows = space.rows(sample);
  if (k < space.covariance_mm2.size() && space.covariance_mm2[k].rows() == rows) {
    return space.covariance_mm2[k];
  }
  const VectorXd sigma = space.sigma_mm.segment(space.first_row[k], rows);
  return sigma.cwiseAbs2().asDiagonal();
}

}  // namespace

MatrixXd weight_of(const std::vector<MatrixXd>& weights, int sample, Index rows) {
  return weights.empty() ? MatrixXd::Identity(rows, rows)
                         : weights[static_cast<std::size_t>(sample)];
}

Sandwich sandwich_of(
    const ObservationSpace& space, const LeastSquaresFit& fit, Weighting weighting) {
  const MatrixXd unit = fit.unit_covariance();
  const std::vector<MatrixXd> weights = space.weights(weighting);
  const VectorXd loss = loss_weights(fit);
  Sandwich result{{}, MatrixXd::Zero(unit.rows(), unit.cols())};
  double trace = 0.0;
  for (int i = 0; i < space.samples(); ++i) {
    const int first = space.first_row[static_cast<std::size_t>(i)];
    const Index count = space.rows(i);
    const MatrixXd W = weight_of(weights, i, count);
    result.AW.emplace_back(
        unit * fit.J.middleRows(first, count).transpose() *
        loss.segment(first, count).asDiagonal() * W);
    const MatrixXd C = known_covariance(space, i);
    result.noise += result.AW.back() * C * result.AW.back().transpose();
    trace += (W * C * W.transpose()).trace();
  }
  if (trace > 0.0) {
    result.noise *= space.rows() / trace;
  } else {
    result.noise.setZero();
  }
  return result;
}

MatrixXd moved_by(
    const ObservationSpace& space, const Sandwich& sandwich, const Moves& moves,
    const MatrixXd& phi) {
  MatrixXd moved = MatrixXd::Zero(sandwich.noise.rows(), phi.cols() * moves.functions());
  for (int i = 0; i < space.samples(); ++i) {
    const MatrixXd& AW = sandwich.AW[static_cast<std::size_t>(i)];
    for (Index f = 0; f < moves.functions(); ++f) {
      VectorXd by = VectorXd::Zero(AW.rows());
      for (Index row = 0; row < AW.cols(); ++row) by += AW.col(row) * moves.by(i, row, f);
      moved.middleCols(f * phi.cols(), phi.cols()) += by * phi.row(i);
    }
  }
  return moved;
}

std::vector<StructurePart> parts_of(const Structure& structure) {
  if (!structure.parts.empty() || !(structure.sd_mm > 0.0)) return structure.parts;
  return {
      {structure.over, structure.acts, structure.length, structure.sd_mm, structure.noise_mm,
       1.0}};
}

}  // namespace sixdial::calibration
