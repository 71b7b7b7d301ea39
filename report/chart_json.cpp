#include "report/chart_json.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <string_view>

#include "report/text.h"

namespace sixdial::report {
namespace {

using nlohmann::json;

/// Five significant digits: a tenth of a pixel, a quarter of the bytes.
double for_drawing(double value) { return std::stod(fmt::format("{:.5g}", value)); }

std::string_view name_of(Mark mark) {
  switch (mark) {
    case Mark::kLine:
      return "line";
    case Mark::kStep:
      return "step";
    case Mark::kDots:
      return "dots";
    case Mark::kLineAndDots:
      return "line_dots";
    case Mark::kArrows:
      return "arrows";
    case Mark::kRuleAcross:
      return "rule_across";
    case Mark::kRuleUp:
      return "rule_up";
    case Mark::kBand:
      return "band";
    case Mark::kBars:
      return "bars";
  }
  return "dots";
}

std::size_t marks_of(const Series& s) { return std::max(s.x.size(), s.y.size()); }

/// What an arrow and a dot take on the page.
std::size_t weight_of(const Series& s) { return s.dx.empty() ? 1 : 2; }

std::size_t weight_of(const Chart& chart) {
  std::size_t weight = 0;
  for (const Panel& p : chart.panels) {
    for (const Series& s : p.series) weight += weight_of(s) * marks_of(s);
  }
  return weight;
}

/// The most marks that a series may have; no limit where the chart is small enough.
std::size_t share_of(const Chart& chart, std::size_t most) {
  std::size_t series = 0;
  for (const Panel& p : chart.panels) series += p.series.size();
  const std::size_t weight = weight_of(chart);
  if (weight <= most) return weight;
  return std::max<std::size_t>(2, most / series);
}

std::vector<std::size_t> drawn_marks(const Series& s, std::size_t share) {
  const std::size_t n = marks_of(s);
  const std::size_t most = std::max<std::size_t>(2, share / weight_of(s));
  const auto fields = {&s.x, &s.y, &s.dx, &s.dy, &s.high};
  std::vector<std::size_t> out;
  for (std::size_t k = 0, last = std::min(n, most); k < last; ++k) {
    const std::size_t i = n <= most ? k : k * (n - 1) / (most - 1);
    const bool whole = std::all_of(fields.begin(), fields.end(), [&](const auto* field) {
      return field->empty() || (i < field->size() && std::isfinite((*field)[i]));
    });
    if (whole) out.push_back(i);
  }
  return out;
}

json series_json(const Series& s, std::size_t share) {
  json out{{"mark", name_of(s.mark)}, {"style", s.style}};
  if (!s.name.empty()) out["name"] = valid_utf8(s.name);
  if (!s.label.empty()) out["label"] = valid_utf8(s.label);
  const std::vector<std::size_t> marks = drawn_marks(s, share);
  const auto put = [&](const char* key, const std::vector<double>& values) {
    if (values.empty()) return;
    json list = json::array();
    for (const std::size_t i : marks) list.push_back(for_drawing(values[i]));
    out[key] = std::move(list);
  };
  put("x", s.x);
  put("y", s.y);
  put("dx", s.dx);
  put("dy", s.dy);
  put("high", s.high);
  return out;
}

json axis_json(const Axis& a) {
  json out{{"label", valid_utf8(a.label)}};
  if (!a.unit.empty()) out["unit"] = valid_utf8(a.unit);
  if (a.logarithmic) out["log"] = true;
  if (a.square_root) out["sqrt"] = true;
  if (a.low && std::isfinite(*a.low)) out["low"] = for_drawing(*a.low);
  if (a.high && std::isfinite(*a.high)) out["high"] = for_drawing(*a.high);
  return out;
}

}  // namespace

std::size_t marks_allowed(const std::vector<const Chart*>& charts) {
  constexpr std::size_t kStep = 100;
  std::size_t most = kMarksOnChart;
  const auto together = [&] {
    std::size_t sum = 0;
    for (const Chart* chart : charts) sum += std::min(most, weight_of(*chart));
    return sum;
  };
  while (most > kStep && together() > kMarksOnPage) most -= kStep;
  return most;
}

json chart_json(const Chart& chart, std::size_t most) {
  const std::size_t share = share_of(chart, most);
  json panels = json::array();
  for (const Panel& p : chart.panels) {
    json series = json::array();
    for (const Series& s : p.series) series.push_back(series_json(s, share));
    json panel{
        {"title", valid_utf8(p.title)},
        {"x", axis_json(p.x)},
        {"y", axis_json(p.y)},
        {"series", std::move(series)}};
    if (p.equal_scales) panel["equal"] = true;
    if (p.arrow_scale != 1.0) panel["arrow_scale"] = for_drawing(p.arrow_scale);
    if (p.arrow_key > 0.0) panel["arrow_key"] = for_drawing(p.arrow_key);
    panels.push_back(std::move(panel));
  }
  return {
      {"panels", std::move(panels)},
      {"in_a_row", std::max(1, chart.panels_in_a_row)},
      {"height", chart.panel_height}};
}

bool is_thinned(const Chart& chart, std::size_t most) {
  const std::size_t share = share_of(chart, most);
  for (const Panel& p : chart.panels) {
    for (const Series& s : p.series) {
      if (marks_of(s) > std::max<std::size_t>(2, share / weight_of(s))) return true;
    }
  }
  return false;
}

}  // namespace sixdial::report
