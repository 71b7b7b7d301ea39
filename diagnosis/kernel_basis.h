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
  /// Of a wave: the sine around which its spectrum stands; `lengths` are then its widths, in
  /// sines. -1: a kernel.
  int wave = -1;
};
/// For a function of one covariate.
[[nodiscard]] const std::vector<Box>& boxes_along();

/// A smooth function of one covariate that enters at one place, told well enough to compute its
/// columns anew for other readings.
struct Kernel {
  double low = 0.0, high = 0.0;  // of the covariate
  double half_width = 0.0;       // of the box, in half ranges
  std::vector<int> functions{};  // that have a column
  Eigen::VectorXd size{};        // what the basis function of each column is multiplied by
  int wave = -1;                 // of a wave: the sine around which it stands (Box::wave)
  [[nodiscard]] double range() const { return high - low; }
};

/// Length of the sine around which a wave stands, in the covariate's unit; empty: no wave.
[[nodiscard]] std::optional<double> sine_length(const Kernel& kernel);
/// Covariate scaled to [-1, 1]; empty if it does not vary.
[[nodiscard]] std::optional<Eigen::VectorXd> scaled(const Eigen::VectorXd& values);
/// The sines of a box from number `first` on, samples x count.
[[nodiscard]] Eigen::MatrixXd basis_of(
    const Eigen::VectorXd& u, double half_width, int count, int first = 0);
/// What each column of a kernel is where its covariate has this value; at the ends beyond them.
[[nodiscard]] Eigen::VectorXd kernel_values(const Kernel& kernel, double at);
/// Spectral density of a box's kernel at basis function j.
[[nodiscard]] double spectrum(int j, double half_width, double length);
[[nodiscard]] double spectrum(int j, const Box& box, double length);
/// Which columns, scaled by their spread, could be seen beside the largest.
[[nodiscard]] std::vector<Eigen::Index> prominent(
    const Eigen::MatrixXd& columns, const Eigen::VectorXd& spread);
/// These columns, scaled by their spread.
[[nodiscard]] Eigen::MatrixXd scaled_columns(
    const Eigen::MatrixXd& columns, const Eigen::VectorXd& spread,
    const std::vector<Eigen::Index>& which);

}  // namespace sixdial::diagnosis
