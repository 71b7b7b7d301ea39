#include "studies/compare.h"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <cmath>

#include "calibration/comparison.h"
#include "calibration/identifiability.h"
#include "calibration/rig_errors.h"
#include "calibration/uncertainty.h"
#include "calibration/workers.h"
#include "session/clock_text.h"
#include "session/trials.h"
#include "studies/assessment.h"
#include "studies/cancellable.h"
#include "studies/error.h"
#include "studies/method_name.h"
#include "studies/own_frame.h"
#include "studies/plausibility_of_fit.h"
#include "studies/seen_rig.h"

namespace sixdial::studies {
namespace {

using calibration::ComparedMethod;
using calibration::Comparison;
using calibration::MethodChoice;

MethodChoice choice_of(const std::string& id) { return chosen_method(id, "methods"); }

std::vector<MethodChoice> choices_of(const CompareRequest& request) {
  std::vector<MethodChoice> choices;
  const auto add = [&](const std::string& id) {
    if (std::ranges::find(choices, id, &MethodChoice::id) == choices.end()) {
      choices.push_back(choice_of(id));
    }
  };
  for (const std::string& id : request.methods) add(id);
  if (request.methods.empty()) {
    for (const std::string_view id : calibration::kComparedMethods) add(std::string(id));
  }
  return choices;
}

calibration::Loss loss_of(const std::string& name) {
  if (name == "huber") return calibration::Loss::kHuber;
  if (name == "cauchy") return calibration::Loss::kCauchy;
  return calibration::Loss::kSquare;
}

calibration::ComparisonSettings settings_of(const CompareRequest& request) {
  calibration::ComparisonSettings settings;
  const calibration::PipelineSettings paper = calibration::settings_for(request.profile);
  calibration::IdentifySettings& identify = settings.identify;
  identify.linearisation = paper.linearisation;
  identify.coordinates = paper.coordinates;
  identify.loss = loss_of(request.loss);
  identify.seed = settings.residual.seed = request.seed;
  identify.threads = calibration::threads_asked(request.threads);
  const auto use = [](const std::optional<int>& asked, int& setting) {
    if (asked && *asked > 0) setting = *asked;
  };
  use(request.particles, identify.qpso1.particles);
  use(request.particles, identify.qpso2.particles);
  use(request.qpso1_iterations, identify.qpso1.iterations);
  use(request.qpso2_iterations, identify.qpso2.iterations);
  use(request.anfis_epochs, settings.residual.anfis.epochs);
  use(request.bpnn_epochs, settings.residual.bpnn_epochs);
  return settings;
}

std::optional<calibration::ErrorStats> stats_of(const calibration::ErrorStats& stats) {
  if (stats.count == 0) return std::nullopt;
  return stats;
}

/// What a method found. Its sd has what the poses and the rig leave open, which no fit of them
/// knows. `by_rig`: covariance that the rig's geometry gives the parameters.
std::vector<std::pair<std::string, ComparedParameter>> parameters_of(
    const calibration::Identified& found, const calibration::ObservationSpace& space,
    const Eigen::MatrixXd& by_rig) {
  const Eigen::MatrixXd covariance =
      found.covariance + calibration::held_covariance(found.fit, space.parameter_info) + by_rig;
  const auto estimates = calibration::parameter_estimates(
      found.fit, space.nominal, covariance, space.parameter_names());
  std::vector<std::pair<std::string, ComparedParameter>> parameters;
  for (std::size_t i = 0; i < estimates.size(); ++i) {
    parameters.emplace_back(
        space.parameter_info[i].name, ComparedParameter{
                                          .value = found.x[static_cast<Eigen::Index>(i)],
                                          .sd = estimates[i].sd,
                                          .partly_held = estimates[i].partly_held});
  }
  return parameters;
}

ComparedRow row_of(
    const ComparedMethod& method, const Comparison& all,
    const calibration::ObservationSpace& space, const Eigen::MatrixXd& by_rig) {
  ComparedRow row{
      .id = method.choice.id,
      .name = method_name(method.choice.id),
      .description = "as the robot is commanded today",
      .g1 = stats_of(method.errors.g1),
      .g2 = stats_of(method.errors.g2),
      .g1_errors_mm = method.errors.g1_mm,
      .g2_errors_mm = method.errors.g2_mm,
      .identify_seconds = method.identify_seconds,
      .residual_seconds = method.residual_seconds};
  if (!method.robot) return row;
  const calibration::IdentifiedRobot& robot = all.robots[*method.robot];
  row.identifier = robot.identifier->name;
  row.description = robot.identifier->description;
  ComparedRobot& found = row.robot.emplace();
  found.status = robot.found.status;
  found.iterations = robot.found.iterations;
  found.objective_rmse_mm = robot.found.rmse;
  found.parameters = parameters_of(robot.found, space, by_rig);
  if (method.choice.residual == nullptr) return row;
  row.residual_model = method.choice.residual->name;
  row.description =
      fmt::format("{}; {}", robot.identifier->description, method.choice.residual->description);
  row.residual = ComparedResidual{
      .note = method.residual.note,
      .effective_parameters = method.residual.effective_parameters};
  return row;
}

/// Lowest mean error on G2 (on G1 where there is no G2) of those that reach every pose.
std::optional<std::string> best_of(const std::vector<ComparedRow>& methods) {
  for (const auto set : {&ComparedRow::g2, &ComparedRow::g1}) {
    const ComparedRow* best = nullptr;
    for (const ComparedRow& method : methods) {
      if (!(method.*set) || (method.*set)->unreachable != 0) continue;
      if (best == nullptr || (method.*set)->mean_mm < (best->*set)->mean_mm) best = &method;
    }
    if (best != nullptr) return best->id;
  }
  return std::nullopt;
}

ComparisonChoices choices_made(
    const CompareRequest& request, const calibration::ComparisonSettings& settings,
    const calibration::ObservationSpace& space) {
  ComparisonChoices choices{
      .space = request.space,
      .loss = request.loss,
      .profile = request.profile,
      .gross_errors_set_aside = !request.keep_gross_errors,
      .noise_mm = settings.identify.noise_mm,
      .hold_uncertainty_mm = settings.identify.hold_uncertainty_mm,
      .first_variance = settings.identify.first_variance,
      .qpso1 = settings.identify.qpso1,
      .qpso2 = settings.identify.qpso2,
      .anfis_epochs = settings.residual.anfis.epochs,
      .bpnn_epochs = settings.residual.bpnn_epochs};
  for (int i = 0; i < space.parameters(); ++i) {
    if (calibration::is_fixed(settings.identify, i)) {
      choices.fixed.emplace_back(space.parameter_info[static_cast<std::size_t>(i)].name);
    }
  }
  return choices;
}

/// Readings that allow no position teach no residual model. `asked`: whether somebody named the
/// methods.
void keep_identifiers(
    std::vector<MethodChoice>& choices, bool asked, const std::string& session) {
  const auto learns = [](const MethodChoice& each) { return each.residual != nullptr; };
  const auto first = std::ranges::find_if(choices, learns);
  if (first == choices.end()) return;
  if (asked) {
    throw StudyError(
        StudyErrorCode::kBadData,
        fmt::format(
            "{} learns from positions, and no sample of G1 of {} has one", first->id, session),
        {{"param", "methods"}}, "Name identifiers alone, such as lm.");
  }
  std::erase_if(choices, learns);
}

[[noreturn]] void refuse(
    const calibration::Trouble& trouble, const std::string& session, std::string hint = "") {
  const bool cancelled = trouble.kind == calibration::Trouble::Kind::kCancelled;
  throw StudyError(
      cancelled ? StudyErrorCode::kCancelled : StudyErrorCode::kBadData, trouble.message,
      {{"session", session}}, std::move(hint));
}

}  // namespace

void check_methods(const std::vector<std::string>& methods) {
  for (const std::string& id : methods) static_cast<void>(choice_of(id));
}

namespace {

Progress as_progress(
    const calibration::ComparisonProgress& now, std::chrono::steady_clock::time_point began) {
  Progress told{
      .stage = now.stage,
      .done = std::llround(100.0 * now.fraction),
      .total = 100,
      .eta_s = time_left_s(began, now.fraction)};
  if (now.best_mm > 0.0) told.best_mm = now.best_mm;
  return told;
}

ComparisonResult compare_here(
    const session::Session& session, const CompareRequest& request,
    const ProgressCallback& progress, const std::stop_token& stop) {
  std::vector<MethodChoice> choices = choices_of(request);
  calibration::ComparisonSettings settings = settings_of(request);
  PlausibleSession believable = plausible(session);
  const session::Session& believed = believable.session;
  const auto first_g1 = session::trials_of(believed, "G1");
  settings.identify.noise_mm =
      rig_noise_mm(first_g1, believed.rig).value_or(settings.identify.noise_mm);

  if (progress) progress({.stage = "check", .done = 0, .total = 100});
  const bool set_aside = !request.keep_gross_errors;
  add_too_few_poses(believable.warnings, first_g1, believed.rig, request.fix, request.free);
  const CheckedSession checked = check_gross_errors(
      believed, settings.identify, set_aside, why_no_reading_is_judged(believable.warnings));
  add(checked.warnings, believable.warnings);
  const auto positions = [&](std::span<const simulation::Trial> trials) {
    return with_rig_as_seen(
        space_of("positions", trials, checked.session, settings.identify.noise_mm), trials,
        checked.rig);
  };
  const auto g1 = positions(checked.g1);
  auto g2 = positions(checked.g2);
  if (g2.parameters() == g1.parameters()) g2.nominal = g1.nominal;  // places of G1 judge G2
  const bool by_readings = request.space == "dials" && g1.samples() == 0;
  if (!by_readings) {
    if (auto trouble = calibration::trouble_with(g1)) {
      refuse(*trouble, session.name, settle_first(session, believed).value_or(""));
    }
  }
  calibration::ObservationSpace space = with_rig_as_seen(
      space_of(request.space, checked.g1, checked.session, settings.identify.noise_mm),
      checked.g1, checked.rig);
  settings.identify.fixed = fixed_parameters(
      space, believed.rig.robot.model->parameter_count(), request.fix, request.free);
  hold_where_it_stands(believed.rig, settings.identify.fixed);

  if (by_readings) keep_identifiers(choices, !request.methods.empty(), session.name);

  const auto tell = [&, began = std::chrono::steady_clock::now()](
                        const calibration::ComparisonProgress& now) {
    if (progress) progress(as_progress(now, began));
  };
  const auto found = calibration::compare_methods(space, g1, g2, choices, settings, tell, stop);
  if (!found) refuse(found.error(), session.name);

  // What the data can tell is judged at the least-squares answer, whether asked for or not.
  const calibration::Identified reference =
      calibration::identify(*calibration::find_identifier("lm"), space, settings.identify);
  ComparisonResult result{
      .created_utc = session::now_utc_text(),
      .inputs = inputs_of(session, request.seed),
      .choices = choices_made(request, settings, space),
      .before_uses_targets = found->before_uses_targets,
      .least_squares_rmse_mm = reference.rmse,
      .assessment = assess(
          space, reference.fit, calibration::weighting_of(space, settings.identify), checked.g1,
          checked.all, checked.session.rig),
      .precision =
          precision_of(space, reference, checked.g1, checked.session, settings.identify),
      .gross_errors = checked.found,
      .seconds = found->seconds};
  const Eigen::MatrixXd by_rig = calibration::rig_covariance(
      space, reference.fit, calibration::weighting_of(space, settings.identify));
  for (const ComparedMethod& method : found->methods) {
    result.methods.push_back(row_of(method, *found, space, by_rig));
  }
  result.best = best_of(result.methods);
  if (checked.rig) result.rig = seen_of(*checked.rig);
  judge_fitted(
      result.assessment.parameters, *believed.rig.robot.model, space, reference.x,
      request.fix.empty() && request.free.empty(), believable.warnings);
  result.warnings = std::move(believable.warnings);
  return result;
}

}  // namespace

ComparisonResult compare(
    const session::Session& session, const CompareRequest& request,
    const ProgressCallback& progress, std::stop_token stop) {
  return cancellable("the comparison", session.name, stop, {}, [&] {
    return compare_here(session, request, progress, stop);
  });
}

}  // namespace sixdial::studies
