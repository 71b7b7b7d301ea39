#include "report/json_report.h"

#include <fmt/format.h>

#include <cmath>
#include <nlohmann/json.hpp>

#include "report/figures.h"
#include "report/tables.h"
#include "report/text.h"
#include "report/verdict.h"
#include "report/words/warning_words.h"

namespace sixdial::report {
namespace {

using nlohmann::ordered_json;

ordered_json value(double v) { return std::isfinite(v) ? ordered_json(v) : ordered_json(); }
ordered_json value(const std::optional<double>& v) { return v ? value(*v) : ordered_json(); }
ordered_json value(const std::string& text) { return valid_utf8(text); }
ordered_json value(const Cell& cell) {
  if (const auto* text = std::get_if<std::string>(&cell)) return value(*text);
  if (const auto* n = std::get_if<Number>(&cell)) {
    const bool is_count =
        n->decimals == 0 && std::abs(n->value) < 9e15 && n->value == std::floor(n->value);
    return is_count ? ordered_json(static_cast<std::int64_t>(n->value)) : value(n->value);
  }
  return nullptr;
}
template <typename Vector>
ordered_json numbers(const std::optional<Vector>& v) {
  if (!v) return nullptr;
  ordered_json out = ordered_json::array();
  for (const double each : *v) out.push_back(value(each));
  return out;
}
ordered_json list(const std::vector<double>& values) {
  ordered_json out = ordered_json::array();
  for (const double v : values) out.push_back(value(v));
  return out;
}
ordered_json list(const std::vector<std::string>& texts) {
  ordered_json out = ordered_json::array();
  for (const std::string& t : texts) out.push_back(value(t));
  return out;
}

/// Rows as objects with the column keys.
ordered_json rows(const Table& table) {
  ordered_json out = ordered_json::array();
  for (const auto& row : table.rows) {
    ordered_json object = ordered_json::object();
    for (std::size_t c = 0; c < table.columns.size(); ++c) {
      object[valid_utf8(table.columns[c].key)] =
          c < row.size() ? value(row[c]) : ordered_json();
    }
    out.push_back(std::move(object));
  }
  return out;
}

/// Who measured with what, as the rig file says; what it does not say is null.
ordered_json traceability(const session::Traceability& traced) {
  const auto said = [](const std::string& text) {
    return text.empty() ? ordered_json() : value(text);
  };
  ordered_json parts = ordered_json::array();
  for (const session::TracedPart& part : traced.parts) {
    parts.push_back(
        {{"part", value(part.what)},
         {"serial", said(part.serial)},
         {"certificate", said(part.certificate)},
         {"certified", said(part.certified)},
         {"due", said(part.due)}});
  }
  return {{"operator", said(traced.operator_name)}, {"parts", std::move(parts)}};
}

ordered_json head(const Head& h) {
  ordered_json instruments = ordered_json::array();
  for (const ShownDial& i : h.instruments) {
    instruments.push_back(
        {{"dial", value(i.id)},
         {"description", value(i.description)},
         {"serial", value(i.serial)},
         {"connection", value(i.connection)},
         {"resolution_mm", value(i.resolution_mm)},
         {"accuracy_mm", value(i.accuracy_mm)},
         {"repeatability_mm", value(i.repeatability_mm)},
         {"travel_mm", value(i.travel_mm)},
         {"tip_radius_mm", value(i.tip_radius_mm)}});
  }
  ordered_json settings = ordered_json::object();
  for (const auto& [name, text] : h.settings) settings[valid_utf8(name)] = value(text);
  return {
      {"title", value(h.title)},
      {"session", value(h.session_name)},
      {"rig", value(h.rig_name)},
      {"robot", value(h.robot)},
      {"operator", value(h.operator_name)},
      {"place", value(h.place)},
      {"measured_from", value(h.measured_from)},
      {"measured_to", value(h.measured_to)},
      {"reported", value(h.reported)},
      {"temperature_min_c", value(h.temperature_min_c)},
      {"temperature_max_c", value(h.temperature_max_c)},
      {"readings_within_median_ms", value(h.readings_within_median_ms)},
      {"readings_within_max_ms", value(h.readings_within_max_ms)},
      {"times_that_go_back", h.times_that_go_back},
      {"software_version", value(h.software_version)},
      {"data_hash", value(h.data_hash)},
      {"rig_hash", value(h.rig_hash)},
      {"seed", h.seed ? ordered_json(*h.seed) : ordered_json()},
      {"profile", value(h.profile)},
      {"settings", std::move(settings)},
      {"instruments", std::move(instruments)},
      {"traceability", traceability(h.traced)},
      {"accredited", false}};
}

ordered_json state(const ReportData& data) {
  const Verdict v = verdict(data);
  // Figures of data that contradict themselves would only be believed.
  const bool known =
      v.state != CalibrationState::kUnknown && v.state != CalibrationState::kNotCalibrated;
  return {
      {"state", state_name(v.state)},
      {"mood", mood_name(v.mood)},
      {"headline", value(v.headline)},
      {"decision", value(v.decision)},
      {"tolerance_mm", data.conformity ? value(data.conformity->tolerance_mm) : ordered_json()},
      {"before_mm", known ? value(v.before_mm) : ordered_json()},
      {"after_mm", known ? value(v.after_mm) : ordered_json()},
      {"basis", value(v.basis)},
      {"measured_again", data.measured_again},
      {"to_do", list(v.to_do)},
      {"cautions", list(v.cautions)},
      {"not_judged", list(v.not_judged)}};
}

ordered_json warnings(const ReportData& data) {
  ordered_json out = ordered_json::array();
  for (const studies::Warning& each : data.warnings) {
    out.push_back(
        {{"code", value(each.code)},
         {"severity", severity_name(each.severity)},
         {"message", value(warning_text(each))},
         {"where", value(where_text(each.where))}});
  }
  return out;
}

ordered_json points(const ReportData& data) {
  ordered_json out = ordered_json::array();
  for (const PointRow& p : data.points) {
    ordered_json by_method = ordered_json::object();
    for (std::size_t m = 0; m < data.methods.size(); ++m) {
      by_method[valid_utf8(data.methods[m].id)] = {
          {"residual_mm",
           m < p.residual_mm.size() ? numbers(p.residual_mm[m]) : ordered_json()},
          {"error_mm", value(position_error(p, m))}};
    }
    out.push_back(
        {{"set", value(p.set)},
         {"point", p.point},
         {"repeat", p.repeat},
         {"theta_rad", numbers(p.q)},
         {"target_mm", numbers(p.target_mm)},
         {"measured_mm", numbers(p.measured_mm)},
         {"dials", value(p.dials)},
         {"temperature_c", value(p.temperature_c)},
         {"time_s", value(p.time_s)},
         {"approach", p.approach},
         {"methods", std::move(by_method)}});
  }
  return out;
}

ordered_json quality(const ReportData& data) {
  ordered_json rejected = ordered_json::array();
  for (const session::RejectedRow& r : data.rejected) {
    rejected.push_back({{"line", r.line}, {"reason", value(r.reason)}});
  }
  ordered_json bad = ordered_json::array();
  for (const BadReading& b : data.bad_readings) {
    bad.push_back(
        {{"set", value(b.set)},
         {"point", b.point},
         {"repeat", b.repeat},
         {"dial", value(b.dial)},
         {"value_mm", value(b.value_mm)},
         {"reason", value(b.reason)}});
  }
  ordered_json outliers = ordered_json::array();
  for (const StandsOut& o : data.facts.stand_out) {
    outliers.push_back(
        {{"set", value(o.set)},
         {"point", o.point},
         {"repeat", o.repeat},
         {"dial", o.dial.empty() ? ordered_json() : value(o.dial)},
         {"residual_mm", value(o.off_mm)},
         {"times_usual", value(o.times_noise)},
         {"not_fitted", o.not_fitted},
         {"not_diagnosed", o.not_diagnosed}});
  }
  return {
      {"samples", data.samples},
      {"without_position", points_without_position(data)},
      {"rejected_rows", std::move(rejected)},
      {"bad_readings", std::move(bad)},
      {"outliers", std::move(outliers)}};
}

ordered_json identification(const ReportData& data) {
  ordered_json correlations = ordered_json::array();
  for (const ShownCorrelation& c : data.correlations) {
    correlations.push_back(
        {{"first", value(c.first)},
         {"second", value(c.second)},
         {"correlation", value(c.value)}});
  }
  return {
      {"rmse_mm", value(data.rmse_mm)},
      {"least_squares_rmse_mm", value(data.least_squares_rmse_mm)},
      {"position_noise_mm", value(data.position_noise_mm)},
      {"condition_number", value(data.condition_number)},
      {"singular_values", list(data.singular_values)},
      {"correlations", std::move(correlations)},
      {"unidentifiable", list(data.unidentifiable)}};
}

ordered_json block(const Block& b) {
  const auto table = [](const Table& t) -> ordered_json {
    ordered_json columns = ordered_json::array();
    for (const Column& c : t.columns) {
      columns.push_back(
          {{"key", value(c.key)}, {"title", value(c.title)}, {"unit", value(c.unit)}});
    }
    return {
        {"id", value(t.id)},
        {"caption", value(t.caption)},
        {"columns", std::move(columns)},
        {"rows", rows(t)},
        {"notes", list(t.notes)}};
  };
  if (const auto* words = std::get_if<std::string>(&b)) return {{"paragraph", value(*words)}};
  if (const auto* t = std::get_if<Table>(&b)) return {{"table", table(*t)}};
  if (const auto* p = std::get_if<Picture>(&b)) {
    return {{"picture", {{"id", p->id}, {"title", p->title}}}};  // its numbers are a table
  }
  const auto& f = std::get<Figure>(b);
  return {
      {"figure",
       {{"id", value(f.id)},
        {"title", value(f.title)},
        {"shows", value(f.shows)},
        {"good", value(f.good)},
        {"here", value(f.here)},
        {"table", table(f.table)}}}};
}

}  // namespace

std::string json_report(const ReportData& data) {
  ordered_json swarms = ordered_json::array();
  for (const studies::Convergence& c : data.convergence) {
    swarms.push_back({{"name", value(c.name)}, {"best_rmse_mm", list(c.best_mm)}});
  }
  ordered_json sections = ordered_json::array();
  for (const Section& s : data.sections) {
    ordered_json blocks = ordered_json::array();
    for (const Block& b : s.blocks) blocks.push_back(block(b));
    sections.push_back(
        {{"id", value(s.id)}, {"heading", value(s.heading)}, {"blocks", std::move(blocks)}});
  }
  const auto result = result_index(data);
  const auto by = residual_by(data);
  const ordered_json out{
      {"schema", "sixdial.report"},
      {"schema_version", kJsonSchemaVersion},
      {"head", head(data.head)},
      {"state", state(data)},
      {"warnings", warnings(data)},
      {"result_method", result ? value(data.methods[*result].id) : ordered_json()},
      {"table2", rows(parameter_table(data, true))},
      {"fits", data.facts.fits.empty() ? ordered_json::array() : rows(fits_table(data))},
      {"table6", rows(accuracy_table(data, true))},
      {"residual_by", by ? rows(by->table) : ordered_json::array()},
      {"residual_by_dial", rows(dial_table(data))},
      {"identification", identification(data)},
      {"convergence", std::move(swarms)},
      {"parameters_by_iteration", rows(trace_table(data, false))},
      {"points", points(data)},
      {"data_quality", quality(data)},
      {"sections", std::move(sections)}};
  return out.dump(1) + "\n";
}

}  // namespace sixdial::report
