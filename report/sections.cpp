#include "report/sections.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "report/figures.h"
#include "report/tables.h"
#include "report/text.h"

namespace sixdial::report {
namespace {

constexpr std::size_t kWorstPoints = 8;
constexpr double kNm_per_mm = 1e6;

Column column(std::string key, std::string title, std::string unit = "") {
  return {
      .key = std::move(key), .title = std::move(title), .unit = std::move(unit), .group = ""};
}
Cell text(const std::string& value) { return value.empty() ? Cell{} : Cell{value}; }

Section accuracy(const ReportData& data) {
  Section out{.id = "accuracy", .heading = "Accuracy before and after"};
  if (data.methods.empty()) {
    out.blocks.emplace_back("No calibration result is stored for this session.");
    return out;
  }
  out.blocks.emplace_back(
      "Distance between measured and modelled position, equation (41), over each set of "
      "points. G1 was used to calibrate, G2 only to validate.");
  out.blocks.emplace_back(accuracy_table(data, false));
  if (Table t = confidence_table(data); !t.rows.empty()) out.blocks.emplace_back(std::move(t));
  if (auto figure = residual_map(data)) out.blocks.emplace_back(std::move(*figure));
  if (auto figure = error_by_point(data)) out.blocks.emplace_back(std::move(*figure));
  if (auto figure = residual_by(data)) out.blocks.emplace_back(std::move(*figure));
  if (Table t = dial_table(data); !t.rows.empty()) out.blocks.emplace_back(std::move(t));
  Table worst = worst_points_table(data, kWorstPoints);
  if (!worst.rows.empty()) out.blocks.emplace_back(std::move(worst));
  return out;
}

Section parameters(const ReportData& data) {
  Section out{.id = "parameters", .heading = "Identified parameters"};
  if (data.parameters.empty()) {
    out.blocks.emplace_back("No parameters were identified.");
    return out;
  }
  if (!data.parameters_note.empty()) out.blocks.emplace_back(data.parameters_note);
  out.blocks.emplace_back(parameter_table(data, false));
  if (data.condition_number) {
    out.blocks.emplace_back(fmt::format(
        "Condition number of the scaled Jacobian: {}. Below about 100 every parameter is "
        "determined well by itself; in the thousands some are only determined together.",
        fixed(*data.condition_number, *data.condition_number < 100.0 ? 1 : 0)));
  }
  if (!data.unidentifiable.empty()) {
    std::string words = "Cannot be told apart by these poses, and held at nominal: ";
    for (std::size_t i = 0; i < data.unidentifiable.size(); ++i) {
      words += (i == 0 ? "" : "; ") + data.unidentifiable[i];
    }
    out.blocks.emplace_back(words + ".");
  }
  if (!data.correlations.empty()) {
    Table t{.id = "correlations", .caption = "Correlations above 0.9 in absolute value"};
    t.columns = {
        column("first", "parameter"), column("second", "with"),
        column("correlation", "correlation")};
    for (const ShownCorrelation& c : data.correlations) {
      t.rows.push_back({symbol(c.first), symbol(c.second), number(c.value, 3)});
    }
    t.notes.emplace_back(
        "Each of such a pair is less certain than the pair together; its interval above says "
        "by how much.");
    out.blocks.emplace_back(std::move(t));
  } else if (data.parameters.front().sd) {
    out.blocks.emplace_back("No two parameters are correlated by more than 0.9.");
  }
  if (!data.singular_values.empty()) {
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
    out.blocks.emplace_back(std::move(t));
  }
  return out;
}

Section identification(const ReportData& data) {
  Section out{.id = "identification", .heading = "How the parameters were found"};
  if (data.rmse_mm && data.least_squares_rmse_mm) {
    Table t{.id = "objective", .caption = "Objective of the identification on G1"};
    t.columns = {
        column("quantity", "quantity"), column("value", "value"), column("unit", "unit")};
    const auto add = [&](std::string what, double value, int decimals, std::string unit) {
      t.rows.push_back({std::move(what), number(value, decimals), std::move(unit)});
    };
    add("RMSE of the identified parameters", *data.rmse_mm, 6, "mm");
    add("least-squares minimum of the same objective", *data.least_squares_rmse_mm, 6, "mm");
    add("difference", (*data.rmse_mm - *data.least_squares_rmse_mm) * kNm_per_mm, 3, "nm");
    out.blocks.emplace_back(std::move(t));
  }
  if (auto figure = convergence(data)) out.blocks.emplace_back(std::move(*figure));
  if (auto figure = parameter_traces(data)) out.blocks.emplace_back(std::move(*figure));
  return out;
}

Section measured_data(const ReportData& data) {
  Section out{.id = "data", .heading = "Quality of the measured data"};
  Table counts{.id = "counts", .caption = "Samples"};
  counts.columns = {column("what", "what"), column("count", "count")};
  const auto add = [&](std::string what, std::size_t n) {
    counts.rows.push_back({std::move(what), whole(static_cast<long long>(n))});
  };
  add("samples kept", static_cast<std::size_t>(data.samples));
  add("of these without a position (kept; single readings are still used)",
      static_cast<std::size_t>(points_without_position(data)));
  add("rows rejected on import", data.rejected.size());
  add("readings that were bad or missing where a contact was expected",
      data.bad_readings.size());
  add("values out of line with the rest", data.outliers.size());
  out.blocks.emplace_back(std::move(counts));
  if (!data.outliers.empty()) {
    Table t{.id = "outliers", .caption = "Values out of line with the rest"};
    t.columns = {
        column("set", "set"),
        column("point", "point"),
        column("repeat", "repeat"),
        column("dial", "dial"),
        column("residual_mm", "residual", "mm"),
        column("times_usual", "times the usual")};
    for (const Outlier& o : data.outliers) {
      t.rows.push_back(
          {o.set, whole(o.point), whole(o.repeat),
           o.dial.empty() ? Cell{std::string{"position"}} : Cell{o.dial},
           number(o.residual_mm, 4), number(o.times_usual, 1)});
    }
    out.blocks.emplace_back(std::move(t));
  }
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

Section conditions(const ReportData& data) {
  const Head& head = data.head;
  Section out{.id = "conditions", .heading = "Instruments, conditions and provenance"};
  if (!head.instruments.empty()) {
    Table t{.id = "instruments", .caption = "Dial indicators"};
    t.columns = {
        column("dial", "dial"),
        column("instrument", "instrument"),
        column("serial", "serial number"),
        column("connection", "connection"),
        column("resolution_mm", "resolution", "mm"),
        column("accuracy_mm", "accuracy \u00B1", "mm"),
        column("repeatability_mm", "repeatability (sd)", "mm"),
        column("travel_mm", "travel", "mm"),
        column("tip_radius_mm", "tip radius", "mm")};
    for (const ShownDial& i : head.instruments) {
      t.rows.push_back(
          {i.id, text(i.description), text(i.serial), text(i.connection),
           number(i.resolution_mm, 4), number(i.accuracy_mm, 4), number(i.repeatability_mm, 4),
           number(i.travel_mm, 1), number(i.tip_radius_mm, 3)});
    }
    out.blocks.emplace_back(std::move(t));
  }
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
  for (const auto& [name, value] : head.settings) add(name, value);
  add("hash of the measured data", head.data_hash);
  add("hash of the rig file", head.rig_hash);
  out.blocks.emplace_back(std::move(t));
  return out;
}

}  // namespace

std::vector<Section> sections_of(const ReportData& data) {
  if (data.opening) {
    std::vector<Section> out = data.sections;
    out.push_back(conditions(data));
    return out;
  }
  // Which model to use stands before the parameters of one of them.
  const auto recommended =
      std::ranges::find(data.sections, std::string("recommendation"), &Section::id);
  std::vector<Section> out{accuracy(data)};
  if (recommended != data.sections.end()) out.push_back(*recommended);
  out.push_back(parameters(data));
  if (Section found = identification(data); !found.blocks.empty())
    out.push_back(std::move(found));
  for (auto each = data.sections.begin(); each != data.sections.end(); ++each) {
    if (each != recommended) out.push_back(*each);
  }
  out.push_back(measured_data(data));
  out.push_back(conditions(data));
  if (!data.points.empty()) {
    Section annex{.id = "annex", .heading = "Annex: measured positions"};
    annex.blocks.emplace_back(measurement_table(data));
    out.push_back(std::move(annex));
  }
  return out;
}

}  // namespace sixdial::report
