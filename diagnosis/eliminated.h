// Normal equations of a joint fit with its random columns eliminated: there may be a hundred of
// those, each with a prior of its own, so that the block of them is cheap to solve, and what is
// left has the size of the parameters.
#pragma once

#include <Eigen/Cholesky>
#include <Eigen/Core>
#include <Eigen/Eigenvalues>

namespace sixdial::diagnosis {

/// A'A, half the work of the product.
[[nodiscard]] Eigen::MatrixXd gram(const Eigen::MatrixXd& A);

/// min |e - A x - C u|^2 + |r (u0 + u)|^2 over x and u, all rows whitened.
class EliminatedEquations {
 public:
  /// `A`: n x p; `C`: n x m; `e`: n; `root` = r and `u` = u0: m, r > 0.
  EliminatedEquations(
      const Eigen::MatrixXd& A, const Eigen::MatrixXd& C, const Eigen::VectorXd& e,
      const Eigen::VectorXd& root, const Eigen::VectorXd& u);

  /// Number of directions of x that the data determine.
  [[nodiscard]] Eigen::Index determined() const { return seen_.size(); }
  /// By how much the full step lowers the squares of the linear problem.
  [[nodiscard]] double fall() const;
  /// The step of x and, below it, of u. `damping`: in units of the largest eigenvalue, of x
  /// alone.
  [[nodiscard]] Eigen::VectorXd step(double damping) const;
  /// Of x, in units of the squares' variance: the pseudoinverse, p x p.
  [[nodiscard]] Eigen::MatrixXd covariance() const;
  /// Variances of u in the same unit.
  [[nodiscard]] Eigen::VectorXd variance_of_u() const;
  /// ln det of u's covariance, in the same unit.
  [[nodiscard]] double log_volume_of_u() const;

 private:
  Eigen::VectorXd scale_;          // of x: columns of length one
  Eigen::LLT<Eigen::MatrixXd> D_;  // C'C + r^2
  Eigen::MatrixXd share_;          // D^-1 C'A, scaled; m x p
  Eigen::VectorXd at_rest_;        // step of u where x stays
  Eigen::MatrixXd absorbed_;       // A'C D^-1 C'A, scaled: what u takes over; p x p
  Eigen::VectorXd along_;          // in the eigenvectors' directions
  Eigen::VectorXd seen_;           // eigenvalues above rounding; the last ones of all
  Eigen::MatrixXd vectors_;        // theirs
  double largest_ = 1.0;
  double fall_of_u_ = 0.0;
};

}  // namespace sixdial::diagnosis
