#include "report/tables.h"

#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <cmath>
#include <numeric>
#include <span>

#include "report/expanded.h"
#include "report/text.h"
#include "report/views.h"

namespace sixdial::report {
namespace {

constexpr int kErrorDecimals = 4;     // mm: a tenth of what a dial resolves
constexpr int kPositionDecimals = 3;  // mm: what a dial resolves
constexpr int kAngleDecimals = 6;  // rad: 60 mm of arm times 1e-6 is far below a dial's digit

/// On the page, the repeat is shown only where there are any.
bool has_repeats(const ReportData& data) {
  return std::any_of(
      data.points.begin(), data.points.end(), [](const PointRow& p) { return p.repeat != 0; });
}
std::vector<Column> point_columns(bool repeats) {
  if (!repeats) return {column("set", "set"), column("point", "point")};
  return {column("set", "set"), column("point", "point"), column("repeat", "repeat")};
}
std::vector<Cell> point_cells(const PointRow& p, bool repeats) {
  if (!repeats) return {p.set, whole(p.point)};
  return {p.set, whole(p.point), whole(p.repeat)};
}

template <typename Vector>
Cell component(const std::optional<Vector>& v, Eigen::Index i, int decimals) {
  return v && i < v->size() ? number((*v)[i], decimals) : Cell{};
}
std::optional<geometry::Position> residual(const PointRow& p, std::size_t method) {
  return method < p.residual_mm.size() ? p.residual_mm[method] : std::nullopt;
}

std::span<const std::string_view> axes_of(const ReportData& data) {
  return coordinates(data.axes);
}

/// Joint values, target and measured position of a point, a cell each.
void add_place(const ReportData& data, const PointRow& p, std::vector<Cell>& row) {
  const auto joints = static_cast<Eigen::Index>(data.joints.size());
  for (Eigen::Index i = 0; i < joints; ++i) row.push_back(component(p.q, i, kAngleDecimals));
  for (const auto& place : {p.target_mm, p.measured_mm}) {
    for (int i = 0; i < data.axes; ++i) row.push_back(component(place, i, kPositionDecimals));
  }
}

/// Leaves out rows that read the same as the one above in all columns from `first` on; the
/// first and the last of each stage (equal text in column 0) stay.
void keep_changes(Table& table, std::size_t first, bool stages) {
  std::vector<std::vector<Cell>> kept;
  const auto same = [&](const std::vector<Cell>& a, const std::vector<Cell>& b) {
    for (std::size_t c = first; c < a.size(); ++c) {
      if (shown(a[c]) != shown(b[c])) return false;
    }
    return true;
  };
  for (std::size_t r = 0; r < table.rows.size(); ++r) {
    const bool last = r + 1 == table.rows.size() ||
                      (stages && shown(table.rows[r][0]) != shown(table.rows[r + 1][0]));
    const bool new_stage =
        stages && r > 0 && shown(table.rows[r][0]) != shown(table.rows[r - 1][0]);
    if (r == 0 || last || new_stage || !same(table.rows[r], table.rows[r - 1])) {
      kept.push_back(table.rows[r]);
    }
  }
  if (kept.size() < table.rows.size()) {
    table.notes.push_back(fmt::format(
        "Rows that read the same as the one above are left out: {} of {} are shown. All are in "
        "{}.csv.",
        kept.size(), table.rows.size(), table.id));
  }
  table.rows = std::move(kept);
}

}  // namespace

std::string key_of(std::string_view name) {
  std::string out;
  for (const char c : name) {
    const auto u = static_cast<unsigned char>(c);
    if (u < 0x80 && std::isalnum(u) != 0) {
      out += static_cast<char>(std::tolower(u));
    } else if (!out.empty() && out.back() != '_') {
      out += '_';
    }
  }
  while (!out.empty() && out.back() == '_') out.pop_back();
  return out.empty() ? "unnamed" : out;
}

std::optional<double> position_error(const PointRow& point, std::size_t method) {
  const auto e = residual(point, method);
  if (!e) return std::nullopt;
  return e->norm();
}

Table parameter_table(const ReportData& data, bool plain) {
  Table out{.id = "table2", .caption = "Nominal and identified parameters"};
  out.columns = {column("parameter", "parameter")};
  if (!plain) out.columns.push_back(column("meaning", "what it is"));
  out.columns.push_back(column("unit", "unit"));
  for (const char* key : {"nominal", "identified", "difference"}) {
    out.columns.push_back(column(key, key));
  }
  // One number of decimals and one coverage factor for all, so that columns line up: enough for
  // the best known parameter, wide enough for the least certain.
  int decimals = 3;
  double coverage = geometry::kCoverage;
  for (const ShownParameter& p : data.parameters) {
    if (p.sd) decimals = std::max(decimals, decimals_for(geometry::kCoverage * *p.sd));
    if (p.sd && p.low && p.high) {
      coverage = std::max(coverage, coverage_of(*p.sd, *p.low, *p.high));
    }
  }
  out.columns.push_back(expanded_column("sd", "", "", coverage));
  if (plain) {
    for (const char* key : {"low", "high", "held"}) out.columns.push_back(column(key, key));
  } else {
    out.notes.push_back(fmt::format(
        "U: expanded uncertainty, {} standard deviations; the value lies within \u00B1U with "
        "about 95 % probability.",
        coverage == std::floor(coverage) ? fixed(coverage, 0) : fixed(coverage, 2)));
  }
  for (const ShownParameter& p : data.parameters) {
    std::vector<Cell> row{plain ? p.name : symbol(p.name)};
    if (!plain) {
      row.emplace_back(p.meaning + (p.held ? " (held at nominal)" : ""));
    }
    row.emplace_back(p.unit);
    row.push_back(number(p.nominal, decimals));
    row.push_back(number(p.identified, decimals));
    row.push_back(number(p.identified - p.nominal, decimals));
    row.push_back(expanded(p.sd, decimals, coverage));
    if (plain) {
      row.push_back(number(p.low, decimals));
      row.push_back(number(p.high, decimals));
      row.emplace_back(std::string{p.held ? "yes" : "no"});
    }
    out.rows.push_back(std::move(row));
  }
  return out;
}

Table accuracy_table(const ReportData& data, bool plain) {
  Table out{.id = "table6", .caption = "Absolute position error before and after calibration"};
  if (plain) out.columns.push_back(column("method", "method"));
  out.columns.push_back(column("name", "method"));
  const auto points = [&](auto member) {
    int most = 0;
    for (const ShownMethod& m : data.methods) {
      if (m.*member) most = std::max(most, (m.*member)->points);
    }
    return most;
  };
  for (const bool second : {false, true}) {
    const std::string key = second ? "g2_" : "g1_";
    const std::string group = fmt::format(
        "{}, {}", second ? "G2 validation" : "G1 calibration",
        counted(points(second ? &ShownMethod::g2 : &ShownMethod::g1), "point", "points"));
    if (plain) out.columns.push_back({key + "points", "points", "", group});
    for (const std::string name : {"mean", "std", "max"}) {
      out.columns.push_back({key + name + "_mm", name, "mm", group});
    }
    if (!plain) continue;
    out.columns.push_back({key + "mean_low_mm", "mean from", "mm", group});
    out.columns.push_back({key + "mean_high_mm", "mean to", "mm", group});
  }
  if (plain) out.columns.push_back({"time_s", "time", "s", ""});
  for (const ShownMethod& m : data.methods) {
    std::vector<Cell> row;
    if (plain) row.emplace_back(m.id);
    row.emplace_back(m.name);
    for (const auto& e : {m.g1, m.g2}) {
      if (plain) row.push_back(e ? whole(e->points) : Cell{});
      row.push_back(e ? number(e->mean_mm, kErrorDecimals) : Cell{});
      row.push_back(e ? number(e->std_mm, kErrorDecimals) : Cell{});
      row.push_back(e ? number(e->max_mm, kErrorDecimals) : Cell{});
      if (!plain) continue;
      row.push_back(e ? number(e->mean_low_mm, kErrorDecimals) : Cell{});
      row.push_back(e ? number(e->mean_high_mm, kErrorDecimals) : Cell{});
    }
    if (plain) row.push_back(number(m.seconds, 3));
    out.rows.push_back(std::move(row));
  }
  out.main_row = result_index(data);
  return out;
}

Table confidence_table(const ReportData& data) {
  Table out{.id = "confidence", .caption = "How sure the mean errors are, and computing time"};
  out.columns = {column("name", "method")};
  const std::string g1 = "G1 mean, 95 % interval";
  const std::string g2 = "G2 mean, 95 % interval";
  out.columns.push_back({"g1_mean_low_mm", "from", "mm", g1});
  out.columns.push_back({"g1_mean_high_mm", "to", "mm", g1});
  out.columns.push_back({"g2_mean_low_mm", "from", "mm", g2});
  out.columns.push_back({"g2_mean_high_mm", "to", "mm", g2});
  out.columns.push_back({"time_s", "time", "s", ""});
  bool any = false;
  for (const ShownMethod& m : data.methods) {
    std::vector<Cell> row{m.name};
    for (const auto& e : {m.g1, m.g2}) {
      row.push_back(e ? number(e->mean_low_mm, kErrorDecimals) : Cell{});
      row.push_back(e ? number(e->mean_high_mm, kErrorDecimals) : Cell{});
      any = any || (e && e->mean_low_mm);
    }
    row.push_back(number(m.seconds, 3));
    any = any || m.seconds;
    out.rows.push_back(std::move(row));
  }
  if (!any) out.rows.clear();
  out.main_row = result_index(data);
  return out;
}

Table points_table(const ReportData& data) {
  Table out{.id = "points", .caption = "All measured points"};
  out.columns = point_columns(true);
  const auto add = [&](std::string key, std::string unit) {
    out.columns.push_back({.key = key, .title = key, .unit = std::move(unit), .group = ""});
  };
  for (const ShownJoint& joint : data.joints) {
    add(fmt::format("{}_{}", joint.name, joint.unit), joint.unit);
  }
  const std::span<const std::string_view> axes = axes_of(data);
  for (const std::string_view axis : axes) add(fmt::format("target_{}_mm", axis), "mm");
  for (const std::string_view axis : axes) add(fmt::format("{}_mm", axis), "mm");
  add("dials", "");
  add("temperature_c", "\u00B0C");
  add("time_s", "s");
  for (std::size_t i = 0; i < data.joints.size(); ++i)
    add(fmt::format("approach{}", i + 1), "");
  for (const ShownMethod& m : data.methods) {
    for (const std::string_view axis : axes) {
      add(fmt::format("{}_e{}_mm", key_of(m.id), axis), "mm");
    }
    add(key_of(m.id) + "_error_mm", "mm");
  }
  for (const PointRow& p : data.points) {
    std::vector<Cell> row = point_cells(p, true);
    add_place(data, p, row);
    row.push_back(p.dials.empty() ? Cell{} : Cell{p.dials});
    row.push_back(number(p.temperature_c, 2));
    row.push_back(number(p.time_s, 3));
    for (std::size_t i = 0; i < data.joints.size(); ++i) {
      row.push_back(whole(i < p.approach.size() ? p.approach[i] : 0));
    }
    for (std::size_t m = 0; m < data.methods.size(); ++m) {
      const auto e = residual(p, m);
      for (int i = 0; i < data.axes; ++i) row.push_back(component(e, i, kErrorDecimals));
      row.push_back(number(position_error(p, m), kErrorDecimals));
    }
    out.rows.push_back(std::move(row));
  }
  return out;
}

Table residual_table(const ReportData& data) {
  Table out{.id = "residuals", .caption = "Measured minus modelled position"};
  out.columns = point_columns(has_repeats(data));
  for (const std::string_view axis : axes_of(data)) {
    out.columns.push_back(
        {.key = fmt::format("{}_mm", axis),
         .title = std::string(axis),
         .unit = "mm",
         .group = "measured at"});
  }
  std::vector<std::size_t> methods;
  for (std::size_t m = 0; m < data.methods.size(); ++m) {
    if (!data.methods[m].on_map) continue;
    methods.push_back(m);
    const std::string key = key_of(data.methods[m].id);
    for (const std::string_view axis : axes_of(data)) {
      out.columns.push_back(
          {.key = fmt::format("{}_e{}_mm", key, axis),
           .title = std::string(axis),
           .unit = "mm",
           .group = data.methods[m].name});
    }
  }
  const bool repeats = has_repeats(data);
  for (const PointRow& p : data.points) {
    if (!p.measured_mm) continue;
    std::vector<Cell> row = point_cells(p, repeats);
    for (int i = 0; i < data.axes; ++i) {
      row.push_back(component(p.measured_mm, i, kPositionDecimals));
    }
    for (const std::size_t m : methods) {
      for (int i = 0; i < data.axes; ++i) {
        row.push_back(component(residual(p, m), i, kErrorDecimals));
      }
    }
    out.rows.push_back(std::move(row));
  }
  return out;
}

namespace {

Table error_table_of(const ReportData& data, const std::vector<std::size_t>& points) {
  Table out{.id = "errors", .caption = "Position error by point and method"};
  out.columns = point_columns(has_repeats(data));
  for (const ShownMethod& m : data.methods) {
    out.columns.push_back(
        {.key = key_of(m.id) + "_error_mm", .title = m.name, .unit = "mm", .group = ""});
  }
  const bool repeats = has_repeats(data);
  for (const std::size_t i : points) {
    std::vector<Cell> row = point_cells(data.points[i], repeats);
    for (std::size_t m = 0; m < data.methods.size(); ++m) {
      row.push_back(number(position_error(data.points[i], m), kErrorDecimals));
    }
    out.rows.push_back(std::move(row));
  }
  return out;
}

}  // namespace

Table error_table(const ReportData& data) {
  std::vector<std::size_t> all(data.points.size());
  std::iota(all.begin(), all.end(), std::size_t{0});
  return error_table_of(data, all);
}

Table worst_points_table(const ReportData& data, std::size_t how_many) {
  const auto method = result_index(data);
  std::vector<std::size_t> order;
  if (method) {
    for (std::size_t i = 0; i < data.points.size(); ++i) {
      if (position_error(data.points[i], *method)) order.push_back(i);
    }
    std::stable_sort(order.begin(), order.end(), [&](std::size_t a, std::size_t b) {
      return *position_error(data.points[a], *method) >
             *position_error(data.points[b], *method);
    });
    order.resize(std::min(order.size(), how_many));
  }
  Table out = error_table_of(data, order);
  out.id = "worst_points";
  out.caption = fmt::format("The {} largest remaining errors", order.size());
  return out;
}

Table measurement_table(const ReportData& data) {
  Table out{.id = "measurements", .caption = "Measured positions"};
  out.columns = point_columns(has_repeats(data));
  for (const ShownJoint& joint : data.joints) {
    out.columns.push_back(
        {fmt::format("{}_{}", joint.name, joint.unit), symbol(joint.name), joint.unit,
         "encoders"});
  }
  for (const std::string_view axis : axes_of(data)) {
    out.columns.push_back(
        {fmt::format("target_{}_mm", axis), std::string(axis), "mm", "target"});
  }
  for (const std::string_view axis : axes_of(data)) {
    out.columns.push_back({fmt::format("{}_mm", axis), std::string(axis), "mm", "measured"});
  }
  const bool has_dials =
      !data.head.instruments.empty() ||
      std::ranges::any_of(data.points, [](const PointRow& p) { return !p.dials.empty(); });
  if (has_dials) out.columns.push_back({"dials", "dials", "", ""});
  out.columns.push_back({"temperature_c", "temp.", "\u00B0C", ""});
  const bool repeats = has_repeats(data);
  for (const PointRow& p : data.points) {
    std::vector<Cell> row = point_cells(p, repeats);
    add_place(data, p, row);
    if (has_dials) row.push_back(p.dials.empty() ? Cell{} : Cell{p.dials});
    row.push_back(number(p.temperature_c, 2));
    out.rows.push_back(std::move(row));
  }
  return out;
}

Table convergence_table(const ReportData& data, bool only_changes) {
  Table out{.id = "convergence", .caption = "Best objective (RMSE) by iteration"};
  out.columns = {column("iteration", "iteration")};
  std::size_t longest = 0;
  for (const studies::Convergence& c : data.convergence) {
    out.columns.push_back(
        {.key = key_of(c.name) + "_rmse_mm", .title = c.name, .unit = "mm", .group = ""});
    longest = std::max(longest, c.best_mm.size());
  }
  for (std::size_t i = 0; i < longest; ++i) {
    std::vector<Cell> row{whole(static_cast<long long>(i))};
    for (const studies::Convergence& c : data.convergence) {
      row.push_back(i < c.best_mm.size() ? number(c.best_mm[i], 6) : Cell{});
    }
    out.rows.push_back(std::move(row));
  }
  if (only_changes) keep_changes(out, 1, false);
  return out;
}

Table trace_table(const ReportData& data, bool only_changes) {
  Table out{
      .id = "parameters_by_iteration",
      .caption = "Identified minus nominal, by step of the filter and of the swarm"};
  out.rows_on_page = 260;
  out.columns = {column("stage", "stage"), column("step", "step")};
  for (const ShownParameter& p : data.parameters) {
    out.columns.push_back(
        {.key = fmt::format("{}_{}", p.name, p.unit),
         .title = symbol(p.name),
         .unit = p.unit,
         .group = ""});
  }
  for (const studies::Trace& trace : data.traces) {
    for (std::size_t i = 0; i < trace.error.size(); ++i) {
      std::vector<Cell> row{trace.name, whole(static_cast<long long>(i))};
      for (std::size_t p = 0; p < data.parameters.size(); ++p) {
        const double shown_value =
            trace.error[i][static_cast<Eigen::Index>(p)] * shown_per_unit(data.parameters[p]);
        row.push_back(number(shown_value, 4));
      }
      out.rows.push_back(std::move(row));
    }
  }
  if (only_changes) keep_changes(out, 2, true);
  return out;
}

}  // namespace sixdial::report
