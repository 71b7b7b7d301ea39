#include "report/sections.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <tuple>

#include "report/expanded.h"
#include "report/figures.h"
#include "report/tables.h"
#include "report/text.h"

namespace sixdial::report {
namespace {

constexpr std::size_t kWorstPoints = 8;
constexpr double kNm_per_mm = 1e6;

/// A diagnosis says by name what residuals may depend on.
bool is_diagnosed(const ReportData& data) {
  return std::ranges::find(data.sections, std::string("diagnosis"), &Section::id) !=
         data.sections.end();
}

Section accuracy(const ReportData& data) {
  Section out{.id = "accuracy", .heading = "Accuracy before and after"};
  if (data.methods.empty()) {
    out.blocks.emplace_back("No calibration result is stored for this session.");
    return out;
  }
  out.blocks.emplace_back(
      "The position error is the distance between the measured and the modelled position of "
      "the "
      "tool (the paper's equation 41). The points of G1 were used to calibrate; those of G2 "
      "were not, they only judge the result.");
  out.blocks.emplace_back(accuracy_table(data, false));
  for (const std::string& line : data.turns) out.blocks.emplace_back(line);
  if (auto figure = residual_map(data)) out.blocks.emplace_back(std::move(*figure));
  if (is_diagnosed(data)) return out;
  if (auto figure = residual_by(data)) out.blocks.emplace_back(std::move(*figure));
  return out;
}

/// The rest on accuracy: intervals of the means, every point, every dial.
Section accuracy_details(const ReportData& data) {
  Section out{.id = "accuracy_details", .heading = "Accuracy in detail", .in_annex = true};
  if (Table t = confidence_table(data); !t.rows.empty()) out.blocks.emplace_back(std::move(t));
  if (is_diagnosed(data)) {
    if (auto figure = residual_by(data)) out.blocks.emplace_back(std::move(*figure));
  }
  if (auto figure = error_by_point(data)) out.blocks.emplace_back(std::move(*figure));
  if (Table t = dial_table(data); !t.rows.empty()) out.blocks.emplace_back(std::move(t));
  Table worst = worst_points_table(data, kWorstPoints);
  if (!worst.rows.empty()) out.blocks.emplace_back(std::move(worst));
  return out;
}

Section parameters(const ReportData& data) {
  Section out{.id = "parameters", .heading = "Identified parameters"};
  // One set of parameters is recommended, and stands in front; any other is a detail.
  out.in_annex = !data.parameters_note.empty();
  if (out.in_annex) out.heading = "Parameters of the robot alone";
  if (data.parameters.empty()) {
    out.blocks.emplace_back("No parameters were identified.");
    return out;
  }
  if (!data.parameters_note.empty()) out.blocks.emplace_back(data.parameters_note);
  out.blocks.emplace_back(parameter_table(data, false));
  if (data.condition_number) {
    out.blocks.emplace_back(fmt::format(
        "Condition number of the fit: {}. Below about 100 every parameter is determined well "
        "by "
        "itself; in the thousands some are only determined together.",
        fixed(*data.condition_number, *data.condition_number < 100.0 ? 1 : 0)));
  }
  if (!data.unidentifiable.empty()) {
    std::string words = "These poses cannot tell apart, so they were held at nominal: ";
    for (std::size_t i = 0; i < data.unidentifiable.size(); ++i) {
      words += (i == 0 ? "" : "; ") + data.unidentifiable[i];
    }
    out.blocks.emplace_back(words + ".");
  }
  return out;
}

Table correlations_table(const ReportData& data) {
  Table t{.id = "correlations", .caption = "Correlations above 0.9 in absolute value"};
  t.columns = {
      column("first", "parameter"), column("second", "with"),
      column("correlation", "correlation")};
  for (const ShownCorrelation& c : data.correlations) {
    t.rows.push_back({symbol(c.first), symbol(c.second), number(c.value, 3)});
  }
  t.notes.emplace_back(
      "Each of such a pair is less certain than the pair together; its U says by how much.");
  return t;
}

Table singular_values_table(const ReportData& data) {
  Table t{.id = "singular_values", .caption = "Singular values of the scaled Jacobian"};
  t.columns = {
      column("index", "number"), column("singular_value", "value"),
      column("relative", "relative to the largest")};
  for (std::size_t i = 0; i < data.singular_values.size(); ++i) {
    const double largest = data.singular_values.front();
    t.rows.push_back(
        {whole(static_cast<long long>(i + 1)), number(data.singular_values[i], 4),
         number(data.singular_values[i] / largest, 6)});
  }
  return t;
}

Section identification(const ReportData& data) {
  Section out{
      .id = "identification", .heading = "How the parameters were found", .in_annex = true};
  if (data.rmse_mm && data.least_squares_rmse_mm) {
    Table t{.id = "objective", .caption = "Objective of the identification on G1"};
    t.columns = {
        column("quantity", "quantity"), column("value", "value"), column("unit", "unit")};
    const auto add = [&](std::string what, double value, int decimals, std::string unit) {
      t.rows.push_back({std::move(what), number(value, decimals), std::move(unit)});
    };
    add("root mean square error of the identified parameters", *data.rmse_mm, 6, "mm");
    add("least-squares minimum of the same objective", *data.least_squares_rmse_mm, 6, "mm");
    add("difference", (*data.rmse_mm - *data.least_squares_rmse_mm) * kNm_per_mm, 3, "nm");
    out.blocks.emplace_back(std::move(t));
  }
  if (auto figure = convergence(data)) out.blocks.emplace_back(std::move(*figure));
  if (auto figure = parameter_traces(data)) out.blocks.emplace_back(std::move(*figure));
  if (data.facts.fits.size() > 1) out.blocks.emplace_back(fits_table(data));
  if (!data.correlations.empty()) {
    out.blocks.emplace_back(correlations_table(data));
  } else if (!data.parameters.empty() && data.parameters.front().sd) {
    out.blocks.emplace_back("No two parameters are correlated by more than 0.9.");
  }
  if (!data.singular_values.empty()) out.blocks.emplace_back(singular_values_table(data));
  return out;
}

/// How the calibration looked for readings that do not agree with the rest.
void add_check(const studies::GrossErrors& check, Section& out) {
  if (check.not_possible) {
    out.blocks.emplace_back(
        "Single readings were not checked against the rest: " + *check.not_possible + ".");
    return;
  }
  out.blocks.emplace_back(fmt::format(
      "The calibration checked {} readings of G1 against all others by a robust fit. One that "
      "is "
      "further off than {} standard deviations (one is {} mm) counts as a gross error. Raw "
      "readings stay as they were stored; gross ones of G1 were {}; G2 is judged with all of "
      "its readings.",
      check.readings, fixed(check.limit_times_sigma, 1), fixed(check.sigma_mm, 4),
      check.set_aside ? "not fitted" : "fitted all the same"));
  for (const auto& [set, too_many] :
       {std::pair{"G1", check.systematic_g1}, std::pair{"G2", check.systematic_g2}}) {
    if (too_many == 0) continue;
    out.blocks.emplace_back(fmt::format(
        "{} readings of {} do not agree with the rest. That is too many for accidents: a dial, "
        "the rig file or the model is wrong. None of them was left out.",
        too_many, set));
  }
}

/// What the studies did with a value that does not agree with the rest.
std::string treatment_of(const StandsOut& each) {
  std::string words = each.not_fitted && each.not_diagnosed ? "not fitted, not diagnosed"
                      : each.not_fitted                     ? "not fitted"
                      : each.not_diagnosed                  ? "not diagnosed"
                                                            : "kept";
  return each.remark.empty() ? words : words + "; " + each.remark;
}

Table stand_out_table(const ReportData& data) {
  Table t{.id = "outliers", .caption = "Measured values that do not agree with the rest"};
  t.columns = {
      column("set", "set"),
      column("point", "point"),
      column("repeat", "repeat"),
      column("dial", "dial"),
      column("residual_mm", "off by", "mm"),
      column("treatment", "what was done")};
  for (const StandsOut& each : data.facts.stand_out) {
    t.rows.push_back(
        {each.set, whole(each.point), whole(each.repeat),
         each.dial.empty() ? Cell{std::string{"position"}} : Cell{each.dial},
         number(each.off_mm, 4), treatment_of(each)});
  }
  constexpr std::size_t kOnPage = 12;
  t.rows_on_page = kOnPage;
  t.notes.emplace_back(
      "Off by: measured minus modelled, by the diagnosis where it listed the value, else by "
      "the "
      "calibration.");
  return t;
}

Section measured_data(const ReportData& data) {
  Section out{.id = "data", .heading = "Quality of the measured data"};
  Table counts{.id = "counts", .caption = "Samples"};
  counts.columns = {column("what", "what"), column("count", "count")};
  const auto add = [&](std::string what, std::size_t n) {
    counts.rows.push_back({std::move(what), whole(static_cast<long long>(n))});
  };
  add("samples kept", static_cast<std::size_t>(data.samples));
  const auto not_used = std::ranges::count_if(data.points, &PointRow::left_out);
  if (not_used > 0) {
    add("of these not used: see what speaks against the data",
        static_cast<std::size_t>(not_used));
  }
  add("of these without a position (kept; single readings are still used)",
      static_cast<std::size_t>(points_without_position(data)));
  add("rows rejected on import", data.rejected.size());
  add("readings that were bad or missing where a contact was expected",
      data.bad_readings.size());
  add("measured values that do not agree with the rest", data.facts.stand_out.size());
  out.blocks.emplace_back(std::move(counts));
  if (data.facts.check) add_check(*data.facts.check, out);
  if (!data.facts.stand_out.empty()) out.blocks.emplace_back(stand_out_table(data));
  if (!data.bad_readings.empty()) {
    Table t{.id = "bad_readings", .caption = "Bad or missing readings"};
    t.columns = {
        column("set", "set"),   column("point", "point"),          column("repeat", "repeat"),
        column("dial", "dial"), column("value_mm", "value", "mm"), column("reason", "reason")};
    for (const BadReading& b : data.bad_readings) {
      t.rows.push_back(
          {b.set, whole(b.point), whole(b.repeat), b.dial, number(b.value_mm, 3), b.reason});
    }
    out.blocks.emplace_back(std::move(t));
  }
  if (!data.rejected.empty()) {
    Table t{.id = "rejected_rows", .caption = "Rows rejected on import"};
    t.columns = {column("line", "line"), column("reason", "reason")};
    for (const session::RejectedRow& r : data.rejected)
      t.rows.push_back({whole(r.line), r.reason});
    out.blocks.emplace_back(std::move(t));
  }
  return out;
}

/// "A", or "A, B, C" of dials that are alike in all that is known of them.
std::vector<std::pair<std::string, ShownDial>> alike(const std::vector<ShownDial>& dials) {
  std::vector<std::pair<std::string, ShownDial>> out;
  const auto known = [](const ShownDial& i) {
    return std::tuple(
        i.description, i.serial, i.resolution_mm, i.accuracy_mm, i.repeatability_mm,
        i.travel_mm, i.tip_radius_mm);
  };
  for (const ShownDial& each : dials) {
    const auto same = std::ranges::find_if(
        out, [&](const auto& other) { return known(other.second) == known(each); });
    if (same == out.end()) {
      out.emplace_back(each.id, each);
    } else {
      same->first += ", " + each.id;
    }
  }
  return out;
}

Section conditions(const ReportData& data) {
  const Head& head = data.head;
  Section out{.id = "conditions", .heading = "Instruments"};
  if (head.instruments.empty()) return out;
  Table t{.id = "instruments", .caption = "Dial indicators"};
  t.columns = {
      column("dial", "dial"),
      column("instrument", "instrument"),
      column("serial", "serial number"),
      column("resolution_mm", "resolution", "mm"),
      column("accuracy_mm", "largest error by its maker", "mm"),
      column("repeatability_mm", "repeatability (k = 1)", "mm"),
      column("travel_mm", "travel", "mm"),
      column("tip_radius_mm", "tip radius", "mm")};
  for (const auto& [ids, i] : alike(head.instruments)) {
    t.rows.push_back(
        {ids, text_cell(i.description), text_cell(i.serial), number(i.resolution_mm, 4),
         number(i.accuracy_mm, 4), number(i.repeatability_mm, 4), number(i.travel_mm, 1),
         number(i.tip_radius_mm, 3)});
  }
  out.blocks.emplace_back(std::move(t));
  return out;
}

Section provenance(const ReportData& data) {
  const Head& head = data.head;
  Section out{.id = "made_from", .heading = "Conditions and provenance", .in_annex = true};
  Table t{.id = "provenance", .caption = "What this report was made from"};
  t.columns = {column("what", "what"), column("value", "value")};
  const auto add = [&](std::string what, const std::string& value) {
    t.rows.push_back({std::move(what), value.empty() ? std::string{"not recorded"} : value});
  };
  add("measured from", head.measured_from);
  add("measured to", head.measured_to);
  add("temperature", head.temperature_min_c && head.temperature_max_c
                         ? fmt::format(
                               "{} to {} \u00B0C", fixed(*head.temperature_min_c, 2),
                               fixed(*head.temperature_max_c, 2))
                         : "");
  if (head.times_that_go_back > 0) {
    add("samples dated before the one above them",
        fmt::format(
            "{}: the computer's clock was set back; times before and after do not compare",
            head.times_that_go_back));
  }
  const bool has_dials = !head.instruments.empty();
  if (has_dials) {
    add("from the first to the last dial's answer of a sample",
        head.readings_within_median_ms && head.readings_within_max_ms
            ? fmt::format(
                  "{} ms (median), {} ms at most", fixed(*head.readings_within_median_ms, 0),
                  fixed(*head.readings_within_max_ms, 0))
            : "");
  }
  add(has_dials ? "standard deviation of a measured position, from the dials alone"
                : "standard deviation of a measured position, by the rig file",
      data.position_noise_mm ? fmt::format("{} mm", fixed(*data.position_noise_mm, 4)) : "");
  add("software", head.software_version.empty() ? "" : "Sixdial " + head.software_version);
  add("profile of the method", head.profile);
  add("seed of all random numbers", head.seed ? fmt::format("{}", *head.seed) : "");
  add("hash of the measured data", head.data_hash);
  add("hash of the rig file", head.rig_hash);
  for (const session::TracedPart& part : head.traced.parts) {
    add("traced to: " + part.what, part.words());
  }
  out.blocks.emplace_back(std::move(t));
  return out;
}

Section settings(const ReportData& data) {
  Section out{.id = "settings", .heading = "Settings", .in_annex = true};
  Table t{.id = "settings", .caption = "What was chosen, or left as it is by default"};
  t.columns = {column("what", "what"), column("value", "value")};
  for (const auto& [name, value] : data.head.settings) t.rows.push_back({name, value});
  if (!t.rows.empty()) out.blocks.emplace_back(std::move(t));
  Table connections{.id = "connections", .caption = "How the dials were connected"};
  connections.columns = {column("dial", "dial"), column("connection", "connection")};
  for (const ShownDial& each : data.head.instruments) {
    connections.rows.push_back({each.id, text_cell(each.connection)});
  }
  if (!connections.rows.empty()) out.blocks.emplace_back(std::move(connections));
  return out;
}

Section positions(const ReportData& data) {
  Section out{.id = "positions", .heading = "Measured positions", .in_annex = true};
  out.blocks.emplace_back(measurement_table(data));
  return out;
}

}  // namespace

std::vector<Section> sections_of(const ReportData& data) {
  std::vector<Section> all;
  if (!data.opening) {
    all = {accuracy(data), parameters(data)};
    for (Section each : {accuracy_details(data), identification(data)}) {
      if (!each.blocks.empty()) all.push_back(std::move(each));
    }
  }
  all.insert(all.end(), data.sections.begin(), data.sections.end());
  // Which model to use stands before the parameters of one of them.
  const auto recommended = std::ranges::find(all, std::string("recommendation"), &Section::id);
  if (recommended != all.end() && !data.opening) {
    std::rotate(all.begin() + 1, recommended, recommended + 1);
  }
  if (!data.opening) all.push_back(measured_data(data));
  for (Section each : {conditions(data), provenance(data)}) {
    if (!each.blocks.empty()) all.push_back(std::move(each));
  }
  if (Section chosen = settings(data); !chosen.blocks.empty()) all.push_back(std::move(chosen));
  if (!data.opening && !data.points.empty()) all.push_back(positions(data));
  std::stable_partition(
      all.begin(), all.end(), [](const Section& each) { return !each.in_annex; });
  return all;
}

}  // namespace sixdial::report
