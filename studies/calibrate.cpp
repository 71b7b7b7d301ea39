#include "studies/calibrate.h"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <cmath>

#include "calibration/rig_errors.h"
#include "calibration/workers.h"
#include "session/clock_text.h"
#include "session/trials.h"
#include "studies/calibrate_parts.h"
#include "studies/cancellable.h"
#include "studies/conformity.h"
#include "studies/method_name.h"
#include "studies/own_frame.h"
#include "studies/plausibility_of_fit.h"
#include "studies/position_noise.h"
#include "studies/seen_rig.h"

namespace sixdial::studies {
namespace {

calibration::PipelineSettings settings_of(const CalibrationRequest& request) {
  calibration::PipelineSettings settings = calibration::settings_for(request.profile);
  settings.seed = request.seed;
  settings.threads = calibration::threads_asked(request.threads);
  if (request.particles) {
    settings.qpso1.particles = *request.particles;
    settings.qpso2.particles = *request.particles;
  }
  if (request.qpso1_iterations) settings.qpso1.iterations = *request.qpso1_iterations;
  if (request.qpso2_iterations) settings.qpso2.iterations = *request.qpso2_iterations;
  if (request.anfis_epochs) settings.anfis.epochs = *request.anfis_epochs;
  return settings;
}

/// The same choices for an identifier of the registry.
calibration::IdentifySettings identify_settings(
    const calibration::PipelineSettings& settings,
    const calibration::IdentifySettings& judged) {
  calibration::IdentifySettings identify = judged;
  identify.seed = settings.seed;
  identify.threads = settings.threads;
  identify.linearisation = settings.linearisation;
  identify.coordinates = settings.coordinates;
  identify.qpso1 = settings.qpso1;
  identify.qpso2 = settings.qpso2;
  return identify;
}

TellFraction teller(const ProgressCallback& progress) {
  const auto began = std::chrono::steady_clock::now();
  return [began, progress](
             const std::string& stage, double fraction, int iteration, int iterations,
             double best_mm) {
    if (!progress) return;
    const bool counted = iterations > 0;
    Progress told{
        .stage = stage,
        .done = counted ? iteration : std::llround(100.0 * fraction),
        .total = counted ? iterations : 100,
        .eta_s = time_left_s(began, fraction)};
    if (best_mm > 0.0) told.best_mm = best_mm;
    progress(std::move(told));
  };
}

/// The method as a row of the registry trains it: the paper's literal network has its own.
calibration::MethodChoice registry_method(
    calibration::MethodChoice method, calibration::Profile profile) {
  if (method.id == kPaperMethod && profile == calibration::Profile::kPaper) {
    method.residual = calibration::find_residual_model("anfis_paper");
  }
  return method;
}

/// Standard deviations and intervals rest on the same spread wherever they are shown. `by_fit`:
/// the identified parameters are at the minimum of the least-squares fit that was assessed.
/// `held`: what the poses and the rig leave open, which the assessment has already.
void use_noise_of(
    const Assessment& assessment, bool by_fit, const Eigen::MatrixXd& held,
    CalibrationResult& result) {
  const double quantile = calibration::quantile_95(assessment.noise);
  Identification& identification = result.identification;
  if (by_fit) {
    identification.covariance = assessment.covariance;
  } else if (identification.sigma_mm > 0.0) {
    const double times = assessment.noise.spread_mm / identification.sigma_mm;
    identification.covariance *= times * times;
    identification.covariance += held;
  }
  identification.sigma_mm = assessment.noise.sigma_mm;
  for (std::size_t i = 0; i < result.parameters.size(); ++i) {
    const auto k = static_cast<Eigen::Index>(i);
    ParameterRow& row = result.parameters[i];
    row.sd = by_fit ? assessment.parameters[i].sd : std::sqrt(identification.covariance(k, k));
    row.low_95 = row.identified - quantile * row.sd;
    row.high_95 = row.identified + quantile * row.sd;
  }
}

/// Dials that allow no position can be fitted all the same.
[[noreturn]] void refuse_with_hint(
    const calibration::Trouble& trouble, std::span<const simulation::Trial> g1,
    const session::Session& session, const session::Session& believed) {
  const std::string& name = session.name;
  const bool any_reading = std::ranges::any_of(g1, [](const simulation::Trial& trial) {
    return std::ranges::any_of(
        trial.reading, [](const auto& each) { return each.has_value(); });
  });
  if (trouble.kind != calibration::Trouble::Kind::kTooFewSamples || !any_reading) {
    refuse(trouble, name, settle_first(session, believed));
  }
  throw StudyError(
      StudyErrorCode::kBadData, trouble.message, {{"session", name}},
      "Raw readings can be fitted without positions: sixdial compare SESSION --space dials.");
}

/// The robot's own parameters: the places of an instrument that were found along with them
/// stand in the assessment.
void keep_the_robot(const geometry::Rig& rig, CalibrationResult& result) {
  const Eigen::Index n = rig.robot.nominal.size();
  if (std::ssize(result.parameters) <= n) return;
  result.parameters.resize(static_cast<std::size_t>(n));
  Eigen::MatrixXd& covariance = result.identification.covariance;
  covariance = covariance.topLeftCorner(n, n).eval();
  for (StageRow& stage : result.stages) stage.parameters = stage.parameters.head(n).eval();
  for (HeldRow& held : result.identification.held) {
    held.direction = held.direction.head(n).eval();
  }
  for (Trace& trace : result.traces) {
    for (Eigen::VectorXd& error : trace.error) error = error.head(n).eval();
  }
}

/// What the fit is worth: uncertainties, the budget of the tool's position, the rig as it was
/// found, readings that stand out.
void judge_fit(
    const CalibrationData& data, const CheckedSession& checked,
    const calibration::IdentifySettings& judged, const calibration::Identified& reference,
    bool by_paper, CalibrationResult& result) {
  const calibration::Weighting weighting = calibration::weighting_of(data.g1, judged);
  result.assessment =
      assess(data.g1, reference.fit, weighting, checked.g1, checked.all, checked.session.rig);
  use_noise_of(
      *result.assessment, by_paper,
      calibration::held_covariance(reference.fit, data.g1.parameter_info) +
          calibration::rig_covariance(data.g1, reference.fit, weighting),
      result);
  result.uncertainty_budgets = uncertainty_budgets(
      {.space = data.g1,
       .fit = reference.fit,
       .weighting = weighting,
       .noise = result.assessment->noise,
       .structure = result.assessment->structure,
       .g1 = checked.g1,
       .session = checked.session,
       .rig = checked.rig ? &*checked.rig : nullptr});
  if (checked.rig) result.rig = seen_of(*checked.rig);
  result.precision = precision_of(data.g1, reference, checked.g1, checked.session, judged);
  result.gross_errors = checked.found;
}

CalibrationResult calibrate_here(
    const session::Session& session, const CalibrationRequest& request,
    const ProgressCallback& progress, const std::stop_token& stop) {
  PlausibleSession believable = plausible(session);
  const session::Session& believed = believable.session;
  const calibration::MethodChoice method = chosen_method(request.method, "method");
  if (method.identifier == nullptr) {
    throw StudyError(
        StudyErrorCode::kInvalidParams, "'before' is no method to calibrate with",
        {{"param", "method"}}, "Name an identifier, such as lm or ekf_dqpso+anfis.");
  }
  calibration::PipelineSettings settings = settings_of(request);
  const CheckedSession checked = [&] {
    calibration::IdentifySettings judged;
    const std::vector<simulation::Trial> stored = session::trials_of(believed, "G1");
    settings.noise_mm = rig_noise_mm(stored, believed.rig).value_or(settings.noise_mm);
    judged.noise_mm = settings.noise_mm;
    add_too_few_poses(believable.warnings, stored, believed.rig, request.fix, request.free);
    return check_gross_errors(
        believed, judged, !request.keep_gross_errors,
        why_no_reading_is_judged(believable.warnings));
  }();
  add(checked.warnings, believable.warnings);
  const auto positions = [&](std::span<const simulation::Trial> trials) {
    return with_rig_as_seen(
        space_of("positions", trials, checked.session, settings.noise_mm), trials, checked.rig);
  };
  CalibrationData data{
      .session = checked.session, .g1 = positions(checked.g1), .g2 = positions(checked.g2)};
  data.g2.nominal = data.g1.nominal;  // of an instrument's own places those that G1 shows
  if (const auto trouble = calibration::trouble_with(data.g1)) {
    refuse_with_hint(*trouble, checked.g1, session, believed);
  }
  calibration::IdentifySettings judged;
  judged.noise_mm = settings.noise_mm;
  judged.fixed = fixed_parameters(
      data.g1, believed.rig.robot.model->parameter_count(), request.fix, request.free);
  hold_where_it_stands(believed.rig, judged.fixed);
  settings.fixed = judged.fixed;
  if (auto smaller = smaller_fit(believable.warnings, data.g1, judged.fixed)) {
    believable.warnings.push_back(std::move(*smaller));
  }
  const auto reference =
      calibration::identify(*calibration::find_identifier("lm"), data.g1, judged);
  const bool by_paper = method.id == kPaperMethod;
  CalibrationResult result =
      by_paper ? calibrate_by_paper(data, settings, teller(progress), stop)
               : calibrate_by_method(
                     data, method, settings, identify_settings(settings, judged), reference,
                     teller(progress), stop);
  result.created_utc = session::now_utc_text();
  result.inputs = inputs_of(session, settings.seed);
  judge_fit(data, checked, judged, reference, by_paper, result);
  keep_the_robot(believed.rig, result);
  const calibration::ComparisonSettings as_fitted{
      .identify = identify_settings(settings, judged), .residual = residual_settings(settings)};
  result.cross_validation = cross_validated(
      checked.g1, checked.session, checked.rig ? &believed.rig : nullptr,
      registry_method(method, settings.profile), as_fitted, stop);
  judge_fitted(
      result.parameters, *believed.rig.robot.model, data.g1, reference.x,
      request.fix.empty() && request.free.empty(), believable.warnings);
  if (auto turns = turn_errors(
          checked.session, data.g1.nominal.head(std::ssize(result.parameters)),
          result.identified());
      !turns.empty()) {
    result.turn_errors = std::move(turns);
  }
  result.measured_joints = measured_joints_of(checked.g1, believed.rig);
  result.frame = believable.frame;
  result.warnings = std::move(believable.warnings);
  session::Session seen = believed;  // every point, measured by the rig as it is seen
  seen.rig = checked.session.rig;
  result.position_noise_mm = position_noise_mm(seen);
  if (const auto tolerance_mm =
          request.tolerance_mm ? request.tolerance_mm : session.rig.tolerance_mm) {
    result.conformity = conformity_of(result, seen, *tolerance_mm);
  }
  return result;
}

}  // namespace

CalibrationResult calibrate(
    const session::Session& session, const CalibrationRequest& request,
    const ProgressCallback& progress, std::stop_token stop) {
  return cancellable("the calibration", session.name, stop, {}, [&] {
    return calibrate_here(session, request, progress, stop);
  });
}

}  // namespace sixdial::studies
