// Where in the workspace the simulation is off: the shift of the tool at each sample, before
// and after the causes, as maps.
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>

#include "report/figures.h"
#include "report/sections/diagnosis_figures.h"
#include "report/text.h"
#include "report/views.h"
#include "report/words/diagnosis_words.h"

namespace sixdial::report {
namespace {

using studies::DiagnosisResult;

constexpr std::size_t kMostMarks = 1500;

/// An even choice of the marks of each series, at most so many on the whole chart: a page stays
/// small for any session. Says so in `figure.shows`; the table keeps all.
void thin(report::Figure& figure, std::size_t most) {
  std::size_t marks = 0;
  std::size_t series_count = 0;
  for (const Panel& panel : figure.chart.panels) {
    for (const Series& series : panel.series) {
      marks += series.x.size();
      ++series_count;
    }
  }
  if (marks <= most || series_count == 0) return;
  const std::size_t share = std::max<std::size_t>(2, most / series_count);
  for (Panel& panel : figure.chart.panels) {
    for (Series& series : panel.series) {
      const std::size_t n = series.x.size();
      if (n <= share) continue;
      for (std::vector<double>* values : {&series.x, &series.y, &series.dx, &series.dy}) {
        if (values->size() != n) continue;
        for (std::size_t k = 0; k < share; ++k) {
          (*values)[k] = (*values)[k * (n - 1) / (share - 1)];
        }
        values->resize(share);
      }
    }
  }
  figure.shows += " An even choice of them is drawn; the CSV and JSON forms have all.";
}

double mean_length(const std::vector<Eigen::VectorXd>& shifts) {
  double sum = 0.0;
  for (const Eigen::VectorXd& each : shifts) sum += each.norm();
  return sum / static_cast<double>(shifts.size());
}

double longest(const std::vector<Eigen::VectorXd>& shifts) {
  double result = 0.0;
  for (const Eigen::VectorXd& each : shifts) result = std::max(result, each.norm());
  return result;
}

int axes_of(const studies::ToolShifts& shifts) { return shifts.z_mm ? 3 : 2; }

/// Where the tool was at a sample.
geometry::Position place_of(const studies::ToolShifts& shifts, std::size_t i) {
  geometry::Position out(axes_of(shifts));
  out.head<2>() << shifts.x_mm[i], shifts.y_mm[i];
  if (shifts.z_mm) out[2] = (*shifts.z_mm)[i];
  return out;
}

/// The longest extent of the places [mm].
double span_of(const studies::ToolShifts& shifts) {
  double span_mm = 0.0;
  const auto add = [&](const std::vector<double>& values) {
    if (values.empty()) return;
    const auto [low, high] = std::ranges::minmax(values);
    span_mm = std::max(span_mm, high - low);
  };
  add(shifts.x_mm);
  add(shifts.y_mm);
  if (shifts.z_mm) add(*shifts.z_mm);
  return span_mm;
}

ArrowMap shift_map(
    const studies::ToolShifts& shifts, const std::vector<Eigen::VectorXd>& shown,
    const char* title, int style, double largest_mm) {
  constexpr double kLeast_mm = 6.0;  // the longest arrow as drawn, on the table of the chart
  constexpr double kOfSpan = 0.1;    // and at least this share of the places' extent
  ArrowMap map{.title = title};
  map.arrow_scale =
      report::round_down(std::max(kLeast_mm, kOfSpan * span_of(shifts)) / largest_mm);
  map.arrow_key = report::round_down(largest_mm);
  for (const std::string_view axis : coordinates(axes_of(shifts))) {
    map.axes.push_back({.label = std::string(axis), .unit = "mm"});
  }
  if (shifts.z_mm) {  // of a flat set of places the view from the side has no height of its own
    const double room_mm = map.arrow_scale * largest_mm;
    const std::array all{&shifts.x_mm, &shifts.y_mm, &*shifts.z_mm};
    for (std::size_t i = 0; i < all.size() && !all[i]->empty(); ++i) {
      const auto [low, high] = std::ranges::minmax(*all[i]);
      map.axes[i].low = low - room_mm;
      map.axes[i].high = high + room_mm;
    }
  }
  Arrows arrows{.style = style};
  for (std::size_t i = 0; i < shown.size(); ++i) {
    arrows.from_mm.push_back(place_of(shifts, i));
    arrows.by_mm.emplace_back(shown[i]);
  }
  map.arrows.push_back(std::move(arrows));
  return map;
}

void add_map(report::Figure& figure, const ArrowMap& map) {
  for (Panel& panel : panels_of(map)) figure.chart.panels.push_back(std::move(panel));
}

report::Table shift_table(const studies::ToolShifts& shifts) {
  report::Table table{.id = "tool_shift", .caption = "Shift of the tool by sample"};
  const auto axes = coordinates(axes_of(shifts));
  table.columns = {column("sample", "sample")};
  for (const std::string_view axis : axes) {
    table.columns.push_back(column(fmt::format("{}_mm", axis), std::string(axis), "mm"));
  }
  for (const std::string_view when : {"before", "after"}) {
    for (const std::string_view axis : axes) {
      table.columns.push_back(column(
          fmt::format("{}_{}_mm", when, axis),
          axis == axes.front() ? fmt::format("{}, in {}", when, axis)
                               : fmt::format("in {}", axis),
          "mm"));
    }
  }
  table.rows_on_page = kRowsOnPage;
  for (std::size_t i = 0; i < shifts.sample.size(); ++i) {
    std::vector<Cell> row{report::whole(shifts.sample[i])};
    const auto add = [&](const geometry::Position& values, int decimals) {
      for (const double each : values) row.push_back(number(each, decimals));
    };
    add(place_of(shifts, i), 3);
    add(shifts.before_mm[i].head(axes_of(shifts)), 5);
    add(shifts.after_mm[i].head(axes_of(shifts)), 5);
    table.rows.push_back(std::move(row));
  }
  return table;
}

}  // namespace

std::optional<report::Figure> shift_figure(const DiagnosisResult& result) {
  const studies::ToolShifts& shifts = result.tool_shifts;
  const double largest_mm = std::max(longest(shifts.before_mm), longest(shifts.after_mm));
  if (!(largest_mm > 0.0)) return std::nullopt;
  report::Figure figure;
  figure.id = "tool_shift";
  const bool causes = std::ranges::any_of(result.causes, &studies::FoundCause::is_in_fit);
  const int axes = axes_of(shifts);
  add_map(
      figure, shift_map(shifts, shifts.before_mm, "robot alone", kMeasuredStyle, largest_mm));
  const double before_mm = mean_length(shifts.before_mm);
  std::string means = fmt::format("{:.4f} mm", before_mm);
  if (causes) {
    figure.title = "Where in the workspace the simulation is off, before and after";
    // Side by side in the plane; in space each is a row of views.
    const bool rows = views(axes).size() > 1;
    figure.shows = fmt::format(
        "Each arrow: the one shift of the tool that explains all readings of a sample best; {} "
        "with the robot's parameters alone, {} with the causes, on the same scale. All "
        "samples, "
        "fitted and not.",
        rows ? "above" : "on the left", rows ? "below" : "on the right");
    figure.good =
        fmt::format("{} short arrows without order.", rows ? "Below" : "On the right");
    add_map(
        figure, shift_map(shifts, shifts.after_mm, "with the causes", kAfterStyle, largest_mm));
    means += fmt::format(" before and {:.4f} mm after", mean_length(shifts.after_mm));
  } else {
    figure.title = "Where in the workspace the simulation is off";
    figure.shows =
        "Each arrow: the one shift of the tool that explains all readings of a sample best. "
        "All "
        "samples, fitted and not.";
    figure.good = "Short arrows without order.";
  }
  figure.shows += views_in_words(axes);
  figure.chart.panels_in_a_row = map_panels_in_a_row(axes, 2);
  thin(figure, kMostMarks * views(axes).size());  // as many places as in the plane
  figure.table = shift_table(shifts);
  figure.here = fmt::format(
      "Mean length over all samples {}; noise of one reading {}.", means,
      millimetres(result.noise.sigma_mm));
  return figure;
}

}  // namespace sixdial::report
