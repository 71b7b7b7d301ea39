#include "studies/validate.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <set>

#include "calibration/pipeline.h"
#include "session/clock_text.h"
#include "session/trials.h"
#include "studies/extended_command.h"
#include "studies/inputs.h"
#include "studies/method_name.h"

namespace sixdial::studies {
namespace {

/// Row of the calibration's own table that predicts this way's errors.
std::string predicting_method(const CalibrationResult& calibration, CompensateBy by) {
  if (by == CompensateBy::kBefore) return "before";
  return by == CompensateBy::kFull ? calibration.result_method
                                   : without_residual_model(calibration.result_method);
}

std::optional<ReachedErrors> reached(const std::vector<double>& errors_mm) {
  if (errors_mm.empty()) return std::nullopt;
  const calibration::ErrorStats stats = calibration::error_stats(errors_mm);
  return ReachedErrors{
      .mean_mm = stats.mean_mm,
      .std_mm = stats.std_mm,
      .max_mm = stats.max_mm,
      .rmse_mm = stats.rmse_mm,
      .points = stats.count};
}

/// Results of the paper's method are told as they always were.
std::optional<std::string> method_to_tell(const CalibrationResult& calibration) {
  if (calibration.result_method == kPaperMethod) return std::nullopt;
  return calibration.result_method;
}

}  // namespace

std::string validation_set(const std::string& set, CompensateBy by) {
  return fmt::format("{}.{}", set, to_string(by));
}

session::Plan validation_plan(
    const session::Session& calibrated, const CalibrationResult& calibration,
    const ValidationRequest& request, const DiagnosisResult* diagnosis) {
  session::Plan targets;
  std::set<int> seen;
  for (const session::Sample& sample : calibrated.samples) {
    if (sample.set != request.set || !sample.target_mm) continue;
    if (!seen.insert(sample.point).second) continue;  // repeats
    session::PlanPoint point;
    point.point = sample.point;
    point.set = request.set;
    point.target_mm = *sample.target_mm;
    point.q = sample.q;
    targets.points.push_back(point);
  }
  if (targets.points.empty()) {
    throw StudyError(
        StudyErrorCode::kBadData,
        fmt::format("session {} has no targets in set {}", calibrated.name, request.set),
        {{"session", calibrated.name}},
        "Name a set whose samples have target_x_mm and target_y_mm.");
  }
  std::vector<session::Plan> ways;
  for (const CompensateBy by : request.by) {
    // Where the extended model commands depends on what is commanded before: solved below.
    ways.push_back(compensated_plan(
        targets,
        compensation_model(
            calibration, calibrated.rig,
            by == CompensateBy::kExtended ? CompensateBy::kKinematics : by),
        calibrated.rig));
    for (session::PlanPoint& point : ways.back().points) {
      point.set = validation_set(request.set, by);
    }
  }
  session::Plan plan;
  for (std::size_t i = 0; i < targets.points.size(); ++i) {
    for (const session::Plan& way : ways) plan.points.push_back(way.points[i]);
  }
  if (std::ranges::find(request.by, CompensateBy::kExtended) == request.by.end()) return plan;
  return extended_plan(
      std::move(plan), ExtendedCommand(diagnosis->extended_fit, calibrated.rig), calibrated.rig,
      validation_set(request.set, CompensateBy::kExtended));
}

std::optional<double> ValidatedWay::predicted_mean_mm() const {
  if (predicted) return predicted->mean_mm;
  if (predicted_gain) return predicted_gain->mean_mm;
  return std::nullopt;
}

ValidationResult validation_result(
    const session::Session& calibrated, const CalibrationResult& calibration,
    const session::Session& validation, const ValidationRequest& request,
    const std::optional<GainRow>& diagnosed_gain) {
  ValidationResult result{
      .created_utc = session::now_utc_text(),
      .inputs = {
          .session = calibrated.name,
          .set = request.set,
          .calibration_data_hash = calibration.inputs.data_hash,
          .calibration_method = method_to_tell(calibration),
          .validation_session = validation.name,
          .version = SIXDIAL_VERSION}};
  const Inputs measured = inputs_of(validation, 0);
  result.inputs.rig_hash = measured.rig_hash;
  result.inputs.data_hash = measured.data_hash;
  for (const CompensateBy by : request.by) {
    ValidatedWay way{.by = by, .set = validation_set(request.set, by)};
    if (by == CompensateBy::kExtended) {
      way.predicted_gain = diagnosed_gain;
    } else if (const MethodRow* row = calibration.method(predicting_method(calibration, by))) {
      way.predicted = row->g2;
    }
    std::vector<double> errors_mm;
    for (const simulation::Trial& trial : session::trials_of(validation, way.set)) {
      if (!trial.position_mm || !trial.target_mm) {
        ++way.without_position;
        continue;
      }
      const Eigen::VectorXd missed = *trial.position_mm - *trial.target_mm;  // (41)
      errors_mm.push_back(missed.norm());
      result.points.push_back(
          {.by = by,
           .point = trial.point,
           .target_mm = *trial.target_mm,
           .theta_rad = {trial.q.begin(), trial.q.end()},
           .error_mm = missed});
    }
    way.errors = reached(errors_mm);
    result.methods.push_back(std::move(way));
  }
  return result;
}

}  // namespace sixdial::studies
