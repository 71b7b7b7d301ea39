#include "report/report_data.h"

#include <algorithm>
#include <cmath>

namespace sixdial::report {
namespace {
constexpr double kNormal95 = 1.959963984540054;  // two-sided 95 % of the normal distribution
}

std::vector<ParameterRow> parameter_rows(
    const geometry::ParameterVector& nominal, const geometry::ParameterVector& identified,
    const std::optional<geometry::ParameterMatrix>& covariance,
    const std::array<bool, geometry::kParameterCount>& held) {
  std::vector<ParameterRow> out;
  for (std::size_t k = 0; k < geometry::kParameters.size(); ++k) {
    const auto i = static_cast<Eigen::Index>(k);
    const geometry::ParameterInfo& info = geometry::kParameters[k];
    ParameterRow row{
        .name = std::string{info.name},
        .unit = std::string{info.shown_unit},
        .nominal = nominal[i] * info.shown_per_unit,
        .identified = identified[i] * info.shown_per_unit,
        .sd = std::nullopt,
        .low = std::nullopt,
        .high = std::nullopt,
        .held = held[k]};
    if (covariance && !held[k]) {
      const double sd = std::sqrt((*covariance)(i, i)) * info.shown_per_unit;
      row.sd = sd;
      row.low = row.identified - kNormal95 * sd;
      row.high = row.identified + kNormal95 * sd;
    }
    out.push_back(std::move(row));
  }
  return out;
}

std::optional<std::size_t> result_index(const ReportData& data) {
  if (data.methods.empty()) return std::nullopt;
  if (data.result_method.empty()) return data.methods.size() - 1;
  const auto found = std::find_if(
      data.methods.begin(), data.methods.end(),
      [&](const Method& m) { return m.id == data.result_method; });
  if (found == data.methods.end()) return std::nullopt;
  return static_cast<std::size_t>(found - data.methods.begin());
}

int points_without_position(const ReportData& data) {
  return static_cast<int>(std::count_if(
      data.points.begin(), data.points.end(),
      [](const PointRow& p) { return !p.measured_mm; }));
}

}  // namespace sixdial::report
