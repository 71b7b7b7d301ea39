#include "studies/validate.h"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <set>

#include "calibration/pipeline.h"
#include "session/clock_text.h"
#include "session/trials.h"
#include "studies/extended_command.h"
#include "studies/inputs.h"
#include "studies/measured_positions.h"
#include "studies/method_name.h"
#include "studies/seen_rig.h"

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

/// The targets of a set, once each, in the order in which they were measured; each joint comes
/// from the side that it came from then, where nobody knows from below.
session::Plan targets_of(const session::Session& calibrated, const std::string& set) {
  session::Plan targets;
  std::set<int> seen;
  for (const session::Sample& sample : calibrated.samples) {
    if (sample.set != set || !sample.target_mm) continue;
    if (!seen.insert(sample.point).second) continue;  // repeats
    session::PlanPoint point;
    point.point = sample.point;
    point.set = set;
    point.target_mm = *sample.target_mm;
    point.q = sample.q;
    for (std::size_t joint = 0; joint < static_cast<std::size_t>(sample.q.size()); ++joint) {
      const int side = session::approach_of(sample, joint).value_or(0);
      point.approach.push_back(side != 0 ? side : 1);
    }
    targets.points.push_back(point);
  }
  if (!targets.points.empty()) return targets;
  throw StudyError(
      StudyErrorCode::kBadData,
      fmt::format("session {} has no targets in set {}", calibrated.name, set),
      {{"session", calibrated.name}},
      "Name a set whose samples have target_x_mm and target_y_mm.");
}

std::vector<session::TimePoint> times_of(const session::Session& session) {
  std::vector<session::TimePoint> times;
  for (const session::Sample& sample : session.samples) {
    if (sample.time_utc) times.push_back(*sample.time_utc);
  }
  return times;
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

session::Plan validation_pass(
    const session::Session& calibrated, const CalibrationResult& calibration,
    const ValidationRequest& request, CompensateBy by, const DiagnosisResult* diagnosis,
    const PlanMoment& moment) {
  session::Plan pass = targets_of(calibrated, request.set);
  for (session::PlanPoint& point : pass.points) point.set = validation_set(request.set, by);
  if (!is_extended(by)) {
    return compensated_plan(
        std::move(pass), compensation_model(calibration, calibrated.rig, by), calibrated.rig);
  }
  if (diagnosis == nullptr) {
    throw StudyError(
        StudyErrorCode::kBadData,
        fmt::format("commanding by '{}' needs a diagnosis", to_string(by)),
        {{"session", calibrated.name}}, "Diagnose the session first: diagnose.start.");
  }
  return extended_plan(
      std::move(pass), ExtendedCommand(diagnosis->extended_fit, calibrated.rig, by),
      calibrated.rig, moment);
}

session::Plan validation_plan(
    const session::Session& calibrated, const CalibrationResult& calibration,
    const ValidationRequest& request, const DiagnosisResult* diagnosis) {
  session::Plan plan;
  for (const CompensateBy by : request.by) {
    const session::Plan pass = validation_pass(calibrated, calibration, request, by, diagnosis);
    plan.points.insert(plan.points.end(), pass.points.begin(), pass.points.end());
  }
  return plan;
}

PlanMoment moment_of_pass(
    const session::Session& calibrated, const session::Session& validation,
    session::TimePoint now) {
  const auto hours = [](session::TimePoint from, session::TimePoint to) {
    return std::chrono::duration<double, std::ratio<3600>>(to - from).count();
  };
  const std::vector<session::TimePoint> before = times_of(calibrated);
  const std::vector<session::TimePoint> times = times_of(validation);
  PlanMoment moment;
  for (const session::Sample& sample : validation.samples) {
    if (sample.temperature_c) moment.temperature_c = sample.temperature_c;
  }
  if (before.empty()) return moment;
  const std::vector<session::TimePoint>& pace = times.size() > 1 ? times : before;
  moment.hours_a_point = hours(pace.front(), pace.back()) /
                         static_cast<double>(std::max<std::size_t>(1, pace.size() - 1));
  // A drift is believed for as long after the session as it was seen in it.
  const double measured_h = hours(before.front(), before.back());
  moment.first_time_h =
      std::min(hours(before.front(), times.empty() ? now : times.back()), 2 * measured_h);
  return moment;
}

std::optional<double> ValidatedWay::predicted_mean_mm() const {
  if (predicted) return predicted->mean_mm;
  if (predicted_gain) return predicted_gain->mean_mm;
  return std::nullopt;
}

ValidationResult validation_result(
    const session::Session& calibrated, const CalibrationResult& calibration,
    const session::Session& validation, const ValidationRequest& request,
    const DiagnosisResult* diagnosis) {
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
  const bool instrument_named =
      diagnosis != nullptr && names_the_instrument(*diagnosis, calibrated.rig);
  if (instrument_named) result.inputs.positions_by = "diagnosis";
  // A robot is measured in the frame that it was fitted in: a calibration and a diagnosis may
  // see the dials at places a little different.
  const auto explained = [&] {
    return explained_positions(calibrated, validation, *diagnosis);
  };
  PositionOfSample by_calibration, by_diagnosis;
  if (instrument_named) {
    by_calibration = by_diagnosis = explained();
  } else {
    session::Session seen = validation;
    seen.rig = rig_as_seen(validation.rig, calibrated.rig, calibration.rig);
    by_calibration = by_diagnosis = measured_positions(seen);
    const bool own_rig = diagnosis != nullptr && diagnosis->extended_fit.rig &&
                         !diagnosis->extended_fit.rig->empty();
    if (own_rig) by_diagnosis = explained();
  }
  for (const CompensateBy by : request.by) {
    ValidatedWay way{.by = by, .set = validation_set(request.set, by)};
    if (is_extended(by)) {
      const GainRow* row = diagnosis == nullptr
                               ? nullptr
                               : gain_row(
                                     *diagnosis, diagnosis::GainModel::kExtended,
                                     by == CompensateBy::kExtendedFull);
      if (row != nullptr) way.predicted_gain = *row;
    } else if (const MethodRow* row = calibration.method(predicting_method(calibration, by))) {
      way.predicted = row->g2;
    }
    const PositionOfSample& positions = is_extended(by) ? by_diagnosis : by_calibration;
    std::vector<double> errors_mm;
    for (std::size_t i = 0; i < validation.samples.size(); ++i) {
      const session::Sample& sample = validation.samples[i];
      if (sample.set != way.set) continue;
      if (!positions[i] || !sample.target_mm) {
        ++way.without_position;
        continue;
      }
      const Eigen::VectorXd missed = *positions[i] - *sample.target_mm;  // (41)
      errors_mm.push_back(missed.norm());
      result.points.push_back(
          {.by = by,
           .point = sample.point,
           .target_mm = *sample.target_mm,
           .theta_rad = {sample.q.begin(), sample.q.end()},
           .error_mm = missed});
    }
    way.errors = reached(errors_mm);
    result.methods.push_back(std::move(way));
  }
  return result;
}

}  // namespace sixdial::studies
