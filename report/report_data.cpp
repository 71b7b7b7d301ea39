#include "report/report_data.h"

#include <algorithm>
#include <cmath>

#include "calibration/uncertainty.h"
#include "geometry/units.h"

namespace sixdial::report {
namespace {}

double shown_per_unit(const ShownParameter& row) {
  return row.unit == "deg" ? geometry::kDegPerRad : 1.0;
}

std::vector<ShownParameter> parameter_rows(
    const geometry::RobotModel& robot, const Eigen::VectorXd& nominal,
    const Eigen::VectorXd& identified, const std::optional<Eigen::MatrixXd>& covariance,
    const std::vector<bool>& held) {
  std::vector<ShownParameter> out;
  for (std::size_t k = 0; k < robot.parameters.size(); ++k) {
    const auto i = static_cast<Eigen::Index>(k);
    const geometry::ParameterInfo& info = robot.parameters[k];
    const bool is_held = k < held.size() && held[k];
    ShownParameter row{
        .name = std::string{info.name},
        .unit = std::string{info.shown_unit},
        .meaning = info.meaning,
        .nominal = nominal[i] * info.shown_per_unit,
        .identified = identified[i] * info.shown_per_unit,
        .sd = std::nullopt,
        .low = std::nullopt,
        .high = std::nullopt,
        .held = is_held};
    if (covariance && !is_held) {
      const double sd = std::sqrt((*covariance)(i, i)) * info.shown_per_unit;
      row.sd = sd;
      row.low = row.identified - calibration::kNormal_95 * sd;
      row.high = row.identified + calibration::kNormal_95 * sd;
    }
    out.push_back(std::move(row));
  }
  return out;
}

std::optional<ErrorStatistics> error_statistics(
    const ReportData& data, std::string_view set, std::size_t method) {
  std::vector<double> errors;
  for (const PointRow& p : data.points) {
    if (p.set != set || method >= p.residual_mm.size() || !p.residual_mm[method]) continue;
    errors.push_back(p.residual_mm[method]->norm());
  }
  if (errors.empty()) return std::nullopt;
  const double n = static_cast<double>(errors.size());
  ErrorStatistics out;
  out.points = static_cast<int>(errors.size());
  for (const double e : errors) out.mean_mm += e / n;
  double squares = 0.0;
  for (const double e : errors) squares += (e - out.mean_mm) * (e - out.mean_mm);
  out.max_mm = *std::max_element(errors.begin(), errors.end());
  if (errors.size() > 1) {
    out.std_mm = std::sqrt(squares / (n - 1.0));
    const double half = calibration::kNormal_95 * out.std_mm / std::sqrt(n);
    out.mean_low_mm = out.mean_mm - half;
    out.mean_high_mm = out.mean_mm + half;
  }
  return out;
}

std::optional<std::size_t> result_index(const ReportData& data) {
  if (data.methods.empty()) return std::nullopt;
  if (data.result_method.empty()) return data.methods.size() - 1;
  const auto found = std::find_if(
      data.methods.begin(), data.methods.end(),
      [&](const ShownMethod& m) { return m.id == data.result_method; });
  if (found == data.methods.end()) return std::nullopt;
  return static_cast<std::size_t>(found - data.methods.begin());
}

int points_without_position(const ReportData& data) {
  return static_cast<int>(std::count_if(
      data.points.begin(), data.points.end(),
      [](const PointRow& p) { return !p.measured_mm && !p.left_out; }));
}

}  // namespace sixdial::report
