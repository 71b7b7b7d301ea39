#include "studies/diagnose.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <chrono>
#include <cmath>

#include "diagnosis/diagnosis.h"
#include "session/bundle.h"
#include "session/clock_text.h"
#include "session/trials.h"
#include "studies/diagnosis_curves.h"
#include "studies/diagnosis_words.h"

namespace sixdial::studies {
namespace {

using diagnosis::Cause;
using diagnosis::Diagnosis;
using diagnosis::Hypothesis;

/// JSON has no infinity and no NaN.
Json finite(double value) { return std::isfinite(value) ? Json(value) : Json(nullptr); }

Json place_json(const Hypothesis& hypothesis) {
  return {{"cause", std::string(hypothesis.effect->cause)}, {"where", hypothesis.place.name}};
}

/// What stands for a row's dial: its id, or "x" and "y" where a session has positions only.
std::string dial_of(const diagnosis::Readings& readings, const diagnosis::Row& row) {
  if (!readings.has_dials()) return row.dial == 0 ? "x" : "y";
  return readings.model().rig().dials[static_cast<std::size_t>(row.dial)].id;
}

Json estimate_json(
    const std::string& name, double value, const std::string& unit, const Json& sd) {
  return {{"name", name}, {"value", finite(value)}, {"unit", unit}, {"sd", sd}};
}

Json cause_json(const Cause& cause) {
  const diagnosis::Finding& finding = cause.finding;
  const simulation::Effect& effect = *finding.hypothesis.effect;
  Json json = place_json(finding.hypothesis);
  json["certainty"] = finding.certain() ? "certain" : "tied";
  json["tied_with"] = Json::array();
  for (const diagnosis::Rival& rival : finding.tied_with) {
    Json each = place_json(rival.hypothesis);
    each["log_odds"] = finite(rival.log_odds);
    json["tied_with"].push_back(std::move(each));
  }
  if (!finding.tied_with_unknown.empty()) {
    json["tied_with"].push_back(
        {{"cause", "unknown"},
         {"where", fmt::format("{}", fmt::join(finding.tied_with_unknown, ", "))},
         {"log_odds", finite(finding.unknown_log_odds)}});
  }
  if (finding.tied_with_nothing) {
    json["tied_with"].push_back(
        {{"cause", "none"}, {"where", ""}, {"log_odds", finite(finding.evidence)}});
  }
  json["estimate"] = Json::array();
  for (const diagnosis::Estimate& each : cause.estimate) {
    json["estimate"].push_back(
        estimate_json(each.name, each.value, each.unit, finite(each.sd)));
  }
  json["delta_bic"] = finite(cause.delta_bic);
  json["gain"] = finite(cause.gain_mm);
  json["standing"] = cause.confirmed ? "confirmed" : "suspected";
  json["on_g1"] = cause.on_g1;
  json["g2_log_odds"] = finite(cause.g2_log_odds);
  json["visible_ratio"] = finite(cause.visible_ratio);
  json["signature"] = std::string(effect.signature);
  json["consequence"] = std::string(effect.consequence);
  json["advice"] = std::string(effect.advice);
  json["why_not_learned"] = std::string(effect.why_not_learned);
  json["in_words"] = named(json);
  json["size_in_words"] = size_in_words(json);
  return json;
}

/// Whether so many of the gross readings equal the one before by accident: each does with the
/// chance that an error of its size ends within half a digit of that value.
bool handed_over_twice(
    const diagnosis::Readings& readings, const std::vector<diagnosis::GrossReading>& gross) {
  constexpr double kByAccident = 1e-3;
  double expected = 0.0;
  int stale = 0;
  for (const diagnosis::GrossReading& each : gross) {
    const auto dial =
        static_cast<std::size_t>(readings.rows()[static_cast<std::size_t>(each.row)].dial);
    const double resolution_mm =
        readings.has_dials() ? readings.model().rig().dials[dial].resolution_mm : 0.0;
    expected += std::min(1.0, resolution_mm / (2.0 * std::abs(each.size_mm)));
    stale += each.stale ? 1 : 0;
  }
  if (stale == 0) return false;
  // P(X >= stale), X of a Poisson law.
  double term = std::exp(-expected);
  double below = term;
  for (int k = 1; k < stale; ++k) {
    term *= expected / k;
    below += term;
  }
  return 1.0 - below < kByAccident;
}

Json data_fault(
    const char* cause, const std::vector<double>& sizes_mm, const char* signature,
    const char* consequence, const char* advice) {
  double squares = 0.0;
  for (const double size : sizes_mm) squares += size * size;
  const auto count = static_cast<double>(sizes_mm.size());
  Json json{
      {"cause", cause},
      {"where", "samples"},
      {"certainty", "certain"},
      {"tied_with", Json::array()},
      {"estimate",
       {estimate_json("count", count, "1", nullptr),
        estimate_json("size_rms", std::sqrt(squares / count), "mm", nullptr)}},
      {"delta_bic", nullptr},
      {"gain", nullptr},
      {"standing", "confirmed"},
      {"on_g1", nullptr},
      {"g2_log_odds", nullptr},
      {"visible_ratio", nullptr},
      {"signature", signature},
      {"consequence", consequence},
      {"advice", advice},
      {"why_not_learned", ""},
      {"signature_plot", nullptr}};
  json["in_words"] = named(json);
  json["size_in_words"] = size_in_words(json);
  return json;
}

void add_gross_readings(
    Json& document, const Diagnosis& found, const diagnosis::Readings& readings,
    const session::Session& session) {
  const bool twice = handed_over_twice(readings, found.identified.gross);
  std::vector<double> stale;
  std::vector<double> outliers;
  Json list = Json::array();
  for (const diagnosis::GrossReading& each : found.identified.gross) {
    const diagnosis::Row& row = readings.rows()[static_cast<std::size_t>(each.row)];
    const int index = readings.trials()[static_cast<std::size_t>(row.trial)].sample;
    const session::Sample& sample = session.samples[static_cast<std::size_t>(index)];
    const bool is_stale = twice && each.stale;
    (is_stale ? stale : outliers).push_back(each.size_mm);
    list.push_back(
        {{"sample", index},
         {"set", sample.set},
         {"point", sample.point},
         {"repeat", sample.repeat},
         {"dial", dial_of(readings, row)},
         {"size_mm", finite(each.size_mm)},
         {"stale", is_stale},
         {"near_edge", each.near_edge}});
  }
  if (!outliers.empty()) {
    document["causes"].push_back(data_fault(
        "outliers", outliers,
        "Single readings that are far from everything else; their neighbours are not.",
        "None on parts, as they are not fitted; if they were, they would pull the parameters.",
        "Nothing, if they are few. Else look at the dials in the list: cable, battery, dirt on "
        "the face, a tip that leaves the face at its edge."));
  }
  if (!stale.empty()) {
    document["causes"].push_back(data_fault(
        "stale_reading", stale,
        "A reading is the same, digit for digit, as at the sample before, though the tool had "
        "moved.",
        "None on parts, as they are not fitted.",
        "Let the dial's connection ask for a new value at each sample; look at its time stamps "
        "and time-outs."));
  }
  document["gross_readings"] = std::move(list);
}

/// How far the two dials' readings are from each other [mm].
double exchanged_rms(const diagnosis::Readings& readings, const Hypothesis& swap) {
  double squares = 0.0;
  int count = 0;
  for (const simulation::Trial& trial : readings.trials()) {
    const auto& one = trial.reading[static_cast<std::size_t>(swap.place.dial)];
    const auto& other = trial.reading[static_cast<std::size_t>(swap.place.other_dial)];
    if (!one || !other) continue;
    squares += (*one - *other) * (*one - *other);
    ++count;
  }
  return std::sqrt(squares / std::max(1, count));
}

Json gain_row_json(const diagnosis::GainRow& row, const diagnosis::Readings& readings) {
  Json by_dial = Json::object();
  const auto& dials = readings.model().rig().dials;
  for (std::size_t i = 0; i < row.rms_by_dial_mm.size(); ++i) {
    const std::string name = !readings.has_dials() ? (i == 0 ? "x" : "y")
                             : i < dials.size()    ? dials[i].id
                                                   : std::string();
    if (!name.empty()) by_dial[name] = finite(row.rms_by_dial_mm[i]);
  }
  return {
      {"name", row.name},
      {"without", row.without},
      {"mean_mm", finite(row.mean_mm)},
      {"std_mm", finite(row.std_mm)},
      {"max_mm", finite(row.max_mm)},
      {"rms_mm", finite(row.rms_mm)},
      {"rms_by_dial_mm", std::move(by_dial)},
      {"difference_mm", finite(row.difference_mm)},
      {"low_mm", finite(row.low_mm)},
      {"high_mm", finite(row.high_mm)},
      {"removed_share", finite(row.removed_share)}};
}

Json limit_json(const diagnosis::Limit& limit) {
  Json json = place_json(limit.hypothesis);
  json["detect"] = finite(limit.detect);
  json["name"] = finite(limit.name);
  json["unit"] = limit.unit;
  json["parameter"] = std::string(limit.hypothesis.effect->parameters.front().name);
  json["rival"] = limit.rival;
  json["surviving"] = finite(limit.surviving);
  json["absorbed_by"] = limit.absorbed_by;
  json["plausible"] = finite(limit.plausible);
  json["reason"] = nullptr;
  if (!std::isfinite(limit.detect)) {
    json["reason"] = fmt::format(
        "at no size: {} take it over on these poses", fmt::join(limit.absorbed_by, ", "));
  } else if (!std::isfinite(limit.name)) {
    json["reason"] =
        fmt::format("seen, but at no size told from {} on these poses", limit.rival);
  }
  return json;
}

void add_parameters(Json& document, const Diagnosis& found) {
  Json baseline = Json::array();
  Json extended = Json::array();
  for (const diagnosis::ParameterChange& each : found.parameters) {
    baseline.push_back(
        {{"name", each.name},
         {"unit", each.unit},
         {"nominal", finite(each.nominal)},
         {"value", finite(each.baseline)},
         {"sd", finite(each.baseline_sd)}});
    const double moved = each.extended - each.baseline;
    extended.push_back(
        {{"name", each.name},
         {"unit", each.unit},
         {"nominal", finite(each.nominal)},
         {"value", finite(each.extended)},
         {"sd", finite(each.extended_sd)},
         {"moved", finite(moved)},
         {"moved_sigma",
          each.baseline_sd > 0.0 ? finite(moved / each.baseline_sd) : Json(nullptr)}});
  }
  const auto fit_json = [](Json parameters, const diagnosis::JointFit& fit) {
    return Json{
        {"parameters", std::move(parameters)},
        {"noise_mm", finite(fit.s_mm)},
        {"gross_share", finite(fit.gross_share)},
        {"fitted", fit.fitted},
        {"converged", fit.converged}};
  };
  document["baseline"] = fit_json(std::move(baseline), found.identified.baseline);
  document["extended"] = fit_json(std::move(extended), found.identified.extended);
}

/// What commanding needs: numbers of the fit, and what the last sample knew of time and
/// temperature.
Json extended_model_json(const diagnosis::Readings& readings, const diagnosis::JointFit& fit) {
  Json effects = Json::array();
  for (const simulation::ActiveEffect& active : fit.effects) {
    effects.push_back(
        {{"cause", std::string(active.effect->cause)},
         {"where", active.place.name},
         {"x", active.x}});
  }
  const simulation::Circumstance& last = readings.circumstances().back();
  return {
      {"model", std::vector<double>(fit.model.begin(), fit.model.end())},
      {"effects", std::move(effects)},
      {"last_order", last.order},
      {"last_time_h", last.time_h},
      {"last_temperature_c", last.temperature_degC}};
}

Json residuals_json(const DiagnosedReadings& data) {
  Json json{{"sample", Json::array()},      {"dial", Json::array()},
            {"measured_mm", Json::array()}, {"before_mm", Json::array()},
            {"after_mm", Json::array()},    {"good", Json::array()}};
  for (Eigen::Index row = 0; row < data.readings.count(); ++row) {
    const diagnosis::Row& each = data.readings.rows()[static_cast<std::size_t>(row)];
    json["sample"].push_back(
        data.readings.trials()[static_cast<std::size_t>(each.trial)].sample);
    json["dial"].push_back(dial_of(data.readings, each));
    json["measured_mm"].push_back(data.readings.measured_mm()[row]);
    json["before_mm"].push_back(finite(data.before.residual_mm[row]));
    json["after_mm"].push_back(finite(data.left_mm[row]));
    constexpr double kHalf = 0.5;
    json["good"].push_back(data.after.weight[row] > kHalf);
  }
  return json;
}

Json noise_json(const diagnosis::Noise& noise, bool dials) {
  const bool repeats = noise.source == diagnosis::NoiseSource::kRepeats;
  if (!(noise.sigma_mm > 0.0)) {
    return {
        {"source", "rig_file"},
        {"sigma_mm", nullptr},
        {"degrees_of_freedom", 0},
        {"in_words",
         "not known: the positions came without an uncertainty, and there are too few "
         "repeats"}};
  }
  return {
      {"source", repeats ? "repeats" : "rig_file"},
      {"sigma_mm", finite(noise.sigma_mm)},
      {"degrees_of_freedom", noise.degrees_of_freedom},
      {"in_words",
       repeats ? fmt::format(
                     "{:.4f} mm, measured: {} degrees of freedom from repeats", noise.sigma_mm,
                     noise.degrees_of_freedom)
               : fmt::format(
                     "{:.4f} mm, by the {}: this session has too few repeats to measure it",
                     noise.sigma_mm,
                     dials ? "rig file's repeatability and resolution"
                           : "uncertainty of the positions")}};
}

Json inputs_json(
    const session::Session& session, const DiagnosisRequest& request,
    const diagnosis::DiagnosisSettings& settings, bool dials) {
  return {
      {"session", session.name},
      {"rig_name", session.rig.name},
      {"rig_hash", "sha256:" + session::rig_sha256(session)},
      {"data_hash", "sha256:" + session::data_sha256(session)},
      {"samples", session.samples.size()},
      {"rejected_rows", session.rejected.size()},
      {"seed", request.seed},
      {"version", SIXDIAL_VERSION},
      {"settings",
       {{"space", dials ? "dials" : "positions"},
        {"null_draws", settings.null_draws},
        {"gain_draws", settings.gain_draws},
        {"with_gain", settings.with_gain},
        {"false_alarm_level", settings.search.false_alarm_level},
        {"tie_log_odds", settings.search.tie_log_odds},
        {"least_log_odds", settings.search.least_log_odds},
        {"unknown_log_odds", settings.search.unknown_log_odds},
        {"name_preference", settings.search.name_preference},
        {"beside_unknown_log_odds", settings.search.beside_unknown_log_odds},
        {"most_causes", settings.search.most_causes}}}};
}

/// What robot and named causes leave if nothing smooth and nameless is fitted with them.
Eigen::VectorXd left_without_the_unknown(
    const diagnosis::Readings& readings, const diagnosis::Identification& identified) {
  const diagnosis::JointFit& after = identified.extended;
  if (identified.unknown.empty()) return after.residual_mm;
  if (after.effects.empty()) return identified.baseline.residual_mm;
  return diagnosis::fit_jointly(readings, after.model, after.effects, &after).residual_mm;
}

double rms_of_good(const DiagnosedReadings& data) {
  const Eigen::VectorXd& weight = data.after.weight;
  return std::sqrt(weight.dot(data.left_mm.cwiseAbs2()) / std::max(1e-12, weight.sum()));
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

void add_findings(
    Json& document, const Diagnosis& found, const DiagnosedReadings& data,
    const session::Session& session) {
  document["causes"] = Json::array();
  for (const Cause& cause : found.causes) {
    Json json = cause_json(cause);
    json["signature_plot"] = nullptr;
    if (found.identified.swap && cause.finding.hypothesis == *found.identified.swap) {
      const double rms_mm = exchanged_rms(data.readings, *found.identified.swap);
      json["estimate"] = {estimate_json("difference_rms", rms_mm, "mm", nullptr)};
      json["visible_ratio"] = finite(rms_mm / found.noise.sigma_mm);
      json["size_in_words"] = size_in_words(json);
      json["signature_plot"] = signature_of_swap(data, *found.identified.swap);
    }
    for (std::size_t i = 0; i < data.after.effects.size(); ++i) {
      const simulation::ActiveEffect& active = data.after.effects[i];
      if (active.effect == cause.finding.hypothesis.effect &&
          active.place.name == cause.finding.hypothesis.place.name) {
        json["signature_plot"] = signature_of(data, i);
      }
    }
    document["causes"].push_back(std::move(json));
  }
  add_gross_readings(document, found, data.readings, session);
}

}  // namespace

Json diagnose(
    const session::Session& session, const DiagnosisRequest& request,
    const ProgressCallback& progress, std::stop_token stop) {
  const auto began = std::chrono::steady_clock::now();
  const simulation::ForwardModel model(session.rig);
  std::vector<simulation::Trial> trials = session::trials_of(session, "");
  diagnosis::DiagnosisSettings settings;
  settings.null_draws = request.bootstrap;
  constexpr int kPosesPerDraw = 10;
  constexpr int kFewestPoses = 200;
  settings.gain_draws = std::max(kFewestPoses, kPosesPerDraw * request.bootstrap);
  settings.seed = request.seed;
  settings.with_gain = request.with_gain;
  const auto tell = [&](const diagnosis::DiagnosisProgress& now) {
    if (progress) progress({.stage = now.stage, .done = now.done, .total = now.total});
  };
  const auto checked = [&] {
    if (!stop.stop_requested()) return;
    throw Error(
        ErrorCode::kCancelled, "the diagnosis was cancelled", {{"session", session.name}});
  };

  Diagnosis found;
  try {
    found =
        diagnosis::diagnose(model, trials, held_out_of(session, trials), settings, tell, stop);
  } catch (const std::invalid_argument& error) {
    throw Error(
        ErrorCode::kBadData, error.what(), {{"session", session.name}},
        "Measure more points, or check the rig file: a reading counts only while its plunger "
        "is inside its travel.");
  }
  checked();

  diagnosis::Readings readings(model, std::move(trials));
  if (found.identified.swap) {
    readings = readings.with_swapped_dials(
        found.identified.swap->place.dial, found.identified.swap->place.other_dial);
  }
  readings.place_tool(found.identified.extended.model);
  const diagnosis::JointFit& after = found.identified.extended;
  const DiagnosedReadings data{
      readings, found.identified.baseline, after,
      left_without_the_unknown(readings, found.identified), !found.identified.unknown.empty()};

  Json document{
      {"schema", "sixdial.diagnosis"},
      {"schema_version", kDiagnosisSchemaVersion},
      {"created_utc", session::now_utc_text()},
      {"inputs", inputs_json(session, request, settings, readings.has_dials())}};
  add_findings(document, found, data, session);
  document["noise"] = noise_json(found.noise, readings.has_dials());
  document["unexplained"] = {
      {"significant", found.unexplained.significant},
      {"depends_on", found.unexplained.depends_on},
      {"rms_mm", finite(rms_of_good(data))},
      {"noise_mm", found.noise.sigma_mm > 0.0 ? Json(found.noise.sigma_mm) : Json(nullptr)},
      {"scatter", found.unexplained.scatter},
      {"noisy_dials", Json::array()}};
  for (const diagnosis::NoisyDial& each : found.unexplained.noisy_dials) {
    document["unexplained"]["noisy_dials"].push_back(
        {{"dial", each.dial},
         {"sigma_mm", finite(each.sigma_mm)},
         {"expected_mm", finite(each.expected_mm)}});
  }
  document["dependence"] = Json::array();
  for (const diagnosis::Dependence& each : found.dependence) {
    document["dependence"].push_back(
        {{"covariate", each.covariate},
         {"enters", each.enters},
         {"log_odds_before", finite(each.log_odds_before)},
         {"log_odds_after", finite(each.log_odds_after)},
         {"rms_before_mm", finite(each.rms_before_mm)},
         {"rms_after_mm", finite(each.rms_after_mm)}});
  }
  document["not_testable"] = Json::array();
  for (const diagnosis::NotTestable& each : found.not_testable) {
    Json json = place_json(each.hypothesis);
    json["reason"] = each.reason;
    json["needs"] = each.needs;
    json["in_words"] = named(json);
    document["not_testable"].push_back(std::move(json));
  }
  document["detection_limits"] = Json::array();
  for (const diagnosis::Limit& each : found.limits) {
    document["detection_limits"].push_back(limit_json(each));
  }
  add_parameters(document, found);
  document["gain"] = Json::array();
  for (const diagnosis::GainRow& row : found.gain) {
    document["gain"].push_back(gain_row_json(row, readings));
  }
  document["judged_on"] = {
      {"samples", found.g2_samples},
      {"fitted_samples", found.g1_samples},
      {"held_out_by_program", found.held_out_by_program}};
  document["false_alarm_probability"] = finite(found.false_alarm_probability);
  document["extended_model"] = extended_model_json(readings, after);
  checked();
  document["by_covariate"] = left_by_covariate(data);
  document["tool_shift"] = tool_shifts(data);
  document["residuals"] = residuals_json(data);
  document["verdict"] = verdict_in_words(document);
  document["seconds"] =
      std::chrono::duration<double>(std::chrono::steady_clock::now() - began).count();
  checked();
  return document;
}

void check_diagnosis(const Json& document) {
  if (document.is_object() && document.value("schema", "") == "sixdial.diagnosis" &&
      document.value("schema_version", 0) == kDiagnosisSchemaVersion) {
    return;
  }
  const std::string given =
      document.is_object() ? document.value("schema", "nothing known") : "nothing known";
  throw Error(
      ErrorCode::kBadData,
      fmt::format(
          "this needs a sixdial.diagnosis document of version {}, and is {}",
          kDiagnosisSchemaVersion, given),
      {}, "Diagnose the session again.");
}

}  // namespace sixdial::studies
