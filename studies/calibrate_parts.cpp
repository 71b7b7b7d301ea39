#include "studies/calibrate_parts.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "calibration/reading_space.h"
#include "geometry/tool.h"

namespace sixdial::studies {
namespace {

/// What a row leaves of all samples, coordinates x samples [mm]; NaN where a pose is out of
/// reach.
Eigen::MatrixXd left_by(const ModelledRow& row, const calibration::ObservationSpace& set) {
  Eigen::MatrixXd left = calibration::position_errors(set, row.v);
  for (Eigen::Index i = 0; i < left.cols(); ++i) {
    if (row.targets && set.off_target_mm.col(i).allFinite()) {
      left.col(i) = set.off_target_mm.col(i);
    } else if (row.correction) {
      left.col(i) -= row.correction(set.joints.col(i));
    }
  }
  return left;
}

/// Where the tool was measured: as such, or where what was read puts it, by the last row's
/// robot and the places that were fitted along with it.
Eigen::VectorXd measured_place(
    const CalibrationData& data, const calibration::ObservationSpace& set, int sample,
    const std::vector<ModelledRow>& rows) {
  const auto k = static_cast<std::size_t>(sample);
  if (calibration::gives_positions(data.session.rig)) {
    return set.measured_mm.segment(set.first_row[k], set.position_axes);
  }
  const geometry::Robot& robot = data.session.rig.robot;
  const geometry::Tool tool(data.session.rig);
  const Eigen::VectorXd& x = rows.back().v;
  const auto at =
      tool.position(x.head(robot.nominal.size()), set.joints.col(sample), robot.assembly);
  Eigen::VectorXd shift(set.position_axes);
  if (!at || !set.position_error(sample, x, shift)) {
    return Eigen::VectorXd::Constant(
        set.position_axes, std::numeric_limits<double>::quiet_NaN());
  }
  return *at + shift;
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

Identification identification_of(
    double sigma_mm, int degrees_of_freedom, const Eigen::MatrixXd& covariance,
    const calibration::Identifiability& known, std::span<const std::string_view> names) {
  Identification identification{
      .sigma_mm = sigma_mm,
      .degrees_of_freedom = degrees_of_freedom,
      .covariance = covariance,
      .singular_values = known.singular_values,
      .condition = known.condition,
      .observability = known.observability,
      .correlations = correlation_rows(known, names)};
  for (const auto& each : known.held) {
    identification.held.push_back(
        {.words = each.words,
         .direction = each.direction,
         .singular_value = each.singular_value});
  }
  return identification;
}

std::vector<PointResiduals> point_residuals(
    const CalibrationData& data, const std::vector<ModelledRow>& rows) {
  std::vector<PointResiduals> points;
  for (const auto* set : {&data.g1, &data.g2}) {
    std::vector<Eigen::MatrixXd> left;
    for (const ModelledRow& row : rows) left.push_back(left_by(row, *set));
    for (int i = 0; i < calibration::measured_samples(*set); ++i) {
      const auto k = static_cast<std::size_t>(i);
      const session::Sample& sample =
          data.session.samples[static_cast<std::size_t>(set->sample[k])];
      PointResiduals point{
          .sample = set->sample[k],
          .set = sample.set,
          .point = sample.point,
          .repeat = sample.repeat,
          .measured_mm = measured_place(data, *set, i, rows)};
      for (const Eigen::MatrixXd& each : left) {
        const bool reached = each.col(i).allFinite();
        point.residual_mm.push_back(
            reached ? std::optional<Eigen::VectorXd>(each.col(i)) : std::nullopt);
      }
      points.push_back(std::move(point));
    }
  }
  return points;
}

calibration::ResidualSettings residual_settings(const calibration::PipelineSettings& settings) {
  calibration::ResidualSettings residual;
  residual.seed = settings.seed;
  residual.holdout_fraction = settings.holdout_fraction;
  residual.anfis = settings.anfis;
  return residual;
}

void refuse(
    const calibration::Trouble& trouble, const std::string& session,
    const std::optional<std::string>& hint) {
  const bool cancelled = trouble.kind == calibration::Trouble::Kind::kCancelled;
  throw StudyError(
      cancelled ? StudyErrorCode::kCancelled : StudyErrorCode::kBadData, trouble.message,
      {{"session", session}},
      cancelled
          ? ""
          : hint.value_or(
                "Measure more points of set G1: collect.start, or look at the rig file."));
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
