#pragma once

#include <Eigen/Core>

namespace sixdial::diagnosis {

/// Thin orthonormal basis of a matrix's columns, directions below `relative` left out.
[[nodiscard]] Eigen::MatrixXd orthonormal_basis(
    const Eigen::MatrixXd& columns, double relative = 1e-9);

/// Of the columns [fitted; 0] and [random; diag(root)], (n + m) x any: `random` have a prior,
/// root > 0, so that none of them is left out.
[[nodiscard]] Eigen::MatrixXd orthonormal_basis(
    const Eigen::MatrixXd& fitted, const Eigen::MatrixXd& random, const Eigen::VectorXd& root);

}  // namespace sixdial::diagnosis
