// A'B of tall matrices: thousands of readings by a hundred columns or two. What a diagnosis
// does most of the time, by the widest vector unit of the machine.
//
// Example:
//   const Eigen::MatrixXd A = Eigen::MatrixXd::Ones(1000, 2);
//   column_products(A, A)(0, 1);  // -> 1000
#pragma once

#include <Eigen/Core>

namespace sixdial::calibration {

/// A'B, A.cols() x B.cols(); both have the same number of rows.
[[nodiscard]] Eigen::MatrixXd column_products(
    const Eigen::MatrixXd& A, const Eigen::MatrixXd& B);
/// A'A, half the work.
[[nodiscard]] Eigen::MatrixXd column_products(const Eigen::MatrixXd& A);

}  // namespace sixdial::calibration
