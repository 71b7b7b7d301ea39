#include "studies/diagnose.h"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <utility>

#include "calibration/crew.h"
#include "diagnosis/command_fit.h"
#include "diagnosis/judging.h"
#include "diagnosis/thresholds.h"
#include "session/clock_text.h"
#include "session/trials.h"
#include "simulation/circumstances.h"
#include "studies/cancellable.h"
#include "studies/diagnosis_causes.h"
#include "studies/diagnosis_curves.h"
#include "studies/extended_command.h"
#include "studies/plausibility_of_fit.h"

namespace sixdial::studies {
namespace {

using diagnosis::Diagnosis;
using diagnosis::Readings;

diagnosis::DiagnosisSettings settings_of(const DiagnosisRequest& request) {
  constexpr int kPosesPerDraw = 10;
  constexpr int kFewestPoses = 200;
  diagnosis::DiagnosisSettings settings;
  settings.null_draws = request.bootstrap;
  settings.gain_draws = std::max(kFewestPoses, kPosesPerDraw * request.bootstrap);
  settings.seed = request.seed;
  settings.with_gain = request.with_gain;
  settings.most_samples = static_cast<std::size_t>(std::max(0, request.most_samples));
  return settings;
}

/// Which samples judge only; none where that would leave nothing to fit.
std::vector<bool> held_out_of(
    const session::Session& session, const std::vector<simulation::Trial>& trials) {
  std::vector<bool> held_out;
  for (const simulation::Trial& trial : trials) {
    held_out.push_back(session.samples[static_cast<std::size_t>(trial.sample)].set == "G2");
  }
  if (std::ranges::find(held_out, false) == held_out.end()) held_out.clear();
  return held_out;
}

/// What robot and named causes leave if nothing smooth and nameless is fitted with them.
Eigen::VectorXd left_without_the_unknown(
    const Readings& readings, const diagnosis::NamedCauses& named) {
  const diagnosis::JointFit& after = named.extended;
  if (named.unknown.empty()) return after.residual_mm;
  const bool curves = !named.dial_curves.empty() || !named.joint_curves.empty();
  if (after.effects.empty() && !curves) return named.baseline.residual_mm;
  // A curve of a dial or a joint is a named cause: its columns stay.
  return diagnosis::fit_jointly(
             readings, after.model, after.effects, &after, named.own_columns(readings.count()))
      .residual_mm;
}

double rms_of_good(const DiagnosedReadings& data) {
  const Eigen::VectorXd& weight = data.after.weight;
  return std::sqrt(weight.dot(data.left_mm.cwiseAbs2()) / std::max(1e-12, weight.sum()));
}

GainRow gain_row_of(const diagnosis::GainRow& row, const Readings& readings) {
  GainRow result{
      .model = row.model,
      .network = row.network,
      .mean_mm = row.mean_mm,
      .std_mm = row.std_mm,
      .max_mm = row.max_mm,
      .rms_mm = row.rms_mm,
      .difference_mm = row.difference_mm,
      .low_mm = row.low_mm,
      .high_mm = row.high_mm,
      .removed_share = row.removed_share};
  if (row.without) result.without = id_of(*row.without);
  for (std::size_t i = 0; i < row.rms_by_dial_mm.size(); ++i) {
    result.rms_by_dial_mm[dial_name(readings, static_cast<int>(i))] = row.rms_by_dial_mm[i];
  }
  return result;
}

Limit limit_from(const diagnosis::Limit& limit) {
  Limit result{
      .id = id_of(limit.hypothesis),
      .parameter = std::string(limit.hypothesis.effect->parameters.front().name),
      .unit = limit.unit,
      .detect = limit.detect,
      .name = limit.name,
      .surviving = limit.surviving,
      .absorbed_by = limit.absorbed_by,
      .plausible = limit.plausible};
  if (limit.rival) result.rival = id_of(*limit.rival);
  return result;
}

FitSummary summary_of(const diagnosis::JointFit& fit) {
  return {
      .noise_mm = fit.s_mm,
      .gross_share = fit.gross_share,
      .fitted = fit.fitted,
      .converged = fit.converged};
}

/// Whether turns of the tool are among the readings.
bool has_turns(const Readings& readings) {
  const auto& channels = readings.model().instrument().channels;
  return std::ranges::any_of(readings.rows(), [&](const diagnosis::Row& row) {
    return channels.at(static_cast<std::size_t>(row.dial)).unit == "rad";
  });
}

/// Something smooth that nobody named, or unequal masses, are fitted beside the causes, and
/// missing from the fit that commands: that one leaves so much more.
double left_sd_mm(const Diagnosis& found) {
  if (found.named.unknown.empty() && found.named.masses.empty()) return 0.0;
  const double all_mm = found.commanding.s_mm;
  const double rest_mm = found.named.extended.s_mm;
  return std::sqrt(std::max(0.0, all_mm * all_mm - rest_mm * rest_mm));
}

ExtendedFit extended_fit_of(const Readings& readings, const Diagnosis& found) {
  ExtendedFit result = commands_of(readings, found.commanding);
  result.rig = found.commanding_rig;
  if (readings.axes() == 3) {
    result.covariance = found.commanding.covariance +
                        diagnosis::covariance_of_unseen(readings, found.commanding);
    result.left_sd_mm = left_sd_mm(found);
    result.turns = has_turns(readings);
  }
  if (found.on_top) {
    result.residual_model = StoredResidualModel{
        .name = std::string(diagnosis::kModelOnTop),
        .note = found.on_top->note,
        .effective_parameters = found.on_top->effective_parameters,
        .saved = found.on_top->saved};
  }
  return result;
}

std::optional<CrossValidation> cross_validation_of(const Diagnosis& found) {
  if (found.choice.empty()) return std::nullopt;
  CrossValidation result{
      .folds = diagnosis::kChoiceFolds, .residual_model = std::string(diagnosis::kModelOnTop)};
  for (const diagnosis::CandidateErrors& each : found.choice) {
    const bool extended = each.model == diagnosis::GainModel::kExtended;
    result.models.push_back(
        {.by = extended ? (each.network ? CompensateBy::kExtendedFull : CompensateBy::kExtended)
                        : (each.network ? CompensateBy::kFull : CompensateBy::kKinematics),
         .error_mm = {each.error_mm.begin(), each.error_mm.end()}});
  }
  return result;
}

Residuals residuals_of(const DiagnosedReadings& data) {
  Residuals result;
  for (Eigen::Index row = 0; row < data.readings.count(); ++row) {
    const diagnosis::Row& each = data.readings.rows()[static_cast<std::size_t>(row)];
    result.sample.push_back(
        data.readings.trials()[static_cast<std::size_t>(each.trial)].sample);
    result.dial.push_back(dial_name(data.readings, each.dial));
    result.measured_mm.push_back(data.readings.measured_mm()[row]);
    result.before_mm.push_back(data.before.residual_mm[row]);
    result.after_mm.push_back(data.left_mm[row]);
    result.good.push_back(data.after.weight[row] > diagnosis::kGoodWeight);
  }
  return result;
}

/// A noise that is not known has no figure and nothing that it was taken from.
diagnosis::Noise known_noise(const diagnosis::Noise& noise) {
  if (noise.sigma_mm > 0.0) return noise;
  return {diagnosis::NoiseSource::kRigFile, std::nan(""), 0};
}

void add_curves(
    DiagnosisResult& result, const Diagnosis& found, const DiagnosedReadings& data) {
  const DiagnosisCurves curves(data);
  for (std::size_t i = 0; i < found.causes.size(); ++i) {
    const diagnosis::Hypothesis& own = found.causes[i].finding.hypothesis;
    if (found.named.swap && own == *found.named.swap) {
      result.causes[i].signature = curves.signature_of_swap(own);
      continue;
    }
    for (std::size_t k = 0; k < data.after.effects.size(); ++k) {
      const simulation::ActiveEffect& active = data.after.effects[k];
      if (active.effect == own.effect && active.place.name == own.place.name) {
        result.causes[i].signature = curves.signature_of(k);
      }
    }
  }
  const auto draw = [&](const auto& each) {
    const auto cause =
        std::ranges::find(result.causes, id_of({each.effect, each.place}), &FoundCause::id);
    if (cause != result.causes.end()) cause->signature = curves.signature_of_curve(each);
  };
  std::ranges::for_each(found.named.dial_curves, draw);
  std::ranges::for_each(found.named.joint_curves, draw);
  result.left_along = curves.left_along();
  result.tool_shifts = curves.tool_shifts();
}

/// Tells stages as they begin, and of a stage that takes long its steps, now and then.
class StageTeller {
 public:
  explicit StageTeller(const ProgressCallback& progress) : progress_(progress) {}

