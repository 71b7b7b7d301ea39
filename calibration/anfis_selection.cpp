#include "calibration/anfis_selection.h"

#include <Eigen/Eigenvalues>
#include <Eigen/QR>
#include <algorithm>
#include <cmath>
#include <utility>

#include "calibration/column_products.h"
#include "calibration/pose_groups.h"

namespace sixdial::calibration {

using Eigen::MatrixXd;
using Eigen::VectorXd;

namespace {

/// Where several rows are one pose: D^-1 v, row by row of the pose, with D = U diag(w) U' (or
/// 1 - that) over its rows.
void solve_poses(
    const std::vector<std::vector<int>>& poses, const MatrixXd& U, const VectorXd& weight,
    bool complement, const VectorXd& v, Eigen::Ref<VectorXd> errors) {
  for (const std::vector<int>& rows : poses) {
    if (rows.size() < 2) continue;
    const MatrixXd part = U(rows, Eigen::all);
    MatrixXd D = part * weight.asDiagonal() * part.transpose();
    if (complement) D = MatrixXd::Identity(D.rows(), D.cols()) - D;
    const VectorXd left = D.completeOrthogonalDecomposition().solve(VectorXd(v(rows)));
    for (std::size_t k = 0; k < rows.size(); ++k) {
      errors[rows[k]] = left[static_cast<Eigen::Index>(k)];
    }
  }
}

}  // namespace

LeaveOneOut LeaveOneOut::of_products(const MatrixXd& products) {
  LeaveOneOut result;
  const Eigen::SelfAdjointEigenSolver<MatrixXd> eigen(products);
  result.vectors_ = eigen.eigenvectors();
  result.values_ = eigen.eigenvalues().cwiseMax(0.0);
  return result;
}

LeaveOneOut::LeaveOneOut(const MatrixXd& A) {
  if (A.rows() <= A.cols()) {
    *this = of_products(A * A.transpose());
    return;
  }
  of_products_ = false;
  const Eigen::SelfAdjointEigenSolver<MatrixXd> eigen(column_products(A));
  vectors_ = A * eigen.eigenvectors();
  values_ = eigen.eigenvalues().cwiseMax(0.0);
}

MatrixXd LeaveOneOut::errors(
    const VectorXd& targets, const std::vector<double>& ridges,
    const std::vector<std::vector<int>>& poses, std::vector<double>& effective) const {
  const auto n = vectors_.rows();
  MatrixXd errors(n, static_cast<Eigen::Index>(ridges.size()));
  effective.clear();
  const VectorXd projected = vectors_.transpose() * targets;
  for (std::size_t k = 0; k < ridges.size(); ++k) {
    const VectorXd weight = (values_.array() + ridges[k]).inverse();
    const VectorXd seen = vectors_ * weight.cwiseProduct(projected);
    const VectorXd diagonal = vectors_.cwiseAbs2() * weight;
    const auto at = static_cast<Eigen::Index>(k);
    if (of_products_) {
      // residual_i without i = alpha_i / M_ii with M = (AA' + ridge I)^-1, alpha = M y
      errors.col(at) = seen.cwiseQuotient(diagonal);
      solve_poses(poses, vectors_, weight, false, seen, errors.col(at));
      effective.push_back(static_cast<double>(n) - ridges[k] * weight.sum());
    } else {
      // residual_i without i = residual_i / (1 - H_ii)
      errors.col(at) = (targets - seen).array() / (1.0 - diagonal.array()).max(1e-12);
      solve_poses(poses, vectors_, weight, true, targets - seen, errors.col(at));
      effective.push_back(values_.cwiseProduct(weight).sum());
    }
  }
  return errors;
}

AnfisSelector::AnfisSelector(
    const MatrixXd& inputs, MembershipKind kind, AnfisSelectionSettings settings)
    : settings_(std::move(settings)), poses_(rows_by_group(pose_groups(inputs))) {
  for (const int functions : settings_.functions) {
    if (!grid_can_be_trained(functions, static_cast<int>(inputs.cols()))) continue;
    const AnfisModel model = initial_anfis(inputs, kind, functions);
    const Eigen::Index columns = static_cast<Eigen::Index>(model.rules()) * (model.inputs + 1);
    grids_.push_back(
        {functions, inputs.rows() <= columns
                        ? LeaveOneOut::of_products(design_products(model, inputs))
                        : LeaveOneOut(design_matrix(model, inputs))});
  }
}

AnfisSelection AnfisSelector::select(const VectorXd& targets) const {
  AnfisSelection result;
  result.as_printed = settings_.as_printed;
  const auto n = static_cast<double>(targets.size());
  result.rmse_without = std::sqrt(targets.squaredNorm() / n);
  result.chosen.loo_rmse = result.rmse_without;
  result.candidates.push_back(result.chosen);
  double best_rmse = result.rmse_without;
  AnfisCandidate best;
  VectorXd best_error = targets;
  for (const Grid& grid : grids_) {
    std::vector<double> ridges = settings_.ridges;
    const bool printed = grid.functions == settings_.as_printed.functions;
    if (printed) ridges.push_back(settings_.as_printed.ridge);
    std::vector<double> effective;
    const MatrixXd errors = grid.without_one.errors(targets, ridges, poses_, effective);
    if (printed) {
      result.as_printed.loo_rmse = std::sqrt(errors.rightCols(1).squaredNorm() / n);
      result.as_printed.effective_parameters = effective.back();
    }
    for (std::size_t k = 0; k < settings_.ridges.size(); ++k) {
      const auto error = errors.col(static_cast<Eigen::Index>(k));
      const double rmse = std::sqrt(error.squaredNorm() / n);
      result.candidates.push_back({grid.functions, settings_.ridges[k], rmse, effective[k]});
      if (rmse < best_rmse) {
        best_rmse = rmse;
        best = result.candidates.back();
        best_error = error;
      }
    }
  }
  if (best.functions == 0) return result;
  // Paired comparison with no network, pose by pose.
  VectorXd gained(std::ssize(poses_));
  for (std::size_t k = 0; k < poses_.size(); ++k) {
    gained[static_cast<Eigen::Index>(k)] =
        targets(poses_[k]).squaredNorm() - best_error(poses_[k]).squaredNorm();
  }
  const double mean = gained.mean();
  const auto m = static_cast<double>(gained.size());
  const double spread = std::sqrt((gained.array() - mean).square().sum() / (m - 1.0) / m);
  result.standard_errors = spread > 0.0 ? mean / spread : 0.0;
  if (result.standard_errors < settings_.required_standard_errors) return result;
  result.chosen = best;
  const VectorXd predicted = targets - best_error;
  result.gain =
      std::clamp(predicted.dot(targets) / std::max(predicted.squaredNorm(), 1e-300), 0.0, 1.0);
  return result;
}

AnfisSelection select_anfis(
    const MatrixXd& inputs, const VectorXd& targets, MembershipKind kind,
    const AnfisSelectionSettings& settings) {
  return AnfisSelector(inputs, kind, settings).select(targets);
}

AnfisModel scaled(AnfisModel model, double gain) {
  model.consequents *= gain;
  model.output_low *= gain;
  model.output_high *= gain;
  return model;
}

}  // namespace sixdial::calibration
