// Any identifier of the registry with any residual model, or without one.
#include <algorithm>

#include "studies/calibrate_parts.h"
#include "studies/method_name.h"

namespace sixdial::studies {
namespace {

Identification identification_of(
    const calibration::ObservationSpace& space, const calibration::Identified& found) {
  const std::vector<std::string_view> names = space.parameter_names();
  const auto known =
      calibration::identifiability(found.fit, names, space.samples(), space.named_directions);
  return studies::identification_of(
      found.sigma_mm, found.fit.degrees_of_freedom(), found.covariance, known, names);
}

/// "before", the identifier alone and the method itself, each once.
std::vector<calibration::MethodChoice> rows_of(const calibration::MethodChoice& method) {
  std::vector<calibration::MethodChoice> rows{{"before", nullptr, nullptr}};
  rows.push_back({without_residual_model(method.id), method.identifier, nullptr});
  if (method.residual != nullptr) rows.push_back(method);
  return rows;
}

}  // namespace

CalibrationResult calibrate_by_method(
    const CalibrationData& data, const calibration::MethodChoice& method,
    const calibration::PipelineSettings& settings,
    const calibration::IdentifySettings& identify, const calibration::Identified& reference,
    const TellFraction& tell, const std::stop_token& stop) {
  const auto found = calibration::compare_methods(
      data.g1, data.g1, data.g2, rows_of(method),
      {.identify = identify, .residual = residual_settings(settings)},
      [&](const calibration::ComparisonProgress& now) {
        tell(now.stage, now.fraction, now.iteration, now.iterations, now.best_mm);
      },
      stop);
  if (!found) refuse(found.error(), data.session.name);
  const calibration::IdentifiedRobot& robot = found->robots.front();
  const calibration::Identified& fit = robot.found;
  if (fit.status == calibration::FitStatus::kBadStart || !fit.x.allFinite()) {
    refuse(
        {calibration::Trouble::Kind::kUnreachable,
         method.id + " found no parameters that reach every pose of G1"},
        data.session.name);
  }
  const std::vector<std::string_view> names = data.g1.parameter_names();
  CalibrationResult result{
      .settings = settings,
      .result_method = method.id,
      .parameters = parameter_rows(
          calibration::parameter_estimates(fit.fit, data.g1.nominal, fit.covariance, names),
          data.g1),
      .identification = identification_of(data.g1, fit),
      .before_uses_targets = found->before_uses_targets,
      .rmse_mm = fit.rmse,
      .least_squares_rmse_mm = reference.rmse,
      .above_minimum_mm = fit.rmse - reference.rmse,
      .seconds = found->seconds,
      .stages = {
          {.name = std::string(robot.identifier->name),
           .parameters = fit.x,
           .rmse_g1_mm = fit.rmse,
           .seconds = robot.seconds}}};
  if (!fit.history.empty()) {
    result.convergence.push_back({std::string(robot.identifier->title), fit.history});
  }
  std::vector<ModelledRow> rows;
  for (const calibration::ComparedMethod& row : found->methods) {
    const bool before = row.choice.identifier == nullptr;
    MethodRow& out = result.methods.emplace_back(MethodRow{
        .id = row.choice.id, .g1 = set_errors(row.errors.g1), .g2 = set_errors(row.errors.g2)});
    if (!before) out.seconds = row.identify_seconds + row.residual_seconds;
    rows.push_back(
        {.v = before ? data.g1.nominal : fit.x,
         .correction = row.residual.correction,
         .targets = before && found->before_uses_targets});
    if (row.choice.residual == nullptr) continue;
    result.residual_model = StoredResidualModel{
        .name = std::string(row.choice.residual->name),
        .note = row.residual.note,
        .effective_parameters = row.residual.effective_parameters,
        .saved = row.residual.saved};
  }
  result.points = point_residuals(data, rows);
  return result;
}

}  // namespace sixdial::studies
