#include "studies/calibrate_parts.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace sixdial::studies {
namespace {

std::optional<Eigen::Vector2d> residual(
    const ModelledRow& row, const calibration::PositionObservations& set, int i) {
  const auto k = static_cast<std::size_t>(i);
  const Eigen::Vector2d measured = set.p_WE.col(i);
  if (row.targets && set.target_mm[k]) return measured - *set.target_mm[k];
  const Eigen::Vector2d q_rad = set.q_rad.col(i);
  const auto pose = geometry::forward(row.v, q_rad, set.assembly[k]);
  if (!pose) return std::nullopt;
  Eigen::Vector2d left = measured - pose->p_WE;
  if (row.correction) left -= row.correction(q_rad);
  return left;
}

}  // namespace

std::optional<SetErrors> set_errors(const calibration::ErrorStats& stats) {
  if (stats.count == 0) return std::nullopt;
  const double half = stats.count > 1
                          ? calibration::student_95(stats.count - 1) * stats.std_mm /
                                std::sqrt(static_cast<double>(stats.count))
                          : std::numeric_limits<double>::quiet_NaN();
  return SetErrors{
      .mean_mm = stats.mean_mm,
      .std_mm = stats.std_mm,
      .max_mm = stats.max_mm,
      .rmse_mm = stats.rmse_mm,
      .mean_low_mm = stats.mean_mm - half,
      .mean_high_mm = stats.mean_mm + half,
      .points = stats.count,
      .unreachable = stats.unreachable};
}

std::vector<PointResiduals> point_residuals(
    const CalibrationData& data, const std::vector<ModelledRow>& rows) {
  std::vector<PointResiduals> points;
  for (const auto* set : {&data.g1, &data.g2}) {
    for (int i = 0; i < set->size(); ++i) {
      const int row = set->sample[static_cast<std::size_t>(i)];
      const session::Sample& sample = data.session.samples[static_cast<std::size_t>(row)];
      PointResiduals point{
          .sample = row,
          .set = sample.set,
          .point = sample.point,
          .repeat = sample.repeat,
          .measured_mm = set->p_WE.col(i)};
      for (const ModelledRow& each : rows) {
        point.residual_mm.push_back(residual(each, *set, i));
      }
      points.push_back(std::move(point));
    }
  }
  return points;
}

void refuse(const calibration::Trouble& trouble, const std::string& session) {
  const bool cancelled = trouble.kind == calibration::Trouble::Kind::kCancelled;
  throw Error(
      cancelled ? ErrorCode::kCancelled : ErrorCode::kBadData, trouble.message,
      {{"session", session}},
      cancelled ? ""
                : "Measure more points of set G1: collect.start, or look at the rig file.");
}

const MethodRow* CalibrationResult::method(std::string_view id) const {
  const auto found = std::ranges::find(methods, id, &MethodRow::id);
  return found == methods.end() ? nullptr : &*found;
}

Eigen::VectorXd CalibrationResult::nominal() const {
  Eigen::VectorXd v(std::ssize(parameters));
  for (std::size_t i = 0; i < parameters.size(); ++i) {
    v[static_cast<Eigen::Index>(i)] = parameters[i].nominal;
  }
  return v;
}

Eigen::VectorXd CalibrationResult::identified() const {
  Eigen::VectorXd v(std::ssize(parameters));
  for (std::size_t i = 0; i < parameters.size(); ++i) {
    v[static_cast<Eigen::Index>(i)] = parameters[i].identified;
  }
  return v;
}

}  // namespace sixdial::studies
