// Lines of equal value on a rectangular grid, for maps in reports.
#pragma once

#include <Eigen/Core>
#include <span>
#include <vector>

namespace sixdial::report {

using Polyline = std::vector<Eigen::Vector2d>;

/// `values`: row by row, x.size() columns and y.size() rows; cells with a corner that is not
/// finite are left out. Each line is as long as it can be; closed ones end where they begin.
[[nodiscard]] std::vector<Polyline> contour_lines(
    std::span<const double> x, std::span<const double> y, std::span<const double> values,
    double level);

/// At most `most` round numbers (1, 2 or 5 times a power of ten apart) strictly between.
[[nodiscard]] std::vector<double> round_levels(double low, double high, int most);

}  // namespace sixdial::report
