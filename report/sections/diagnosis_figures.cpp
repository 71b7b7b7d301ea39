#include "report/sections/diagnosis_figures.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "report/figures.h"
#include "report/text.h"
#include "studies/diagnosis_words.h"

namespace sixdial::report {
namespace {

using report::Mark;
using report::number;
using report::Panel;
using report::Series;

constexpr int kMeasuredStyle = 0;
constexpr int kModelStyle = 2;
constexpr int kOtherMeasuredStyle = 6;
constexpr int kOtherModelStyle = 1;
constexpr int kAfterStyle = 3;
constexpr int kSmoothStyle = 4;
constexpr int kNoiseStyle = 7;
constexpr std::size_t kRowsOnPage = 24;
constexpr std::size_t kMostMarks = 1500;

std::string text_of(const Json& json) {
  return json.is_string() ? json.get<std::string>() : std::string();
}

std::vector<double> numbers_of(const Json& list) { return list.get<std::vector<double>>(); }

report::Column column(std::string key, std::string title, std::string unit = "") {
  return {
      .key = std::move(key), .title = std::move(title), .unit = std::move(unit), .group = ""};
}

double rms_between(const Json& a, const Json& b, double sum, std::size_t& count) {
  for (std::size_t i = 0; i < a.size(); ++i) {
    const double gap = a[i].get<double>() - b[i].get<double>();
    sum += gap * gap;
    ++count;
  }
  return sum;
}

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

std::string capital(std::string text) {
  if (!text.empty() && text[0] >= 'a' && text[0] <= 'z') {
    text[0] = static_cast<char>(text[0] - 'a' + 'A');
  }
  return text;
}

}  // namespace

std::optional<report::Figure> signature_figure(const Json& cause) {
  const Json& plot = cause["signature_plot"];
  if (!plot.is_object()) return std::nullopt;
  const bool swap = cause["cause"] == "dial_swap";
  const std::string quantity = text_of(plot["quantity"]);
  const std::string unit = text_of(plot["unit"]);
  const std::string covariate = text_of(plot["covariate"]);
  const std::string covariate_unit = text_of(plot["covariate_unit"]);
  report::Figure figure;
  figure.id = "signature";
  figure.title =
      capital(fmt::format("{}: {} against {}", studies::named(cause), quantity, covariate));
  figure.shows =
      swap ? "Each reading as it was handed over, and as it is with the two dials exchanged, "
             "against what the simulation says of that dial."
           : fmt::format(
                 "Points: {} if the model leaves this cause out, all else as fitted. {}: the "
                 "cause as fitted.",
                 quantity == "residual"
                     ? std::string("what is left of each reading, measured minus simulated,")
                     : fmt::format("what each sample's readings say of the {}", quantity),
                 plot["is_function"].get<bool>() ? "Line" : "Triangles");
  figure.good = swap ? "Only the exchanged readings lie on the diagonal."
                     : "The points follow the fitted cause over the whole range and scatter "
                       "about it evenly.";
  figure.table = {.id = "signature", .caption = "What each sample says of this cause"};
  figure.table.columns = {
      column("panel", "panel"), column("group", "group"),
      column("covariate", covariate, covariate_unit),
      column("measured", swap ? "as handed over" : "points", unit),
      column("model", swap ? "exchanged" : "fitted cause", unit)};
  figure.table.rows_on_page = kRowsOnPage;
  double squares = 0.0;
  double size = 0.0;
  std::size_t count = 0;
  for (const Json& each : plot["panels"]) {
    Panel panel;
    panel.title = text_of(each["title"]);
    panel.x = {.label = covariate, .unit = covariate_unit};
    panel.y = {.label = quantity, .unit = unit};
    bool other = false;
    const bool groups = each["groups"].size() > 1;
    for (const Json& group : each["groups"]) {
      const std::string name = text_of(group["name"]);
      Series points{
          .name = swap     ? "as handed over"
                  : groups ? name
                           : "measured",
          .mark = Mark::kDots,
          .style = other ? kOtherMeasuredStyle : kMeasuredStyle};
      points.x = numbers_of(group["x"]);
      points.y = numbers_of(group["measured"]);
      Series model{
          .name = swap     ? "exchanged"
                  : groups ? name + ", fitted"
                           : "fitted cause",
          .mark = plot["is_function"].get<bool>() ? Mark::kLine : Mark::kDots,
          .style = other ? kOtherModelStyle : kModelStyle};
      model.x = points.x;
      model.y = numbers_of(group["model"]);
      squares = rms_between(group["measured"], group["model"], squares, count);
      for (std::size_t i = 0; i < points.x.size(); ++i) {
        size = std::max(size, std::abs(model.y[i]));
        figure.table.rows.push_back(
            {panel.title, name, number(points.x[i], 4), number(points.y[i], 5),
             number(model.y[i], 5)});
      }
      panel.series.push_back(std::move(points));
      panel.series.push_back(std::move(model));
      other = true;
    }
    figure.chart.panels.push_back(std::move(panel));
  }
  const std::size_t panels = figure.chart.panels.size();
  figure.chart.panels_in_a_row = panels >= 3 ? 3 : static_cast<int>(panels);
  constexpr int kTall = 300;
  constexpr int kLow = 210;
  figure.chart.panel_height = panels > 2 ? kLow : kTall;
  const double scatter =
      std::sqrt(squares / static_cast<double>(std::max<std::size_t>(1, count)));
  const std::string how_large = studies::size_in_words(cause);
  figure.here =
      swap ? fmt::format(
                 "{} readings; as handed over they are {:.2f} mm off (rms).", count, scatter)
           : fmt::format(
                 "{}. The fitted cause reaches {:.3g} {}; {} points scatter about it by {:.2g} "
                 "{} (rms).",
                 how_large.empty() ? capital(studies::named(cause)) : capital(how_large), size,
                 unit, count, scatter, unit);
  return figure;
}

std::optional<report::Figure> left_figure(const Json& document) {
  report::Figure figure;
  figure.id = "left_by_covariate";
  figure.title = "What is left by joint angle, position, time, temperature and reading";
  figure.shows =
      "Root mean square of measured minus simulated readings, in ten classes of equally many "
      "readings along each quantity: with the robot alone, and with the named causes.";
  figure.good = "The second line is flat and lies on the noise everywhere.";
  figure.table = {.id = "left_by_covariate", .caption = "What is left by class (rms)"};
  figure.table.columns = {
      column("covariate", "along"),
      column("unit", "unit"),
      column("class", "class"),
      column("readings", "readings"),
      column("before_mm", "robot alone", "mm"),
      column("after_mm", "with the causes", "mm")};
  figure.table.rows_on_page = kRowsOnPage;
  const Json& noise = document["noise"]["sigma_mm"];
  const bool causes = !document["extended_model"]["effects"].empty();
  const bool unknown = !document["unexplained"]["depends_on"].empty();
  if (unknown) {
    figure.shows = fmt::format(
        "Root mean square of measured minus simulated readings, in ten classes of equally many "
        "readings along each quantity: with the robot alone{}, and less the smooth part that "
        "nobody named.",
        causes ? ", with the named causes" : "");
    figure.good = "The last line is flat and lies on the noise everywhere.";
  } else if (!causes) {
    figure.shows =
        "Root mean square of measured minus simulated readings, in ten classes of equally many "
        "readings along each quantity.";
    figure.good = "The line is flat and lies on the noise everywhere.";
  }
  double worst = 0.0;
  std::string worst_at;
  for (const Json& each : document["by_covariate"]) {
    if (each["kind"] != "number") continue;
    Panel panel;
    const std::string name = text_of(each["covariate"]);
    panel.title = name;
    panel.x = {.label = name, .unit = text_of(each["unit"])};
    panel.y = {.label = "left, rms", .unit = "mm", .low = 0.0};
    Series before{.name = "robot alone", .mark = Mark::kLineAndDots, .style = kMeasuredStyle};
    Series after{.name = "with the causes", .mark = Mark::kLineAndDots, .style = kAfterStyle};
    Series smooth{
        .name = "less the smooth unknown", .mark = Mark::kLineAndDots, .style = kSmoothStyle};
    for (std::size_t i = 0; i < each["at"].size(); ++i) {
      const double at = each["at"][i].get<double>();
      if (each["before_mm"][i].is_number()) {
        before.x.push_back(at);
        before.y.push_back(each["before_mm"][i].get<double>());
      }
      if (each["after_mm"][i].is_number()) {
        after.x.push_back(at);
        after.y.push_back(each["after_mm"][i].get<double>());
        if (after.y.back() > worst) {
          worst = after.y.back();
          worst_at =
              fmt::format("{} {} {}", name, text_of(each["label"][i]), text_of(each["unit"]));
        }
      }
      if (each.contains("smooth_mm") && each["smooth_mm"][i].is_number()) {
        smooth.x.push_back(at);
        smooth.y.push_back(each["smooth_mm"][i].get<double>());
      }
      const auto cell = [&](const char* key) {
        return each[key][i].is_number() ? number(each[key][i].get<double>(), 5)
                                        : report::Cell{};
      };
      figure.table.rows.push_back(
          {name, text_of(each["unit"]), text_of(each["label"][i]),
           report::whole(each["readings"][i].get<int>()), cell("before_mm"), cell("after_mm")});
    }
    panel.series.push_back(std::move(before));
    if (causes) panel.series.push_back(std::move(after));
    if (!smooth.x.empty()) panel.series.push_back(std::move(smooth));
    if (noise.is_number()) {
      Series rule{.name = "noise", .mark = Mark::kRuleAcross, .style = kNoiseStyle};
      rule.y = {noise.get<double>()};
      panel.series.push_back(std::move(rule));
    }
    figure.chart.panels.push_back(std::move(panel));
  }
  if (figure.chart.panels.empty()) return std::nullopt;
  figure.chart.panels_in_a_row = 3;
  constexpr int kLow = 210;
  figure.chart.panel_height = kLow;
  figure.here = fmt::format(
      "{}t most {:.4f} mm ({}); noise {}.", causes ? "After the causes a" : "A", worst,
      worst_at, studies::millimetres(noise));
  return figure;
}

std::optional<report::Figure> shift_figure(const Json& document) {
  const Json& shifts = document["tool_shift"];
  if (shifts["sample"].empty()) return std::nullopt;
  const std::vector<double> x = numbers_of(shifts["x_mm"]);
  const std::vector<double> y = numbers_of(shifts["y_mm"]);
  report::Figure figure;
  figure.id = "tool_shift";
  figure.title = "Where in the workspace the simulation is off, before and after";
  figure.shows =
      "Each arrow: the shift of the tool that explains the residuals of one sample best; on "
      "the "
      "left with the robot alone, on the right with the named causes, drawn to the same scale.";
  figure.good = "On the right short arrows without order.";
  figure.table = {.id = "tool_shift", .caption = "Shift of the tool by sample"};
  figure.table.columns = {
      column("sample", "sample"),          column("x_mm", "x", "mm"),
      column("y_mm", "y", "mm"),           column("before_x_mm", "before, in x", "mm"),
      column("before_y_mm", "in y", "mm"), column("after_x_mm", "after, in x", "mm"),
      column("after_y_mm", "in y", "mm")};
  figure.table.rows_on_page = kRowsOnPage;
  const bool causes = !document["extended_model"]["effects"].empty();
  if (!causes) {
    figure.title = "Where in the workspace the simulation is off";
    figure.shows =
        "Each arrow: the shift of the tool that explains the residuals of one sample best.";
    figure.good = "Short arrows without order.";
  }
  double largest = 0.0;
  std::vector<double> means;
  std::vector<Panel> panels;
  for (const auto& [key, title] :
       {std::pair{"before_mm", "robot alone"}, std::pair{"after_mm", "with the causes"}}) {
    Panel panel;
    panel.title = title;
    panel.x = {.label = "x", .unit = "mm"};
    panel.y = {.label = "y", .unit = "mm"};
    panel.equal_scales = true;
    Series arrows{
        .mark = Mark::kArrows,
        .style = std::string_view(key) == "before_mm" ? kMeasuredStyle : kAfterStyle};
    arrows.x = x;
    arrows.y = y;
    double sum = 0.0;
    for (const Json& each : shifts[key]) {
      const double dx = each[0].get<double>();
      const double dy = each[1].get<double>();
      arrows.dx.push_back(dx);
      arrows.dy.push_back(dy);
      largest = std::max(largest, std::hypot(dx, dy));
      sum += std::hypot(dx, dy);
    }
    means.push_back(sum / static_cast<double>(x.size()));
    panel.series.push_back(std::move(arrows));
    panels.push_back(std::move(panel));
  }
  if (!(largest > 0.0)) return std::nullopt;
  constexpr double kLongest_mm = 6.0;  // on the table of the chart
  if (!causes) panels.pop_back();
  for (Panel& panel : panels) {
    panel.arrow_scale = report::round_down(kLongest_mm / largest);
    panel.arrow_key = report::round_down(largest);
    figure.chart.panels.push_back(std::move(panel));
  }
  figure.chart.panels_in_a_row = 2;
  thin(figure, kMostMarks);
  for (std::size_t i = 0; i < x.size(); ++i) {
    const Json& b = shifts["before_mm"][i];
    const Json& a = shifts["after_mm"][i];
    figure.table.rows.push_back(
        {report::whole(shifts["sample"][i].get<int>()), number(x[i], 3), number(y[i], 3),
         number(b[0].get<double>(), 5), number(b[1].get<double>(), 5),
         number(a[0].get<double>(), 5), number(a[1].get<double>(), 5)});
  }
  figure.here = fmt::format(
      "Mean length {:.4f} mm{}; noise of one reading {}.", means[0],
      causes ? fmt::format(" before and {:.4f} mm after", means[1]) : std::string(),
      studies::millimetres(document["noise"]["sigma_mm"]));
  return figure;
}

}  // namespace sixdial::report
