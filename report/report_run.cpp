#include "report/report_run.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <iterator>

#include "report/csv_report.h"
#include "report/documents/comparison_json.h"
#include "report/documents/diagnosis_json.h"
#include "report/html_report.h"
#include "report/json_report.h"
#include "report/rig_picture.h"
#include "report/sections/sections_of_studies.h"
#include "report/words/diagnosis_verdict.h"
#include "report/words/diagnosis_words.h"
#include "session/bundle.h"
#include "session/clock_text.h"
#include "session/csv.h"
#include "session/trials.h"
#include "studies/assessment.h"
#include "studies/calibrate.h"
#include "studies/dial_residuals.h"
#include "studies/network_json.h"

namespace sixdial::report {
namespace {

std::optional<double> number_or_none(const Json& json, const char* key) {
  const auto found = json.find(key);
  if (found == json.end() || !found->is_number()) return std::nullopt;
  return found->get<double>();
}

std::optional<Eigen::Vector2d> point_of(const Json& json) {
  if (!json.is_array() || json.size() != 2 || !json[0].is_number()) return std::nullopt;
  return Eigen::Vector2d(json[0].get<double>(), json[1].get<double>());
}

void check_belongs_together(const Json& document, const session::Session& session) {
  if (document.value("schema", "") != "sixdial.calibration" ||
      document.value("schema_version", 0) != studies::kCalibrationSchemaVersion) {
    throw studies::Error(
        studies::ErrorCode::kBadData,
        fmt::format(
            "a report needs a sixdial.calibration document of version {}, this is {} {}",
            studies::kCalibrationSchemaVersion, document.value("schema", "nothing known"),
            document.value("schema_version", 0)),
        {{"session", session.name}}, "Calibrate the session again.");
  }
  const std::string now = "sha256:" + session::data_sha256(session);
  if (document["inputs"]["data_hash"] != now) {
    throw studies::Error(
        studies::ErrorCode::kBadData,
        fmt::format(
            "the session {} has other data than the result was made from", session.name),
        {{"session", session.name}}, "Samples came after the calibration: calibrate again.");
  }
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

/// name -> value of every leaf, "anfis.epochs".
void flatten(
    const Json& json, const std::string& prefix,
    std::vector<std::pair<std::string, std::string>>& rows) {
  for (const auto& [key, value] : json.items()) {
    const std::string name = prefix.empty() ? key : prefix + "." + key;
    if (value.is_object()) {
      flatten(value, name, rows);
    } else {
      rows.emplace_back(name, value.is_string() ? value.get<std::string>() : value.dump());
    }
  }
}

std::vector<report::ParameterRow> parameters_of(const Json& document) {
  std::vector<report::ParameterRow> rows;
  for (std::size_t i = 0; i < document["parameters"].size(); ++i) {
    const Json& each = document["parameters"][i];
    const geometry::ParameterInfo& info = geometry::kParameters.at(i);
    const double shown = info.shown_per_unit;
    const auto scaled = [&](const char* key) -> std::optional<double> {
      const auto value = number_or_none(each, key);
      return value ? std::optional(*value * shown) : std::nullopt;
    };
    const bool fixed = each["fixed"].get<bool>();
    report::ParameterRow row;
    row.name = info.name;
    row.unit = info.shown_unit;
    row.nominal = scaled("nominal").value_or(std::nan(""));
    row.identified = scaled("identified").value_or(std::nan(""));
    if (!fixed) {
      row.sd = scaled("sd");
      row.low = scaled("low_95");
      row.high = scaled("high_95");
    }
    row.held = fixed || each["partly_held"].get<bool>();
    rows.push_back(std::move(row));
  }
  return rows;
}

std::optional<report::ErrorStatistics> statistics_of(const Json& json) {
  if (!json.is_object()) return std::nullopt;
  report::ErrorStatistics statistics;
  statistics.mean_mm = json["mean_mm"].get<double>();
  statistics.std_mm = number_or_none(json, "std_mm").value_or(std::nan(""));
  statistics.max_mm = json["max_mm"].get<double>();
  statistics.mean_low_mm = number_or_none(json, "mean_low_mm");
  statistics.mean_high_mm = number_or_none(json, "mean_high_mm");
  statistics.points = json["points"].get<int>();
  return statistics;
}

std::vector<report::Method> methods_of(const Json& document) {
  constexpr std::array<std::string_view, 3> kOnMap{"before", "ekf_dqpso", "ekf_dqpso+anfis"};
  std::vector<report::Method> methods;
  for (const Json& each : document["methods"]) {
    report::Method method;
    method.id = each["id"].get<std::string>();
    method.name = each["name"].get<std::string>();
    method.g1 = statistics_of(each["g1"]);
    method.g2 = statistics_of(each["g2"]);
    method.seconds = number_or_none(each, "seconds");
    method.has_residual_model = method.id.find('+') != std::string::npos;
    method.on_map = std::ranges::find(kOnMap, method.id) != kOnMap.end();
    methods.push_back(std::move(method));
  }
  return methods;
}

/// All samples of the session, those without a position too; residuals from the document.
std::vector<report::PointRow> points_of(const Json& document, const session::Session& session) {
  const std::size_t methods = document["methods"].size();
  std::vector<report::PointRow> rows;
  const std::vector<simulation::Trial> trials = session::trials_of(session, "");
  for (std::size_t i = 0; i < session.samples.size(); ++i) {
    const session::Sample& sample = session.samples[i];
    const simulation::Trial& trial = trials.at(i);
    report::PointRow row;
    row.set = sample.set;
    row.point = sample.point;
    row.repeat = sample.repeat;
    row.q_rad = sample.q;
    if (sample.target_mm) row.target_mm = *sample.target_mm;
    if (trial.position_mm) row.measured_mm = *trial.position_mm;
    row.temperature_c = sample.temperature_c;
    row.time_s = trial.time_s;
    row.approach = trial.approach;
    for (const int dial : trial.position_channels) {
      row.dials += session.rig.dials[static_cast<std::size_t>(dial)].id;
    }
    row.residual_mm.assign(methods, std::nullopt);
    rows.push_back(std::move(row));
  }
  for (const Json& each : document["points"]) {
    report::PointRow& row = rows.at(each["sample"].get<std::size_t>());
    for (std::size_t method = 0; method < methods; ++method) {
      row.residual_mm[method] = point_of(each["residual_mm"][method]);
    }
  }
  return rows;
}

void add_swarms(report::ReportData& data, const Json& document) {
  for (const Json& each : document["convergence"]) {
    report::Convergence swarm;
    swarm.name = each["name"].get<std::string>();
    for (const Json& best : each["best_mm"]) {
      swarm.best_mm.push_back(best.is_number() ? best.get<double>() : std::nan(""));
    }
    data.convergence.push_back(std::move(swarm));
  }
  for (const Json& each : document["traces"]) {
    report::ParameterTrace trace;
    trace.name = each["name"].get<std::string>();
    trace.step = each["step"].get<std::string>();
    for (const Json& error : each["error"]) {
      geometry::ParameterVector values;
      for (int i = 0; i < geometry::kParameterCount; ++i) {
        values[i] = error.at(static_cast<std::size_t>(i)).get<double>();
      }
      trace.error.push_back(values);
    }
    data.traces.push_back(std::move(trace));
  }
}

void add_data_quality(report::ReportData& data, const session::Session& session) {
  data.samples = static_cast<int>(session.samples.size());
  for (const session::RejectedRow& row : session.rejected) {
    data.rejected.push_back({.line = row.line, .reason = row.reason});
  }
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

/// What a diagnosis found, or that there was none (null), in the box that is read first.
void add_diagnosis(report::ReportData& data, const studies::DiagnosisResult* diagnosis) {
  if (diagnosis == nullptr) {
    data.not_judged.push_back(fmt::format(
        "The physical cause of what is left: this session was not diagnosed. \"sixdial "
        "diagnose {}\" does it.",
        data.head.session_name));
    return;
  }
  append(data.sections, diagnosis_sections(*diagnosis));
  DiagnosisVerdict verdict = verdict_in_words(*diagnosis);
  data.also.push_back({"Causes found", "cautions", found_in_box(*diagnosis, verdict)});
  for (Line& line : verdict.to_do) {
    const bool suspected = line.cause && diagnosis->causes[*line.cause].is_only_suspected();
    if (!suspected) data.to_do.push_back(std::move(line.text));
  }
  const bool tied =
      std::ranges::any_of(diagnosis->causes, [](const studies::FoundCause& cause) {
        return cause.certainty() == studies::Certainty::kTied;
      });
  if (tied) {
    data.to_do.push_back(fmt::format(
        "\"sixdial plan separate {}\" plans the poses that tell the tied causes apart.",
        data.head.session_name));
  }
  data.not_judged = std::move(verdict.not_judged);
}

/// Samples whose error after kinematics is over six times the usual (median) one.
void add_outliers(report::ReportData& data) {
  constexpr double kTimesUsual = 6.0;
  const auto method = std::ranges::find(data.methods, "ekf_dqpso", &report::Method::id);
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
    if (size_mm <= kTimesUsual * usual_mm) continue;
    data.outliers.push_back(
        {.set = row.set,
         .point = row.point,
         .repeat = row.repeat,
         .dial = {},
         .residual_mm = size_mm,
         .times_usual = size_mm / usual_mm});
  }
}

void add_gross_errors(report::ReportData& data, const Json& gross_errors) {
  for (const Json& each : gross_errors["found"]) {
    data.outliers.push_back(
        {.set = each["set"].get<std::string>(),
         .point = each["point"].get<int>(),
         .repeat = each["repeat"].get<int>(),
         .dial = each["dial"].is_string() ? each["dial"].get<std::string>() : std::string(),
         .residual_mm = each["size_mm"].get<double>(),
         .times_usual = each["times_sigma"].get<double>()});
  }
}

std::optional<double> position_noise(const session::Session& session) {
  double sum_mm2 = 0.0;
  int count = 0;
  for (const session::Sample& sample : session.samples) {
    const simulation::Trial trial = session::trial_of(session.rig, sample);
    if (!trial.position_mm || trial.position_channels.empty()) continue;
    sum_mm2 += trial.position_covariance.trace();
    ++count;
  }
  if (count == 0) return std::nullopt;
  return std::sqrt(sum_mm2 / count);
}

void write_text(
    const std::filesystem::path& folder, const std::string& name, std::string_view text,
    std::vector<std::string>& files) {
  session::write_file((folder / name).string(), text);
  files.push_back(name);
}

}  // namespace

report::Head report_head(
    const Json& document, const session::Session& session, const std::string& operator_name) {
  const Json& inputs = document["inputs"];
  report::Head head;
  head.session_name = session.name;
  head.rig_name = session.rig.name;
  head.robot = fmt::format(
      "planar five-bar, working mode {}", geometry::to_string(session.rig.robot.working_mode));
  head.operator_name = operator_name;
  head.reported = session::now_utc_text();
  head.software_version = inputs["version"].get<std::string>();
  head.data_hash = inputs["data_hash"].get<std::string>();
  head.rig_hash = inputs["rig_hash"].get<std::string>();
  head.seed = inputs["seed"].get<std::uint64_t>();
  head.profile = inputs["settings"].value("profile", "");
  flatten(inputs["settings"], "", head.settings);
  add_times_and_temperatures(head, session);
  for (const geometry::Dial& dial : session.rig.dials) {
    report::Instrument instrument;
    instrument.id = dial.id;
    instrument.description = "digital dial indicator";
    instrument.connection = dial.connection;
    instrument.resolution_mm = dial.resolution_mm;
    instrument.accuracy_mm = dial.accuracy_mm;
    instrument.repeatability_mm = dial.repeatability_mm;
    instrument.travel_mm = dial.geometry.travel_mm;
    instrument.tip_radius_mm = dial.geometry.tip_radius_mm;
    head.instruments.push_back(std::move(instrument));
  }
  return head;
}

report::ReportData report_data(
    const Json& document, const session::Session& session, const std::string& operator_name,
    const Json& comparison, const Json& diagnosis) {
  check_belongs_together(document, session);
  report::ReportData data;
  data.head = report_head(document, session, operator_name);
  data.parameters = parameters_of(document);
  const Json& identification = document["identification"];
  for (const Json& each : identification["correlations"]) {
    data.correlations.push_back(
        {each["first"].get<std::string>(), each["second"].get<std::string>(),
         each["coefficient"].get<double>()});
  }
  data.singular_values = identification["singular_values"].get<std::vector<double>>();
  data.condition_number = number_or_none(identification, "condition");
  for (const Json& each : identification["held"]) {
    data.unidentifiable.push_back(each["words"].get<std::string>());
  }
  data.methods = methods_of(document);
  data.result_method = document["result_method"].get<std::string>();
  data.position_noise_mm = position_noise(session);
  data.rmse_mm = number_or_none(document, "rmse_mm");
  data.least_squares_rmse_mm = number_or_none(document, "least_squares_rmse_mm");
  add_swarms(data, document);
  data.points = points_of(document, session);
  geometry::ParameterVector identified;
  for (int i = 0; i < geometry::kParameterCount; ++i) {
    identified[i] =
        document["parameters"].at(static_cast<std::size_t>(i))["identified"].get<double>();
  }
  data.dials = studies::dial_residuals(session, session.rig.robot.nominal, identified);
  add_data_quality(data, session);
  if (document.contains("gross_errors")) {
    add_gross_errors(data, document["gross_errors"]);
  } else {
    add_outliers(data);
  }
  if (comparison.is_object()) {
    append(data.sections, comparison_sections(comparison_from_json(comparison)));
  }
  // Results of earlier versions do not say how many samples a network rests on.
  if (document.contains("anfis") && document["anfis"]["x"].contains("samples")) {
    append(data.sections, anfis_sections(document["anfis"]));
  }
  if (document.contains("assessment")) {
    append(
        data.sections,
        assessment_sections(
            document["assessment"], document["precision"], document["gross_errors"]));
  }
  if (diagnosis.is_object()) {
    const studies::DiagnosisResult found = diagnosis_from_json(diagnosis);
    add_diagnosis(data, &found);
  } else {
    add_diagnosis(data, nullptr);
  }
  data.sections.push_back(report::rig_section(session.rig));
  return data;
}

std::vector<std::string> write_report(
    const Json& document, const session::Session& session, const std::string& operator_name,
    const std::filesystem::path& folder, const Json& comparison, const Json& diagnosis,
    std::vector<report::Section> more) {
  report::ReportData data =
      report_data(document, session, operator_name, comparison, diagnosis);
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
    throw studies::Error(
        studies::ErrorCode::kFile,
        fmt::format("cannot make the folder {}: {}", folder.string(), trouble.message()),
        {{"file", folder.string()}});
  }
  std::vector<std::string> files;
  write_text(folder, "report.html", report::html_report(data), files);
  write_text(folder, "report.json", report::json_report(data), files);
  for (const report::CsvFile& table : report::csv_report(data)) {
    write_text(folder, table.name, table.text, files);
  }
  write_text(folder, "calibration.json", document.dump(1) + "\n", files);
  if (comparison.is_object()) {
    write_text(folder, "comparison.json", comparison.dump(1) + "\n", files);
  }
  if (diagnosis.is_object()) {
    write_text(folder, "diagnosis.json", diagnosis.dump(1) + "\n", files);
  }
  session::write_bundle(session, folder / "bundle");
  files.insert(files.end(), {"bundle/session.csv", "bundle/rig.toml"});
  return files;
}

}  // namespace sixdial::report
