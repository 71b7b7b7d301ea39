#include "report/expanded.h"

#include <fmt/format.h>

#include <cmath>

namespace sixdial::report {
namespace {

constexpr double kMore = 1.05;  // of kCoverage: from here on the factor is said as it is

}  // namespace

std::string expanded_title(double coverage) {
  return coverage == std::floor(coverage) ? fmt::format("U (k = {:.0f})", coverage)
                                          : fmt::format("U (k = {:.2f})", coverage);
}

Column expanded_column(std::string key, std::string unit, std::string group, double coverage) {
  return column(std::move(key), expanded_title(coverage), std::move(unit), std::move(group));
}

Cell expanded(const std::optional<double>& sd, int decimals, double coverage) {
  if (!sd) return {};
  return Number{.value = *sd, .decimals = decimals, .shown_times = coverage};
}

double coverage_of(double sd, double low, double high) {
  const double times = 0.5 * (high - low) / sd;
  if (!std::isfinite(times) || times < kMore * geometry::kCoverage) return geometry::kCoverage;
  return std::ceil(100.0 * times) / 100.0;
}

}  // namespace sixdial::report
