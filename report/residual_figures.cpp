// What the identified parameters leave over, held against everything that was recorded beside
// it: an error of the robot shows as a slope, a wave or two levels; noise as a level cloud.
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <limits>

#include "geometry/units.h"
#include "report/figures.h"
#include "report/tables.h"
#include "report/text.h"
#include "report/views.h"

namespace sixdial::report {
namespace {

constexpr std::size_t kClasses = 6;  // equal counts: enough to see a wave, not the noise
constexpr std::size_t kFewest = 3;   // points in a class, below which its mean says little
constexpr double kClear = 5.0;   // standard deviations above chance from which order is said
constexpr double kApart = 0.12;  // the outer components of a side from its middle, as drawn
constexpr std::array kStyles{kStyleKinematic, kStyleResult, kStyleRival};  // of x, y, z

struct Covariate {
  std::string key, label, unit;
  bool two_sides = false;
  std::function<std::optional<double>(const PointRow&)> of;
};

std::vector<Covariate> covariates(const std::vector<ShownJoint>& joints) {
  std::vector<Covariate> out;
  for (std::size_t joint = 0; joint < joints.size(); ++joint) {
    const geometry::ShownUnit unit = geometry::shown_unit(joints[joint].unit);
    out.push_back(
        {fmt::format("{}_{}", joints[joint].name, unit.name),
         fmt::format(
             "encoder {} {}", joints[joint].unit == "rad" ? "angle" : "value", joint + 1),
         std::string(unit.name), false,
         [joint, unit](const PointRow& p) -> std::optional<double> {
           if (!p.q) return std::nullopt;
           return unit.per_unit * (*p.q)[static_cast<Eigen::Index>(joint)];
         }});
  }
  out.push_back({"time_min", "time", "min", false, [](const PointRow& p) {
                   return p.time_s ? std::optional(*p.time_s / 60.0) : std::nullopt;
                 }});
  out.push_back({"temperature_c", "temperature", "\u00B0C", false, [](const PointRow& p) {
                   return p.temperature_c;
                 }});
  for (std::size_t joint = 0; joint < joints.size(); ++joint) {
    out.push_back(
        {fmt::format("approach{}", joint + 1),
         fmt::format("side from which joint {} arrives", joint + 1), "", true,
         [joint](const PointRow& p) -> std::optional<double> {
           if (joint >= p.approach.size() || p.approach[joint] == 0) return std::nullopt;
           return p.approach[joint];
         }});
  }
  return out;
}

struct Value {
  double at = 0.0;
  geometry::Position e{};  // component by component
};

/// [first, last) of `values` sorted by `at`: the two sides, or classes of equal count.
std::vector<std::pair<std::size_t, std::size_t>> classes(
    const std::vector<Value>& values, bool two_sides) {
  std::vector<std::pair<std::size_t, std::size_t>> out;
  const std::size_t n = values.size();
  if (two_sides) {
    const auto up = std::ranges::find_if(values, [](const Value& v) { return v.at > 0.0; });
    const auto first_up = static_cast<std::size_t>(up - values.begin());
    if (first_up > 0) out.emplace_back(0, first_up);
    if (first_up < n) out.emplace_back(first_up, n);
    return out;
  }
  const std::size_t k = std::clamp<std::size_t>(n / kFewest, 1, kClasses);
  for (std::size_t i = 0; i < k; ++i) out.emplace_back(i * n / k, (i + 1) * n / k);
  return out;
}

geometry::Position mean_of(
    const std::vector<Value>& values, std::pair<std::size_t, std::size_t> part) {
  geometry::Position sum = geometry::Position::Zero(values.front().e.size());
  for (std::size_t i = part.first; i < part.second; ++i) sum += values[i].e;
  return sum / static_cast<double>(part.second - part.first);
}

/// Share of the squares about the mean that the classes' means take.
double explained(
    const std::vector<Value>& values,
    const std::vector<std::pair<std::size_t, std::size_t>>& parts) {
  const geometry::Position mean = mean_of(values, {0, values.size()});
  double all = 0.0;
  double between = 0.0;
  for (const Value& v : values) all += (v.e - mean).squaredNorm();
  for (const auto& part : parts) {
    between += static_cast<double>(part.second - part.first) *
               (mean_of(values, part) - mean).squaredNorm();
  }
  return all > 0.0 ? between / all : 0.0;
}

/// The delivered parameters without their residual model ("ekf_dqpso" of "ekf_dqpso+anfis"),
/// else the last method without one: what a network would learn away must still be seen.
std::optional<std::size_t> kinematic_index(const ReportData& data) {
  const auto result = result_index(data);
  if (!result || *result == 0) return std::nullopt;
  const std::string& id = data.methods[*result].id;
  const auto alone =
      std::ranges::find(data.methods, id.substr(0, id.find('+')), &ShownMethod::id);
  if (alone != data.methods.end() && alone != data.methods.begin()) {
    return static_cast<std::size_t>(alone - data.methods.begin());
  }
  for (std::size_t i = *result; i > 0; --i) {
    if (!data.methods[i].has_residual_model) return i;
  }
  return std::nullopt;
}

Panel panel_of(const Covariate& by, const std::vector<Value>& values, int axes) {
  Panel panel;
  panel.title = fmt::format("by {}", by.label);
  panel.x = {
      .label = by.two_sides ? "-1 turning down, +1 turning up" : by.label, .unit = by.unit};
  if (by.two_sides) {
    panel.x.low = -2.0;
    panel.x.high = 2.0;
  }
  panel.y = {.label = "residual", .unit = "mm"};
  for (int axis = 0; axis < axes; ++axis) {
    const auto k = static_cast<std::size_t>(axis);
    Series series{
        .name = fmt::format("along {}", coordinates(axes)[k]),
        .mark = Mark::kDots,
        .style = kStyles[k]};
    const double aside = by.two_sides ? kApart * (2.0 * axis / (axes - 1) - 1.0) : 0.0;
    for (const Value& v : values) {
      series.x.push_back(v.at + aside);
      series.y.push_back(v.e[axis]);
    }
    panel.series.push_back(std::move(series));
  }
  return panel;
}

void say_what_it_shows(const std::string& method, int axes, Figure& out) {
  out.shows = fmt::format(
      "Measured minus modelled position with the parameters of {} alone, {} components, "
      "against "
      "everything that was recorded with it. One scale for all.",
      method, axes == 2 ? "both" : "all three");
  out.good =
      "A level cloud about zero in every panel. A slope or a wave over an angle comes from a "
      "joint "
      "or a link, over time from a drift, over temperature from thermal growth; two levels by "
      "the "
      "side of arrival are backlash.";
}

/// What each group leaves, to be filled.
Table table_of_groups(int axes) {
  Table out{.id = "residual_by", .caption = "Mean of what is left, in groups of equal count"};
  for (const char* each : {"by", "unit", "from", "to", "points"}) {
    out.columns.push_back(column(each, each));
  }
  for (const std::string_view axis : coordinates(axes)) {
    out.columns.push_back(
        column(fmt::format("mean_{}_mm", axis), fmt::format("mean along {}", axis), "mm"));
  }
  out.columns.push_back(column("rms_mm", "rms", "mm"));
  return out;
}

/// Lowest and highest component that is drawn.
struct Range {
  double low_mm = 0.0, high_mm = 0.0;
};

void add_group(
    const Covariate& by, const std::vector<Value>& values,
    std::pair<std::size_t, std::size_t> part, Table& table, Range& range) {
  double squares = 0.0;
  for (std::size_t i = part.first; i < part.second; ++i) {
    squares += values[i].e.squaredNorm();
    range.low_mm = std::min(range.low_mm, values[i].e.minCoeff());
    range.high_mm = std::max(range.high_mm, values[i].e.maxCoeff());
  }
  const auto count = static_cast<long long>(part.second - part.first);
  std::vector<Cell> row{
      by.label, by.unit, number(values[part.first].at, by.two_sides ? 0 : 2),
      number(values[part.second - 1].at, by.two_sides ? 0 : 2), whole(count)};
  for (const double mean : mean_of(values, part)) row.push_back(number(mean));
  row.push_back(number(std::sqrt(squares / static_cast<double>(count))));
  table.rows.push_back(std::move(row));
}

}  // namespace

std::optional<Figure> residual_by(const ReportData& data) {
  const auto method = kinematic_index(data);
  if (!method) return std::nullopt;
  Figure out{.id = "residual_by", .title = "What is left, by what it may depend on"};
  out.chart.panels_in_a_row = 3;
  out.chart.panel_height = 210;
  out.table = table_of_groups(data.axes);
  double clearest = -std::numeric_limits<double>::infinity();
  std::string most;
  Range range;
  for (const Covariate& by : covariates(data.joints)) {
    std::vector<Value> values;
    for (const PointRow& p : data.points) {
      const auto at = by.of(p);
      if (!at || !position_error(p, *method)) continue;
      values.push_back({*at, *p.residual_mm[*method]});
    }
    if (values.size() < 2 * kFewest) continue;
    std::ranges::stable_sort(values, {}, &Value::at);
    if (values.front().at == values.back().at) continue;  // nothing to depend on
    const auto parts = classes(values, by.two_sides);
    for (const auto& part : parts) add_group(by, values, part, out.table, range);
    const double share = explained(values, parts);
    const double chance =
        static_cast<double>(parts.size() - 1) / static_cast<double>(values.size() - 1);
    // Of noise, share / chance has mean 1 and this standard deviation: chi-squared over its
    // degrees of freedom, of which each component has one less than there are groups.
    const double spread = std::sqrt(
        2.0 / data.axes / static_cast<double>(std::max<std::size_t>(1, parts.size() - 1)));
    if (chance > 0.0 && (share / chance - 1.0) / spread > clearest) {
      clearest = (share / chance - 1.0) / spread;
      most = fmt::format(
          "Clearest by {}: the means of its groups explain {} % of the mean square, where "
          "chance "
          "alone would explain {} %",
          by.label, fixed(100.0 * share, 0), fixed(100.0 * chance, 0));
    }
    out.chart.panels.push_back(panel_of(by, values, data.axes));
  }
  if (out.chart.panels.empty()) return std::nullopt;
  const double air_mm = 0.05 * (range.high_mm - range.low_mm);
  for (Panel& panel : out.chart.panels) {
    panel.y.low = range.low_mm - air_mm;
    panel.y.high = range.high_mm + air_mm;
  }
  say_what_it_shows(data.methods[*method].name, data.axes, out);
  out.here = most.empty() ? "Nothing to compare."
                          : fmt::format(
                                "{}: {}.", most,
                                clearest >= kClear
                                    ? "this is an error that the parameters do not contain"
                                    : "that is no clear dependence");
  return out;
}

Table dial_table(const ReportData& data) {
  Table out{.id = "residual_by_dial", .caption = "What is left of each dial's readings"};
  out.columns = {
      column("dial", "dial"),
      column("readings", "readings"),
      column("before_median_mm", "median before", "mm"),
      column("median_mm", "median", "mm"),
      column("spread_mm", "spread (robust, k = 1)", "mm"),
      column("largest_mm", "largest", "mm")};
  for (const studies::DialRow& each : data.dials) {
    out.rows.push_back(
        {each.dial, whole(each.readings), number(each.before_median_mm), number(each.median_mm),
         number(each.spread_mm), number(each.largest_mm)});
  }
  if (!out.rows.empty()) {
    out.notes.emplace_back(
        "Reading minus what the model with the identified parameters says, for all dials in "
        "contact, "
        "also those that the positions did not use. Good: medians of a few micrometres and "
        "similar "
        "spreads. A dial that is off by a constant stands elsewhere than the rig file says; "
        "one that "
        "scatters more is worn or loose.");
  }
  return out;
}

}  // namespace sixdial::report
