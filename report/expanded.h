// Uncertainties as a page and a terminal show them: U = k u (geometry/coverage.h).
//
// Example:
//   table.columns.push_back(expanded_column("sd"));
//   row.push_back(expanded(0.0012, 4));  // shown as 0.0024; CSV and JSON: 0.0012 under "sd"
#pragma once

#include <optional>
#include <string>

#include "geometry/coverage.h"
#include "report/document.h"

namespace sixdial::report {

/// "U (k = 2)"; other factors with two decimals.
[[nodiscard]] std::string expanded_title(double coverage = geometry::kCoverage);
/// A column of standard deviations, which a page shows as expanded uncertainties.
[[nodiscard]] Column expanded_column(
    std::string key, std::string unit = "", std::string group = "",
    double coverage = geometry::kCoverage);
/// A standard deviation in it; nothing, or not finite: as number().
[[nodiscard]] Cell expanded(
    const std::optional<double>& sd, int decimals, double coverage = geometry::kCoverage);
/// What half a 95 % interval [low, high] is in standard deviations, at least 2: more where few
/// degrees of freedom make it wider (Student's t, GUM G.3). The next hundredth above.
[[nodiscard]] double coverage_of(double sd, double low, double high);

}  // namespace sixdial::report
