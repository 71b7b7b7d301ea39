#include "report/report_run.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <iterator>

#include "geometry/units.h"
#include "report/csv_report.h"
#include "report/documents/calibration_json.h"
#include "report/documents/comparison_json.h"
#include "report/documents/diagnosis_json.h"
#include "report/documents/recommendation_json.h"
#include "report/documents/summary.h"
#include "report/documents/validation_json.h"
#include "report/headline.h"
#include "report/html_report.h"
#include "report/json_report.h"
#include "report/recommended.h"
#include "report/rig_picture.h"
#include "report/sections/rig_section.h"
#include "report/sections/sections_of_studies.h"
#include "report/words/diagnosis_verdict.h"
#include "report/words/diagnosis_words.h"
#include "report/words/rig_words.h"
#include "session/bundle.h"
#include "session/clock_text.h"
#include "session/csv.h"
#include "session/traceability.h"
#include "session/trials.h"
#include "studies/compensate.h"
#include "studies/dial_residuals.h"
#include "studies/live_estimate.h"
#include "studies/method_name.h"
#include "studies/plausibility.h"
#include "studies/position_noise.h"
#include "studies/seen_rig.h"

namespace sixdial::report {
namespace {

std::optional<double> if_finite(double value) {
  return std::isfinite(value) ? std::optional(value) : std::nullopt;
}

void add_times_and_temperatures(report::Head& head, const session::Session& session) {
  std::optional<session::TimePoint> first;
  std::optional<session::TimePoint> last;
  for (const session::Sample& sample : session.samples) {
    if (sample.time_utc) {
      if (last && *sample.time_utc < *last) ++head.times_that_go_back;
      if (!first) first = sample.time_utc;
      last = sample.time_utc;
    }
    if (sample.temperature_c) {
      const double degc = *sample.temperature_c;
      head.temperature_min_c = std::min(head.temperature_min_c.value_or(degc), degc);
      head.temperature_max_c = std::max(head.temperature_max_c.value_or(degc), degc);
    }
  }
  if (const auto within = session::readings_within(session)) {
    head.readings_within_median_ms = within->median_ms;
    head.readings_within_max_ms = within->max_ms;
  }
  if (first) head.measured_from = session::to_iso8601(*first);
  if (last) head.measured_to = session::to_iso8601(*last);
}

std::vector<report::ShownParameter> parameters_of(
    const studies::CalibrationResult& result, const geometry::RobotModel& robot) {
  std::vector<report::ShownParameter> rows;
  for (const studies::ParameterRow& each : result.parameters) {
    const geometry::ShownUnit unit = geometry::shown_unit(each.unit);
    const auto scaled = [&](double value) { return if_finite(value * unit.per_unit); };
    report::ShownParameter row;
    row.name = each.name;
    row.unit = unit.name;
    if (const auto known = robot.find_parameter(each.name)) {
      row.meaning = robot.parameters[static_cast<std::size_t>(*known)].meaning;
    }
    row.nominal = each.nominal * unit.per_unit;
    row.identified = each.identified * unit.per_unit;
    if (!each.fixed) {
      row.sd = scaled(each.sd);
      row.low = scaled(each.low_95);
      row.high = scaled(each.high_95);
    }
    row.held = each.fixed || each.partly_held;
    rows.push_back(std::move(row));
  }
  return rows;
}

/// All samples of the session as the calibration took them, those without a position too;
/// residuals from the result.
std::vector<report::PointRow> points_of(
    const studies::CalibrationResult& result, const session::Session& session) {
  std::vector<report::PointRow> rows;
  std::vector<simulation::Trial> trials(session.samples.size());
  for (simulation::Trial& trial : session::trials_of(session, "")) {
    trials[static_cast<std::size_t>(trial.sample)] = std::move(trial);
  }
  for (std::size_t i = 0; i < session.samples.size(); ++i) {
    const session::Sample& sample = session.samples[i];
    const simulation::Trial& trial = trials[i];
    report::PointRow row;
    row.set = sample.set;
    row.point = sample.point;
    row.repeat = sample.repeat;
    row.left_out = sample.left_out;
    row.q = sample.q;
    if (sample.target_mm) row.target_mm = *sample.target_mm;
    if (trial.position_mm) row.measured_mm = *trial.position_mm;
    row.temperature_c = sample.temperature_c;
    row.time_s = trial.time_s;
    row.approach = trial.approach;
    row.approach.resize(static_cast<std::size_t>(sample.q.size()), 0);
    for (const int dial : trial.position_channels) {
      row.dials += session.rig.dials[static_cast<std::size_t>(dial)].id;
    }
    row.residual_mm.assign(result.methods.size(), std::nullopt);
    rows.push_back(std::move(row));
  }
  for (const studies::PointResiduals& each : result.points) {
    report::PointRow& row = rows.at(static_cast<std::size_t>(each.sample));
    for (std::size_t k = 0; k < row.residual_mm.size() && k < each.residual_mm.size(); ++k) {
      if (each.residual_mm[k]) row.residual_mm[k] = *each.residual_mm[k];
    }
  }
  return rows;
}

void add_data_quality(report::ReportData& data, const session::Session& session) {
  data.samples = static_cast<int>(session.samples.size());
  data.rejected = session.rejected;
  for (const session::Sample& sample : session.samples) {
    for (std::size_t i = 0; i < session.rig.dials.size() && i < sample.channels.size(); ++i) {
      const session::ChannelValue& value = sample.channels[i];
      if (value.quality == session::Quality::kGood) continue;
      data.bad_readings.push_back(
          {.set = sample.set,
           .point = sample.point,
           .repeat = sample.repeat,
           .dial = session.rig.dials[i].id,
           .reason = value.reason,
           .value_mm = value.value});
    }
  }
}

void append(std::vector<report::Section>& to, std::vector<report::Section> sections) {
  to.insert(
      to.end(), std::make_move_iterator(sections.begin()),
      std::make_move_iterator(sections.end()));
}

/// The lines on what was found, in the box that is read first. What is only suspected is named
/// in one line; its own section says the rest.
std::vector<std::string> found_in_box(
    const studies::DiagnosisResult& diagnosis, const DiagnosisVerdict& verdict) {
  std::vector<std::string> found;
  std::vector<std::string> suspected;
  for (const Line& line : verdict.found) {
    if (line.cause && diagnosis.causes[*line.cause].is_only_suspected()) {
      suspected.push_back(capital(named(diagnosis.causes[*line.cause])));
    } else {
      found.push_back(line.text);
    }
  }
  if (!suspected.empty()) {
    found.push_back(fmt::format(
        "Suspected, too weak to act on: {}.{}", fmt::join(suspected, "; "),
        found.empty() ? " Measure again and see whether it comes back." : ""));
  }
  if (gain_row(diagnosis, diagnosis::GainModel::kExtended) != nullptr &&
      !verdict.gain.empty()) {
    found.push_back("What naming gains: " + verdict.gain);
  }
  return found;
}

/// How the rig stands to what its file states: in the box, and as a table where no diagnosis
/// has one.
void add_rig(
    report::ReportData& data, const studies::CalibrationResult& result,
    const session::Session& session, const studies::DiagnosisResult* diagnosis) {
  const auto& by_diagnosis = diagnosis != nullptr ? diagnosis->rig : std::nullopt;
  const bool diagnosed = by_diagnosis && !by_diagnosis->empty();
  const auto& rig = diagnosed ? by_diagnosis : result.rig;
  std::vector<std::string> lines =
      lines_on_rig(rig, session.rig, studies::rig_uncertainty(result));
  if (!lines.empty()) data.also.push_back({"The rig", "cautions", std::move(lines)});
  if (rig && !diagnosed) data.sections.push_back(rig_seen_section(*rig));
}

/// What a diagnosis found, or that there was none (null), in the box that is read first.
void add_diagnosis(report::ReportData& data, const studies::DiagnosisResult* diagnosis) {
  if (diagnosis == nullptr) {
    data.not_judged.push_back(fmt::format(
        "The physical cause of what is left: this session was not diagnosed. \"sixdial "
        "diagnose {}\" does it.",
        data.head.session_name));
    return;
  }
  append(data.sections, diagnosis_sections(*diagnosis, Beside::kCalibration));
  data.cause_remains =
      studies::names_an_effect(*diagnosis) || diagnosis->unexplained.significant;
  DiagnosisVerdict verdict = verdict_in_words(*diagnosis);
  data.also.push_back({"Causes found", "cautions", found_in_box(*diagnosis, verdict)});
  for (Line& line : verdict.to_do) {
    const bool suspected = line.cause && diagnosis->causes[*line.cause].is_only_suspected();
    if (!suspected) data.to_do.push_back(std::move(line.text));
  }
  const bool tied =
      std::ranges::any_of(diagnosis->causes, [](const studies::FoundCause& cause) {
        return cause.kind == studies::CauseKind::kEffect && !is_curve(cause.id) &&
               cause.certainty() == studies::Certainty::kTied;
      });
  if (tied) {
    data.to_do.push_back(fmt::format(
        "\"sixdial plan separate {}\" plans the poses that tell the tied causes apart.",
        data.head.session_name));
  }
  data.not_judged = std::move(verdict.not_judged);
}

/// Samples whose error after kinematics (row `id`) is over kUnusual times the usual (median)
/// one.
void add_outliers(report::ReportData& data, const std::string& id) {
  const auto method = std::ranges::find(data.methods, id, &report::ShownMethod::id);
  if (method == data.methods.end()) return;
  const auto column = static_cast<std::size_t>(method - data.methods.begin());
  std::vector<double> sizes;
  for (const report::PointRow& row : data.points) {
    if (row.residual_mm[column]) sizes.push_back(row.residual_mm[column]->norm());
  }
  if (sizes.empty()) return;
  std::ranges::nth_element(sizes, sizes.begin() + std::ssize(sizes) / 2);
  const double usual_mm = sizes[sizes.size() / 2];
  for (const report::PointRow& row : data.points) {
    if (!row.residual_mm[column]) continue;
    const double size_mm = row.residual_mm[column]->norm();
    if (size_mm <= studies::kUnusual * usual_mm) continue;
    data.facts.stand_out.push_back(
        {.set = row.set,
         .point = row.point,
         .repeat = row.repeat,
         .off_mm = size_mm,
         .times_noise = size_mm / usual_mm});
  }
}

void write_text(
    const std::filesystem::path& folder, const std::string& name, std::string_view text,
    std::vector<std::string>& files) {
  session::write_file((folder / name).string(), text);
  files.push_back(name);
}

}  // namespace

report::Head report_head(
    const studies::Inputs& inputs, std::vector<std::pair<std::string, std::string>> settings,
    const session::Session& session, const std::string& operator_name,
    std::optional<session::TimePoint> made) {
  report::Head head;
  head.session_name = session.name;
  head.rig_name = session.rig.name;
  const geometry::RobotModel& robot_model = *session.rig.robot.model;
  head.robot = robot_model.kind->in_words;
  if (robot_model.modes.size() > 1) {
    head.robot +=
        fmt::format(", working mode {}", robot_model.mode_name(session.rig.robot.working_mode));
  }
  head.traced = session::traceability_of(session.rig_text);
  const session::Traceability& traced = head.traced;
  head.operator_name = traced.operator_name.empty()
                           ? operator_name
                           : fmt::format("{} (as {})", traced.operator_name, operator_name);
  if (const auto* robot = traced.find("robot"); robot != nullptr && !robot->serial.empty()) {
    head.robot += ", serial " + robot->serial;
  }
  head.reported = made ? session::to_iso8601(*made) : session::now_utc_text();
  head.software_version = inputs.version;
  head.data_hash = inputs.data_hash;
  head.rig_hash = inputs.rig_hash;
  head.seed = inputs.seed;
  for (const auto& [name, value] : settings) {
    if (name == "profile") head.profile = value;
  }
  head.settings = std::move(settings);
  add_times_and_temperatures(head, session);
  for (const geometry::Dial& dial : session.rig.dials) {
    report::ShownDial instrument;
    instrument.id = dial.id;
    instrument.description = "digital dial indicator";
    instrument.connection = dial.connection;
    if (const auto* known = traced.find("dial " + dial.id)) instrument.serial = known->serial;
    instrument.resolution_mm = dial.resolution_mm;
    instrument.accuracy_mm = dial.accuracy_mm;
    instrument.repeatability_mm = dial.repeatability_mm;
    instrument.travel_mm = dial.geometry.travel_mm;
    instrument.tip_radius_mm = dial.geometry.tip_radius_mm;
    head.instruments.push_back(std::move(instrument));
  }
  return head;
}

namespace {

studies::Recommendation recommended(
    const studies::CalibrationResult& result, const Companions& companions) {
  return studies::recommend(result, companions.diagnosis, companions.validation);
}

/// The tolerance is asked of the model whose figures are read first. Empty: none is stated.
std::optional<studies::Conformity> conformity_of(
    const ReportData& data, const studies::Recommendation& best,
    const studies::CalibrationResult& result, const session::Session& session,
    const Companions& companions) {
  const std::optional<double> tolerance_mm =
      companions.tolerance_mm ? companions.tolerance_mm
      : result.conformity     ? std::optional(result.conformity->tolerance_mm)
                              : session.rig.tolerance_mm;
  if (!tolerance_mm) return std::nullopt;
  if (data.headline && (data.headline->by_tool_shift || data.measured_again)) {
    const ErrorStatistics& after = data.headline->after;
    return studies::conformity_of_largest(
        session, studies::rig_uncertainty(result), after.max_mm, after.points, *tolerance_mm);
  }
  const bool alone = best.by == studies::CompensateBy::kKinematics;
  return studies::conformity_of(
      result, session, *tolerance_mm,
      alone ? studies::without_residual_model(result.result_method) : result.result_method);
}

}  // namespace

report::ReportData report_data(
    const studies::CalibrationResult& result, const session::Session& session,
    const std::string& operator_name, const Companions& companions) {
  studies::check_same_data(
      result.inputs, session, "calibration",
      "A report shows the samples that were calibrated: calibrate this session.");
  if (companions.diagnosis != nullptr) {
    studies::check_same_data(
        companions.diagnosis->inputs, session, "diagnosis", "Diagnose this session.");
  }
  report::ReportData data = headline_data(result);
  data.head = report_head(
      result.inputs, settings_rows(settings_json(result.settings)), session, operator_name,
      companions.made);
  const geometry::RobotModel& robot = *session.rig.robot.model;
  data.parameters = parameters_of(result, robot);
  for (const geometry::JointInfo& joint : robot.joints) {
    data.joints.push_back({.name = joint.name, .unit = std::string(joint.unit())});
  }
  data.axes = session.rig.instrument.dimensions;
  if (!data.position_noise_mm) data.position_noise_mm = studies::position_noise_mm(session);
  data.convergence = result.convergence;
  data.traces = result.traces;
  // As the calibration took it: in the frame of its parameters, without what it left out.
  session::Session used = studies::plausible(session).session;
  used.rig = studies::rig_as_seen(used.rig, result.rig);
  data.points = points_of(result, used);
  data.dials = studies::dial_residuals(used, result.nominal(), result.identified());
  add_data_quality(data, session);
  data.facts.check = result.gross_errors;
  data.facts.fits = fits_of(result, companions.diagnosis);
  data.facts.stand_out = stand_out_of(result.gross_errors, companions.diagnosis);
  if (!result.gross_errors) {  // of an earlier version of this program
    add_outliers(data, studies::without_residual_model(result.result_method));
  }
  if (companions.comparison != nullptr) {
    append(data.sections, comparison_sections(*companions.comparison));
  }
  append(data.sections, residual_model_sections(result));
  if (result.uncertainty_budgets) {
    append(data.sections, budget_sections(*result.uncertainty_budgets));
  }
  if (result.assessment) {
    append(
        data.sections,
        assessment_sections(*result.assessment, result.precision, !session.rig.dials.empty()));
  }
  add_rig(data, result, session, companions.diagnosis);
  add_diagnosis(data, companions.diagnosis);
  data.sections.push_back(report::rig_section(session.rig));
  const studies::Recommendation best = recommended(result, companions);
  add_recommendation(data, best, result, robot, companions.diagnosis, companions.validation);
  data.conformity = conformity_of(data, best, result, used, companions);
  return data;
}

std::vector<std::string> write_report(
    const studies::CalibrationResult& result, const session::Session& session,
    const std::string& operator_name, const std::filesystem::path& folder,
    const Companions& companions, std::vector<report::Section> more) {
  report::ReportData data = report_data(result, session, operator_name, companions);
  // As found, as left is what such a report is made for: it comes first.
  for (const report::Section& section : more) {
    const auto* words =
        section.blocks.empty() ? nullptr : std::get_if<std::string>(&section.blocks.front());
    if (words != nullptr) data.also.push_back({section.heading, "cautions", {*words}});
  }
  data.sections.insert(
      data.sections.begin(), std::make_move_iterator(more.begin()),
      std::make_move_iterator(more.end()));
  std::error_code trouble;
  std::filesystem::create_directories(folder, trouble);
  if (trouble) {
    throw studies::StudyError(
        studies::StudyErrorCode::kFile,
        fmt::format("cannot make the folder {}: {}", folder.string(), trouble.message()),
        {{"file", folder.string()}});
  }
  std::vector<std::string> files;
  write_text(folder, "report.html", report::html_report(data), files);
  write_text(folder, "report.json", report::json_report(data), files);
  for (const report::CsvFile& table : report::csv_report(data)) {
    write_text(folder, table.name, table.text, files);
  }
  write_text(folder, "calibration.json", to_json(result).dump(1) + "\n", files);
  write_text(
      folder, "recommendation.json", to_json(recommended(result, companions)).dump(1) + "\n",
      files);
  if (companions.comparison != nullptr) {
    write_text(
        folder, "comparison.json", to_json(*companions.comparison).dump(1) + "\n", files);
  }
  if (companions.diagnosis != nullptr) {
    write_text(folder, "diagnosis.json", to_json(*companions.diagnosis).dump(1) + "\n", files);
  }
  if (companions.validation != nullptr) {
    write_text(
        folder, "validation.json", to_json(*companions.validation).dump(1) + "\n", files);
  }
  session::write_bundle(session, folder / "bundle");
  files.insert(files.end(), {"bundle/session.csv", "bundle/rig.toml"});
  return files;
}

}  // namespace sixdial::report