  void stage(const diagnosis::DiagnosisProgress& now) {
    stage_ = now.stage;
    tell({.stage = stage_, .done = now.done, .total = now.total});
  }
  void step(std::string_view what, std::int64_t done, std::int64_t total) {
    constexpr auto kLong = std::chrono::seconds(2);
    if (std::chrono::steady_clock::now() - told_ < kLong) return;
    tell(
        {.stage = stage_.empty() ? std::string(what) : fmt::format("{}: {}", stage_, what),
         .done = done,
         .total = total});
  }

 private:
  void tell(Progress now) {
    told_ = std::chrono::steady_clock::now();
    if (progress_) progress_(std::move(now));
  }

  const ProgressCallback& progress_;
  std::string stage_;
  std::chrono::steady_clock::time_point told_{};
};

DiagnosisResult result_of(
    Diagnosis& found, const DiagnosedReadings& data, const session::Session& session,
    const DiagnosisRequest& request, const diagnosis::DiagnosisSettings& settings) {
  const Readings& readings = data.readings;
  DiagnosisResult result{
      .created_utc = session::now_utc_text(),
      .inputs = inputs_of(session, request.seed),
      .has_dials = readings.has_dials(),
      .settings = settings,
      .causes = causes_of(found, readings),
      .noise = known_noise(found.noise),
      .unexplained =
          {.significant = found.unexplained.significant,
           .scatter = found.unexplained.scatter,
           .scatter_size = found.unexplained.scatter_size,
           .depends_on = std::move(found.unexplained.depends_on),
           .rms_mm = rms_of_good(data),
           .noisy_dials = std::move(found.unexplained.noisy_dials)},
      .dependence = std::move(found.dependence),
      .gross_readings = gross_readings_of(found, readings, session),
      .parameters = std::move(found.parameters),
      .rig = found.rig,
      .baseline = summary_of(found.named.baseline),
      .extended = summary_of(data.after),
      .cross_validation = cross_validation_of(found),
      .judged_on =
          {.samples = found.g2_samples,
           .fitted_samples = found.g1_samples,
           .held_out_by_program = found.held_out_by_program},
      .false_alarm_probability = found.false_alarm_probability,
      .extended_fit = extended_fit_of(readings, found),
      .residuals = residuals_of(data)};
  add_rig_geometry(result.causes, found);
  add_curve_causes(result.causes, found);
  add_data_faults(result.causes, result.gross_readings, result.residuals.sample.size());
  for (const diagnosis::NotTestable& each : found.not_testable) {
    result.not_testable.push_back({id_of(each.hypothesis), each.why});
  }
  for (const diagnosis::Limit& each : found.limits) result.limits.push_back(limit_from(each));
  for (const diagnosis::GainRow& row : found.gain) {
    result.gain.push_back(gain_row_of(row, readings));
  }
  return result;
}

/// One exchanged pair is a cause of the catalogue: it is found and named as all others are.
void exchange_back(session::Session& session, const std::pair<std::size_t, std::size_t>& pair) {
  for (session::Sample& sample : session.samples) {
    if (std::max(pair.first, pair.second) >= sample.channels.size()) continue;
    std::swap(sample.channels[pair.first], sample.channels[pair.second]);
  }
}

/// Where a named cause goes by the side that a joint came from, and nobody recorded the sides.
void add_sides_from_rows(const Diagnosis& found, std::vector<Warning>& warnings) {
  const Readings& readings = *found.readings;
  const auto from = simulation::sides_from(readings.model().robot(), readings.trials());
  std::string joints;
  for (const diagnosis::Cause& cause : found.causes) {
    const diagnosis::Hypothesis& each = cause.finding.hypothesis;
    if ((each.effect->needs & simulation::kApproach) == 0 || each.place.joint < 0) continue;
    if (from[static_cast<std::size_t>(each.place.joint)] != simulation::SidesFrom::kRows)
      continue;
    joints += fmt::format("{}joint {}", joints.empty() ? "" : " and ", each.place.joint + 1);
  }
  if (joints.empty()) return;
  warnings.push_back(
      {"sides_from_rows",
       Severity::kNote,
       {.file = "session.csv", .field = "approach"},
       {{"joints", joints}}});
}

void add_samples_drawn(const Diagnosis& found, std::vector<Warning>& warnings) {
  if (found.drawn_of == 0) return;
  warnings.push_back(
      {"samples_drawn",
       Severity::kNote,
       {.file = "session.csv"},
       {{"drawn", static_cast<double>(found.g1_samples + found.g2_samples)},
        {"samples", static_cast<double>(found.drawn_of)}}});
}

}  // namespace

namespace {

/// One pose measured a hundred times says nothing of the robot.
void refuse_too_few_poses(
    const std::vector<simulation::Trial>& trials, const std::vector<bool>& held_out,
    const session::Session& session) {
  std::vector<simulation::Trial> fitted;
  for (std::size_t i = 0; i < trials.size(); ++i) {
    if (held_out.empty() || !held_out[i]) fitted.push_back(trials[i]);
  }
  const geometry::Rig& rig = session.rig;
  const auto few = too_few_poses(fitted, rig, rig.robot.model->parameter_count());
  if (!few || fitted.empty()) return;
  throw StudyError(
      StudyErrorCode::kBadData,
      fmt::format(
          "the samples that are fitted stand at {} different poses; a diagnosis needs {} at "
          "least",
          std::get<double>(few->parts.at("poses")), std::get<double>(few->parts.at("needed"))),
      {{"session", session.name}}, "Measure more points all over the workspace.");
}

DiagnosisResult diagnose_here(
    const session::Session& session, const DiagnosisRequest& request, StageTeller& tell_stage,
    const std::stop_token& stop) {
  const auto began = std::chrono::steady_clock::now();
  PlausibleSession believable = plausible(session);
  session::Session& believed = believable.session;
  if (const auto pair = exchanged_pair(believable)) exchange_back(believed, *pair);
  const simulation::ForwardModel model(believed.rig);
  std::vector<simulation::Trial> trials = session::trials_of(believed, "");
  std::vector<bool> held_out = held_out_of(believed, trials);
  refuse_too_few_poses(trials, held_out, believed);
  const diagnosis::DiagnosisSettings settings = settings_of(request);
  const auto tell = [&](const diagnosis::DiagnosisProgress& now) { tell_stage.stage(now); };
  Diagnosis found;
  try {
    found = diagnosis::diagnose(
        model, std::move(trials), std::move(held_out), settings, tell, stop);
  } catch (const std::invalid_argument& error) {
    throw StudyError(
        StudyErrorCode::kBadData, error.what(), {{"session", session.name}},
        settle_first(session, believed)
            .value_or(
                "Measure more points, or check the rig file: a reading counts only while its "
                "plunger is inside its travel."));
  }
  geometry::check_end();
  const DiagnosedReadings data{
      *found.readings, found.named.baseline, found.named.extended,
      left_without_the_unknown(*found.readings, found.named), !found.named.unknown.empty()};
  DiagnosisResult result = result_of(found, data, session, request, settings);
  geometry::check_end();
  add_curves(result, found, data);
  const Eigen::VectorXd& nominal = believed.rig.robot.nominal;
  result.extended_fit.nominal = std::vector<double>(nominal.begin(), nominal.end());
  result.extended_fit.measured_joints =
      measured_joints_of(session::trials_of(believed, ""), believed.rig);
  result.extended_fit.frame = believable.frame;
  result.warnings = believable.warnings;
  add_sides_from_rows(found, *result.warnings);
  add_samples_drawn(found, *result.warnings);
  result.seconds =
      std::chrono::duration<double>(std::chrono::steady_clock::now() - began).count();
  geometry::check_end();
  return result;
}

}  // namespace

DiagnosisResult diagnose(
    const session::Session& session, const DiagnosisRequest& request,
    const ProgressCallback& progress, std::stop_token stop) {
  StageTeller tell(progress);
  return cancellable(
      "the diagnosis", session.name, stop,
      [&](std::string_view what, std::int64_t done, std::int64_t total) {
        tell.step(what, done, total);
      },
      [&] {
        const calibration::Crew crew(calibration::threads_asked(request.threads));
        return diagnose_here(session, request, tell, stop);
      });
}

}  // namespace sixdial::studies
