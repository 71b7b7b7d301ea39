// Smooth functions of a covariate as columns: sines whose coefficients have the spectrum of a
// kernel stand for a Gaussian process.
#pragma once

#include <Eigen/Core>
#include <optional>
#include <vector>

namespace sixdial::diagnosis {

/// Kernels of one box: sines on [-half_width, half_width] in half ranges of the covariate stand
/// for a Gaussian process, as long as its length is short against the box. A negative length is
/// the exponential kernel's (a wandering value, as of a random walk).
struct Box {
  double half_width;
  std::vector<double> lengths;
};
/// For a function of one covariate.
[[nodiscard]] const std::vector<Box>& boxes_along();

/// Covariate scaled to [-1, 1]; empty if it does not vary.
[[nodiscard]] std::optional<Eigen::VectorXd> scaled(const Eigen::VectorXd& values);
/// Samples x count.
[[nodiscard]] Eigen::MatrixXd basis_of(const Eigen::VectorXd& u, double half_width, int count);
/// Spectral density of a kernel at basis function j.
[[nodiscard]] double spectrum(int j, double half_width, double length);
/// Columns scaled by their spread, without those that could not be seen.
[[nodiscard]] Eigen::MatrixXd prominent(
    const Eigen::MatrixXd& columns, const Eigen::VectorXd& spread);

}  // namespace sixdial::diagnosis
