#include "report/figures.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "report/tables.h"
#include "report/text.h"
#include "report/views.h"

namespace sixdial::report {
namespace {

/// Of an axis of errors: what a dial resolves. Less would make noise of rounding look dramatic.
constexpr double kLeastSpan_mm = 0.001;
constexpr double kFlat =
    0.02;  // a swarm that gains less than this in its last half has settled

/// Style of each method, so that a method looks the same in every chart.
std::vector<int> method_styles(const ReportData& data) {
  std::vector<int> out(data.methods.size(), -1);
  const auto result = result_index(data);
  if (!out.empty()) out.front() = kStyleBefore;
  if (result && *result > 0) {
    out[*result] = kStyleResult;
    for (std::size_t i = *result; i-- > 1;) {
      if (!data.methods[i].has_residual_model) {
        out[i] = kStyleKinematic;
        break;
      }
    }
  }
  int next = kStyleRival;
  for (int& style : out) {
    if (style >= 0) continue;
    style = next;
    next = next == kStyleG1 - 1 ? kStyleRival : next + 1;
  }
  return out;
}

struct Extent {
  double low = std::numeric_limits<double>::infinity();
  double high = -std::numeric_limits<double>::infinity();
  void add(double v) {
    low = std::min(low, v);
    high = std::max(high, v);
  }
  [[nodiscard]] double size() const { return high - low; }
};

std::string set_name(const std::string& set) {
  if (set == "G1") return "G1 calibration";
  if (set == "G2") return "G2 validation";
  return set;
}

std::vector<std::string> sets_of(const ReportData& data) {
  std::vector<std::string> out;
  for (const PointRow& p : data.points) {
    if (std::find(out.begin(), out.end(), p.set) == out.end()) out.push_back(p.set);
  }
  std::sort(out.begin(), out.end());
  return out;
}

int set_style(const std::string& set) {
  return set == "G1" ? kStyleG1 : set == "G2" ? kStyleG2 : kStyleRival;
}

/// How far arrows agree with their nearest neighbour's: 1 if all are the same, 0 without order.
/// Sum of e . e' over sum of |e| |e'|, for each point and the nearest other.
std::optional<double> agreement(const ReportData& data, std::size_t method) {
  std::vector<const PointRow*> points;
  for (const PointRow& p : data.points) {
    if (p.measured_mm && position_error(p, method)) points.push_back(&p);
  }
  // Neighbours are looked for in a plain loop: two thousand points are enough for a percentage.
  const std::size_t step = 1 + points.size() / 2000;
  double together = 0.0;
  double apart = 0.0;
  for (std::size_t i = 0; i < points.size(); i += step) {
    const PointRow* nearest = nullptr;
    double nearest_mm = std::numeric_limits<double>::infinity();
    for (const PointRow* other : points) {
      const bool same_point = other->set == points[i]->set && other->point == points[i]->point;
      const double distance_mm = (*other->measured_mm - *points[i]->measured_mm).norm();
      if (same_point || distance_mm >= nearest_mm) continue;
      nearest = other;
      nearest_mm = distance_mm;
    }
    if (nearest == nullptr) continue;
    const Eigen::VectorXd e = *points[i]->residual_mm[method];
    const Eigen::VectorXd f = *nearest->residual_mm[method];
    together += e.dot(f);
    apart += e.norm() * f.norm();
  }
  if (!(apart > 0.0)) return std::nullopt;
  return together / apart;
}

std::optional<double> largest_error(const ReportData& data, std::size_t method) {
  std::optional<double> out;
  for (const PointRow& p : data.points) {
    if (const auto error = position_error(p, method)) out = std::max(out.value_or(0.0), *error);
  }
  return out;
}

/// What a method leaves at each measured position; the longest arrow is drawn `longest_mm`
/// long.
ArrowMap map_of(
    const ReportData& data, std::size_t method, const std::vector<Axis>& axes,
    double longest_mm) {
  ArrowMap out{.title = data.methods[method].name, .axes = axes};
  const double largest_mm = largest_error(data, method).value_or(0.0);
  out.arrow_scale = largest_mm > 0.0 ? round_down(longest_mm / largest_mm) : 1.0;
  out.arrow_key = largest_mm > 0.0 ? round_down(largest_mm) : 0.0;
  for (const std::string& set : sets_of(data)) {
    Arrows arrows{.name = set_name(set), .style = set_style(set)};
    for (const PointRow& p : data.points) {
      if (p.set != set || !p.measured_mm || !position_error(p, method)) continue;
      arrows.from_mm.push_back(*p.measured_mm);
      arrows.by_mm.push_back(*p.residual_mm[method]);
    }
    if (!arrows.from_mm.empty()) out.arrows.push_back(std::move(arrows));
  }
  return out;
}

/// The axes of a map of all measured positions, each with a margin, and the longest of the
/// extents [mm], at least 1 mm. No axes: nothing was measured.
std::pair<std::vector<Axis>, double> map_axes(const ReportData& data) {
  std::vector<Extent> extents(static_cast<std::size_t>(data.axes));
  for (const PointRow& p : data.points) {
    if (!p.measured_mm) continue;
    for (std::size_t i = 0; i < extents.size(); ++i) {
      extents[i].add((*p.measured_mm)[static_cast<Eigen::Index>(i)]);
    }
  }
  double span_mm = 1.0;
  for (const Extent& each : extents) {
    if (!(each.size() >= 0.0)) return {};
    span_mm = std::max(span_mm, each.size());
  }
  const double margin_mm = 0.13 * span_mm;
  std::vector<Axis> axes;
  for (std::size_t i = 0; i < extents.size(); ++i) {
    axes.push_back(
        {.label = std::string(coordinates(data.axes)[i]),
         .unit = "mm",
         .low = extents[i].low - margin_mm,
         .high = extents[i].high + margin_mm});
  }
  return {std::move(axes), span_mm};
}

std::string example_of_the_sign(int axes) {
  const View& first = views(axes).front();
  return fmt::format(
      "Example of the sign: an arrow to the right{}, (+0.010{}) mm, is a tool 0.010 mm further "
      "along +x than the model says.",
      first.from.empty() ? "" : fmt::format(" in the view {}", first.from),
      axes == 2 ? ", 0" : ", 0, 0");
}

std::string describe_convergence(const ReportData& data) {
  std::string out;
  for (const studies::Convergence& c : data.convergence) {
    if (c.best_mm.empty()) continue;
    const double end = c.best_mm.back();
    const auto reached = std::find_if(
        c.best_mm.begin(), c.best_mm.end(), [&](double v) { return v <= end * (1.0 + 1e-3); });
    out += fmt::format(
        "{} ends at {} mm and is within 0.1 % of that from iteration {} of {}. ", c.name,
        fixed(end, 6), reached - c.best_mm.begin(), c.best_mm.size() - 1);
  }
  if (data.rmse_mm && data.least_squares_rmse_mm) {
    const double above_nm = (*data.rmse_mm - *data.least_squares_rmse_mm) * 1e6;
    out += fmt::format(
        "The parameters' RMSE is {} mm, {} nm above the least-squares minimum.",
        fixed(*data.rmse_mm, 6),
        std::abs(above_nm) < 0.1 ? "less than 0.1" : fixed(above_nm, 1));
  }
  return out;
}

}  // namespace

double round_down(double value) {
  const double power = std::pow(10.0, std::floor(std::log10(value)));
  for (const double step : {5.0, 2.0}) {
    if (step * power <= value * (1.0 + 1e-12)) return step * power;
  }
  return power;
}

std::optional<Figure> residual_map(const ReportData& data) {
  const auto [axes, span_mm] = map_axes(data);
  if (axes.empty()) return std::nullopt;
  const double longest_mm =
      0.16 * span_mm;  // as drawn: long enough to see, short enough to part
  Figure out{.id = "residual_map", .title = "Residual map"};
  std::string here;
  int maps = 0;
  for (std::size_t m = 0; m < data.methods.size(); ++m) {
    if (!data.methods[m].on_map || !largest_error(data, m)) continue;
    for (Panel& panel : panels_of(map_of(data, m, axes, longest_mm))) {
      out.chart.panels.push_back(std::move(panel));
    }
    ++maps;
    here += fmt::format("{}: up to {}", data.methods[m].name, length(*largest_error(data, m)));
    if (const auto agreed = agreement(data, m)) {
      here += fmt::format(", neighbours agree by {} %", fixed(100.0 * *agreed, 0));
    }
    here += ". ";
  }
  if (out.chart.panels.empty()) return std::nullopt;
  out.chart.panels_in_a_row = map_panels_in_a_row(data.axes, std::min(3, maps));
  out.shows =
      "Each arrow starts at a measured position and points from where the model puts the tool "
      "to where it was measured, enlarged as written over each map. " +
      example_of_the_sign(data.axes) + views_in_words(data.axes);
  out.good =
      "Short arrows without order: neighbouring arrows agree by less than about 20 % (negative "
      "figures are no order either). Arrows that agree (100 %: all the same) show an error "
      "that the "
      "model does not contain.";
  out.here = here;
  out.table = residual_table(data);
  return out;
}

std::optional<Figure> error_by_point(const ReportData& data) {
  const std::vector<int> styles = method_styles(data);
  Figure out{.id = "error_by_point", .title = "Position error by point and method"};
  out.chart.panels_in_a_row = 1;
  out.chart.panel_height = 195;
  Extent shared;
  for (const std::string& set : sets_of(data)) {
    Panel panel;
    panel.title = set_name(set);
    panel.x = {.label = "sample of the set, in order of measurement", .unit = ""};
    panel.y = {.label = "position error", .unit = "mm", .logarithmic = true};
    for (std::size_t m = 0; m < data.methods.size(); ++m) {
      Series series{
          .name = data.methods[m].name, .mark = Mark::kLineAndDots, .style = styles[m]};
      double place = 0.0;
      for (const PointRow& p : data.points) {
        if (p.set != set) continue;
        place += 1.0;
        const auto error = position_error(p, m);
        if (!error || !(*error > 0.0)) continue;  // a logarithm has no place for zero
        series.x.push_back(place);
        series.y.push_back(*error);
        shared.add(*error);
      }
      if (!series.x.empty()) panel.series.push_back(std::move(series));
    }
    if (!panel.series.empty()) out.chart.panels.push_back(std::move(panel));
  }
  if (out.chart.panels.empty()) return std::nullopt;
  for (Panel& panel : out.chart.panels) {
    panel.y.low = shared.low * 0.8;
    panel.y.high = shared.high * 1.3;
  }
  out.shows =
      "The distance between measured and modelled position at every point, on a logarithmic "
      "scale (the paper's Fig. 10). G1 was fitted, G2 was not.";
  out.good =
      "The lower curves lie equally low in G1 and in G2, and no point stands out. A result "
      "that is "
      "good in G1 alone has learned its points by heart.";
  if (const auto result = result_index(data)) {
    const ShownMethod& m = data.methods[*result];
    out.here = fmt::format("{}: ", m.name);
    if (m.g1)
      out.here +=
          fmt::format("G1 mean {}, worst {}. ", length(m.g1->mean_mm), length(m.g1->max_mm));
    if (m.g2)
      out.here +=
          fmt::format("G2 mean {}, worst {}.", length(m.g2->mean_mm), length(m.g2->max_mm));
  }
  out.table = error_table(data);
  return out;
}

std::optional<Figure> convergence(const ReportData& data) {
  Figure out{.id = "convergence", .title = "Convergence of the swarms"};
  bool settled = true;
  for (const studies::Convergence& c : data.convergence) {
    if (c.best_mm.empty()) continue;
    Panel panel;
    panel.title = c.name;
    panel.x = {.label = "iteration", .unit = ""};
    panel.y = {.label = "RMSE", .unit = "mm"};
    Series series{
        .name = "best particle so far", .mark = Mark::kStep, .style = kStyleKinematic};
    for (std::size_t i = 0; i < c.best_mm.size(); ++i) {
      if (!std::isfinite(c.best_mm[i])) continue;
      series.x.push_back(static_cast<double>(i));
      series.y.push_back(c.best_mm[i]);
    }
    if (series.x.empty()) continue;
    const double halfway = c.best_mm[c.best_mm.size() / 2];
    settled = settled && halfway <= c.best_mm.back() * (1.0 + kFlat);
    panel.series.push_back(std::move(series));
    if (data.least_squares_rmse_mm) {
      panel.series.push_back(
          {.name = "least-squares minimum",
           .mark = Mark::kRuleAcross,
           .style = kStyleBefore,
           .y = {*data.least_squares_rmse_mm}});
    }
    Extent drawn;
    for (const Series& each : panel.series) {
      for (const double y : each.y) drawn.add(y);
    }
    if (drawn.size() < kLeastSpan_mm) {
      const double middle = 0.5 * (drawn.low + drawn.high);
      panel.y.low = std::max(0.0, middle - 0.5 * kLeastSpan_mm);
      panel.y.high = *panel.y.low + kLeastSpan_mm;
    }
    out.chart.panels.push_back(std::move(panel));
  }
  if (out.chart.panels.empty()) return std::nullopt;
  out.chart.panels_in_a_row =
      static_cast<int>(std::min<std::size_t>(2, out.chart.panels.size()));
  out.shows =
      "Root mean square position error on G1 of the best particle so far, by iteration (the "
      "paper's Fig. 8). QPSO-1 tunes the filter's noise matrices, QPSO-2 the parameters.";
  out.good =
      "The curve is flat long before its end, and QPSO-2 ends on the dashed line: no "
      "parameters fit G1 better than the least-squares minimum. The scale shows at least 0.001 "
      "mm, "
      "the step of a dial.";
  out.here = (settled ? "Flat in their second half. " : "Still falling in the second half. ") +
             describe_convergence(data);
  out.table = convergence_table(data, true);
  return out;
}

namespace {

/// Which length and which angle the last trace moved most after the first.
std::string moved_most(const ReportData& data) {
  const studies::Trace& last = data.traces.back();
  if (data.traces.size() < 2 || last.error.empty() || data.traces.front().error.empty()) {
    return "";
  }
  const Eigen::VectorXd change = last.error.back() - data.traces.front().error.back();
  std::string words;
  for (const bool angle : {false, true}) {
    const ShownParameter* most = nullptr;
    double shown = 0.0;
    for (std::size_t k = 0; k < data.parameters.size(); ++k) {
      const ShownParameter& row = data.parameters[k];
      const double moved = change[static_cast<Eigen::Index>(k)] * shown_per_unit(row);
      if ((row.unit == "deg") != angle) continue;
      if (most != nullptr && std::abs(moved) <= std::abs(shown)) continue;
      most = &row;
      shown = moved;
    }
    if (most == nullptr) continue;
    words += fmt::format(
        "{}{} by {} {} (most of the {})", words.empty() ? "" : " and ", symbol(most->name),
        fixed(shown, 4), most->unit, angle ? "angles" : "lengths");
  }
  return words.empty() ? "" : fmt::format("After the filter, {} moved {}. ", last.name, words);
}

}  // namespace

std::optional<Figure> parameter_traces(const ReportData& data) {
  std::size_t steps = 0;
  for (const studies::Trace& trace : data.traces) steps += trace.error.size();
  if (steps == 0) return std::nullopt;
  Figure out{.id = "parameters_by_iteration", .title = "Parameter errors by step"};
  out.chart.panels_in_a_row = 5;
  out.chart.panel_height = 170;
  for (std::size_t k = 0; k < data.parameters.size(); ++k) {
    const auto i = static_cast<Eigen::Index>(k);
    const ShownParameter& row = data.parameters[k];
    const double per_unit = shown_per_unit(row);
    Panel panel;
    panel.title = row.meaning.empty() ? row.name : row.meaning;
    panel.x = {.label = "step", .unit = "", .square_root = true};
    panel.y = {.label = symbol(row.name), .unit = row.unit};
    double place = 0.0;
    int style = kStyleKinematic;
    for (const studies::Trace& trace : data.traces) {
      Series series{
          .name = fmt::format("{}, by {}", trace.name, trace.step),
          .mark = Mark::kStep,
          .style = style};
      for (const Eigen::VectorXd& error : trace.error) {
        series.x.push_back(place);
        series.y.push_back(error[i] * per_unit);
        place += 1.0;
      }
      if (!series.x.empty()) panel.series.push_back(std::move(series));
      style = style == kStyleKinematic ? kStyleResult : style + 1;
    }
    out.chart.panels.push_back(std::move(panel));
  }
  out.shows =
      "Identified minus nominal value of each parameter, first while the filter takes in one "
      "point "
      "after the other, then while QPSO-2 refines them (the paper's Fig. 9). Each panel has "
      "its own "
      "scale; steps are spaced by their square root, so that the first ones can be seen.";
  out.good =
      "The lines move over the first dozens of points and are level from then on. Two "
      "parameters "
      "that keep moving together are not told apart by these poses.";
  out.here = moved_most(data) +
             fmt::format("{} in all.", counted(static_cast<long long>(steps), "step", "steps"));
  out.table = trace_table(data, true);
  return out;
}

}  // namespace sixdial::report
