#pragma once

#include <Eigen/Core>

namespace sixdial::diagnosis {

/// Thin orthonormal basis of a matrix's columns, directions below `relative` left out.
[[nodiscard]] Eigen::MatrixXd orthonormal_basis(
    const Eigen::MatrixXd& columns, double relative = 1e-9);

}  // namespace sixdial::diagnosis
