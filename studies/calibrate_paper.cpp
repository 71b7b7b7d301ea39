// The paper's method, EKF-DQPSO with ANFIS, and what its figures show.
#include "studies/calibrate_parts.h"

namespace sixdial::studies {
namespace {

/// Seconds of all stages up to a method's; lm is a reference beside them, not one of them.
std::optional<double> seconds_until(
    const calibration::Result& result, const std::string& method) {
  std::optional<double> seconds;
  double sum_s = 0.0;
  for (const auto& stage : result.stages) {
    if (stage.name == "lm" && method != "lm") continue;
    sum_s = stage.name == "lm" ? stage.seconds : sum_s + stage.seconds;
    if (stage.name == method) seconds = sum_s;
    if (method == stage.name + "+anfis") seconds = sum_s + result.anfis_seconds;
  }
  return seconds;
}

Identification identification_of(
    const calibration::Result& result, std::span<const std::string_view> names) {
  const calibration::Identifiability& known = result.identifiability;
  return studies::identification_of(
      result.sigma_mm, result.degrees_of_freedom, result.covariance, known, names);
}

/// Robots behind the rows of Table 6, in its order.
std::vector<ModelledRow> modelled_rows(const calibration::Result& result) {
  std::vector<calibration::AnfisModel> networks;
  for (const auto& each : result.networks) networks.push_back(each.model);
  std::vector<ModelledRow> rows;
  for (const auto& method : result.table_6) {
    if (method.method == "before") {
      rows.push_back({.v = result.nominal, .targets = result.before_uses_targets});
    } else if (method.method.ends_with("+anfis")) {
      rows.push_back({.v = result.v, .correction = [networks](const Eigen::VectorXd& joints) {
                        return calibration::anfis_correction(networks, joints);
                      }});
    } else {
      rows.push_back({.v = result.stage(method.method).v});
    }
  }
  return rows;
}

}  // namespace

CalibrationResult calibrate_by_paper(
    const CalibrationData& data, const calibration::PipelineSettings& settings,
    const TellFraction& tell, const std::stop_token& stop) {
  const auto found = calibration::run_dqpso_anfis(
      data.g1, data.g2, settings,
      [&](const calibration::PipelineProgress& now) {
        tell(
            std::string(calibration::to_string(now.stage)), now.fraction, now.iteration,
            now.iterations, now.rmse_mm);
      },
      stop);
  if (!found) refuse(found.error(), data.session.name);
  const std::vector<std::string_view> names = data.g1.parameter_names();
  CalibrationResult result{
      .settings = found->settings,
      .result_method = std::string(kPaperMethod),
      .parameters = parameter_rows(found->parameters, data.g1),
      .identification = identification_of(*found, names),
      .before_uses_targets = found->before_uses_targets,
      .rmse_mm = found->stage("ekf_dqpso").rmse_g1_mm,
      .least_squares_rmse_mm = found->stage("lm").rmse_g1_mm,
      .above_minimum_mm = found->above_minimum_mm,
      .noise = found->noise,
      .not_finite_evaluations = found->not_finite,
      .seconds = found->total_seconds,
      .convergence = {{"QPSO-1", found->qpso1_history_mm}, {"QPSO-2", found->qpso2_history_mm}},
      .traces =
          {{"EKF", "point", found->filter_history},
           {"QPSO-2", "iteration", found->qpso2_history}},
      .networks = Networks{found->networks.at(0), found->networks.at(1)},
      .points = point_residuals(data, modelled_rows(*found))};
  for (const auto& row : found->table_6) {
    result.methods.push_back(
        {.id = row.method,
         .g1 = set_errors(row.g1),
         .g2 = set_errors(row.g2),
         .seconds = seconds_until(*found, row.method)});
  }
  for (const auto& stage : found->stages) {
    result.stages.push_back(
        {.name = stage.name,
         .parameters = stage.v,
         .rmse_g1_mm = stage.rmse_g1_mm,
         .seconds = stage.seconds});
  }
  return result;
}

}  // namespace sixdial::studies
