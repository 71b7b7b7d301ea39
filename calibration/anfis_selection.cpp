#include "calibration/anfis_selection.h"

#include <Eigen/Eigenvalues>
#include <Eigen/QR>
#include <algorithm>
#include <cmath>

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

MatrixXd leave_one_out_errors(
    const MatrixXd& A, const VectorXd& targets, const std::vector<double>& ridges,
    const std::vector<std::vector<int>>& poses, std::vector<double>& effective) {
  const auto n = A.rows();
  MatrixXd errors(n, static_cast<Eigen::Index>(ridges.size()));
  effective.clear();
  if (n <= A.cols()) {
    // residual_i without i = alpha_i / M_ii with M = (AA' + ridge I)^-1, alpha = M y
    const Eigen::SelfAdjointEigenSolver<MatrixXd> eigen(A * A.transpose());
    const MatrixXd& U = eigen.eigenvectors();
    const VectorXd projected = U.transpose() * targets;
    for (std::size_t k = 0; k < ridges.size(); ++k) {
      const VectorXd weight = (eigen.eigenvalues().cwiseMax(0.0).array() + ridges[k]).inverse();
      const VectorXd alpha = U * weight.cwiseProduct(projected);
      const VectorXd diagonal = U.cwiseAbs2() * weight;
      const auto at = static_cast<Eigen::Index>(k);
      errors.col(at) = alpha.cwiseQuotient(diagonal);
      solve_poses(poses, U, weight, false, alpha, errors.col(at));
      effective.push_back(static_cast<double>(n) - ridges[k] * weight.sum());
    }
    return errors;
  }
  // residual_i without i = residual_i / (1 - H_ii)
  const Eigen::SelfAdjointEigenSolver<MatrixXd> eigen(A.transpose() * A);
  const MatrixXd B = A * eigen.eigenvectors();
  const VectorXd projected = B.transpose() * targets;
  for (std::size_t k = 0; k < ridges.size(); ++k) {
    const VectorXd values = eigen.eigenvalues().cwiseMax(0.0);
    const VectorXd weight = (values.array() + ridges[k]).inverse();
    const VectorXd fitted = B * weight.cwiseProduct(projected);
    const VectorXd hat = B.cwiseAbs2() * weight;
    const auto at = static_cast<Eigen::Index>(k);
    errors.col(at) = (targets - fitted).array() / (1.0 - hat.array()).max(1e-12);
    solve_poses(poses, B, weight, true, targets - fitted, errors.col(at));
    effective.push_back(values.cwiseProduct(weight).sum());
  }
  return errors;
}

AnfisSelection select_anfis(
    const MatrixXd& inputs, const VectorXd& targets, MembershipKind kind,
    const AnfisSelectionSettings& settings) {
  AnfisSelection result;
  result.as_printed = settings.as_printed;
  const auto n = static_cast<double>(targets.size());
  result.rmse_without = std::sqrt(targets.squaredNorm() / n);
  result.chosen.loo_rmse = result.rmse_without;
  result.candidates.push_back(result.chosen);
  const std::vector<std::vector<int>> poses = rows_by_group(pose_groups(inputs));
  double best_rmse = result.rmse_without;
  AnfisCandidate best;
  VectorXd best_error = targets;
  for (const int functions : settings.functions) {
    if (!grid_can_be_trained(functions, static_cast<int>(inputs.cols()))) continue;
    const AnfisModel model = initial_anfis(inputs, kind, functions);
    std::vector<double> ridges = settings.ridges;
    const bool printed = functions == settings.as_printed.functions;
    if (printed) ridges.push_back(settings.as_printed.ridge);
    std::vector<double> effective;
    const MatrixXd errors =
        leave_one_out_errors(design_matrix(model, inputs), targets, ridges, poses, effective);
    if (printed) {
      result.as_printed.loo_rmse = std::sqrt(errors.rightCols(1).squaredNorm() / n);
      result.as_printed.effective_parameters = effective.back();
    }
    for (std::size_t k = 0; k < settings.ridges.size(); ++k) {
      const auto error = errors.col(static_cast<Eigen::Index>(k));
      const double rmse = std::sqrt(error.squaredNorm() / n);
      result.candidates.push_back({functions, settings.ridges[k], rmse, effective[k]});
      if (rmse < best_rmse) {
        best_rmse = rmse;
        best = result.candidates.back();
        best_error = error;
      }
    }
  }
  if (best.functions == 0) return result;
  // Paired comparison with no network, pose by pose.
  VectorXd gained(std::ssize(poses));
  for (std::size_t k = 0; k < poses.size(); ++k) {
    gained[static_cast<Eigen::Index>(k)] =
        targets(poses[k]).squaredNorm() - best_error(poses[k]).squaredNorm();
  }
  const double mean = gained.mean();
  const auto m = static_cast<double>(gained.size());
  const double spread = std::sqrt((gained.array() - mean).square().sum() / (m - 1.0) / m);
  result.standard_errors = spread > 0.0 ? mean / spread : 0.0;
  if (result.standard_errors < settings.required_standard_errors) return result;
  result.chosen = best;
  const VectorXd predicted = targets - best_error;
  result.gain =
      std::clamp(predicted.dot(targets) / std::max(predicted.squaredNorm(), 1e-300), 0.0, 1.0);
  return result;
}

AnfisModel scaled(AnfisModel model, double gain) {
  model.consequents *= gain;
  model.output_low *= gain;
  model.output_high *= gain;
  return model;
}

}  // namespace sixdial::calibration
