#include "report/sections/diagnosis_figures.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "report/text.h"
#include "report/words/diagnosis_axes.h"
#include "report/words/diagnosis_words.h"
#include "simulation/effect_words.h"

namespace sixdial::report {
namespace {

using report::Mark;
using report::number;
using report::Panel;
using report::Series;
using studies::DiagnosisResult;
using studies::FoundCause;
using studies::SignatureCurve;

constexpr int kModelStyle = 2;
constexpr int kOtherMeasuredStyle = 6;
constexpr int kOtherModelStyle = 1;
constexpr int kSmoothStyle = 4;
constexpr int kNoiseStyle = 7;

/// Scatter of points about the fitted cause, and how large that is.
struct Spread {
  double squares = 0.0;
  double largest_model = 0.0;
  std::size_t count = 0;
  void add(const studies::CurveGroup& group) {
    for (std::size_t i = 0; i < group.x.size(); ++i) {
      const double gap = group.measured[i] - group.model[i];
      squares += gap * gap;
      largest_model = std::max(largest_model, std::abs(group.model[i]));
      ++count;
    }
  }
  [[nodiscard]] double rms() const {
    return std::sqrt(squares / static_cast<double>(std::max<std::size_t>(1, count)));
  }
};

/// What the axes of a signature are called, and its series.
struct SignatureWords {
  bool as_it_came = false;  // readings of exchanged dials, not a fitted cause
  std::string quantity{}, unit{}, covariate{}, covariate_unit{};
};

SignatureWords words_of(const SignatureCurve& curve) {
  return {
      .as_it_came = curve.quantity == studies::Quantity::kReading,
      .quantity = quantity_name(curve),
      .unit = std::string(quantity_unit(curve.quantity)),
      .covariate = axis_in_words(curve.along),
      .covariate_unit = std::string(axis_unit(curve.along))};
}

Panel signature_panel(
    const SignatureCurve& curve, const studies::CurvePanel& each, const SignatureWords& said) {
  Panel panel;
  panel.title = panel_name(each);
  panel.x = {.label = said.covariate, .unit = said.covariate_unit};
  panel.y = {.label = said.quantity, .unit = said.unit};
  const bool groups = each.groups.size() > 1;
  bool other = false;
  for (const studies::CurveGroup& group : each.groups) {
    const std::string name(group_name(group.of));
    Series points{
        .name = said.as_it_came ? "as handed over"
                : groups        ? name
                                : "measured",
        .mark = Mark::kDots,
        .style = other ? kOtherMeasuredStyle : kMeasuredStyle};
    points.x = group.x;
    points.y = group.measured;
    Series model{
        .name = said.as_it_came ? "exchanged"
                : groups        ? name + ", fitted"
                                : "fitted cause",
        .mark = curve.is_function ? Mark::kLine : Mark::kDots,
        .style = other ? kOtherModelStyle : kModelStyle};
    model.x = group.x;
    model.y = group.model;
    panel.series.push_back(std::move(points));
    panel.series.push_back(std::move(model));
    other = true;
  }
  return panel;
}

report::Table signature_table(const SignatureCurve& curve, const SignatureWords& said) {
  report::Table table{.id = "signature", .caption = "What each sample says of this cause"};
  table.columns = {
      column("panel", "panel"), column("group", "group"),
      column("covariate", said.covariate, said.covariate_unit),
      column("measured", said.as_it_came ? "as handed over" : "points", said.unit),
      column("model", said.as_it_came ? "exchanged" : "fitted cause", said.unit)};
  table.rows_on_page = kRowsOnPage;
  for (const studies::CurvePanel& panel : curve.panels) {
    for (const studies::CurveGroup& group : panel.groups) {
      for (std::size_t i = 0; i < group.x.size(); ++i) {
        table.rows.push_back(
            {panel_name(panel), std::string(group_name(group.of)), number(group.x[i], 4),
             number(group.measured[i], 5), number(group.model[i], 5)});
      }
    }
  }
  return table;
}

/// What the points of a signature are.
std::string points_in_words(const SignatureCurve& curve) {
  return curve.quantity == studies::Quantity::kResidual
             ? std::string("what is left of each reading, measured minus simulated,")
             : fmt::format("what each sample's readings say of the {}", quantity_name(curve));
}

/// One line of the figure along a number: robot alone, with the causes, less the smooth part.
struct LeftSeries {
  Series before{.name = "robot alone", .mark = Mark::kLineAndDots, .style = kMeasuredStyle};
  Series after{.name = "with the causes", .mark = Mark::kLineAndDots, .style = kAfterStyle};
  Series smooth{
      .name = "less the smooth unknown", .mark = Mark::kLineAndDots, .style = kSmoothStyle};
  static void add(Series& to, double at, double left_mm) {
    if (!std::isfinite(left_mm)) return;
    to.x.push_back(at);
    to.y.push_back(left_mm);
  }
  void add(const studies::LeftInClass& each, bool has_smooth) {
    add(before, each.at, each.before_mm);
    add(after, each.at, each.after_mm);
    if (has_smooth) add(smooth, each.at, each.smooth_mm);
  }
};

Panel left_panel(const studies::LeftAlong& along, bool causes, double noise_mm) {
  Panel panel;
  panel.title = axis_in_words(along.along);
  panel.x = {.label = panel.title, .unit = std::string(axis_unit(along.along))};
  panel.y = {.label = "left, rms", .unit = "mm", .low = 0.0};
  LeftSeries series;
  for (const studies::LeftInClass& each : along.classes) series.add(each, along.has_smooth);
  panel.series.push_back(std::move(series.before));
  if (causes) panel.series.push_back(std::move(series.after));
  if (!series.smooth.x.empty()) panel.series.push_back(std::move(series.smooth));
  if (std::isfinite(noise_mm)) {
    Series rule{.name = "noise", .mark = Mark::kRuleAcross, .style = kNoiseStyle};
    rule.y = {noise_mm};
    panel.series.push_back(std::move(rule));
  }
  return panel;
}

report::Table left_table(const DiagnosisResult& result) {
  report::Table table{.id = "left_by_covariate", .caption = "What is left by class (rms)"};
  table.columns = {
      column("covariate", "along"),
      column("unit", "unit"),
      column("class", "class"),
      column("readings", "readings"),
      column("before_mm", "robot alone", "mm"),
      column("after_mm", "with the causes", "mm")};
  table.rows_on_page = kRowsOnPage;
  const auto cell = [](double value) {
    return std::isfinite(value) ? number(value, 5) : report::Cell{};
  };
  for (const studies::LeftAlong& along : result.left_along) {
    if (!is_number(along.along.axis)) continue;
    for (const studies::LeftInClass& each : along.classes) {
      table.rows.push_back(
          {axis_in_words(along.along), std::string(axis_unit(along.along)),
           class_name(along.along.axis, each), report::whole(each.readings),
           cell(each.before_mm), cell(each.after_mm)});
    }
  }
  return table;
}

/// The class that keeps most, with the causes: "0.0031 mm (angle of joint 2 -12 to 4 deg)".
std::string worst_in_words(const DiagnosisResult& result) {
  double worst_mm = 0.0;
  std::string where;
  for (const studies::LeftAlong& along : result.left_along) {
    if (!is_number(along.along.axis)) continue;
    for (const studies::LeftInClass& each : along.classes) {
      if (!(each.after_mm > worst_mm)) continue;
      worst_mm = each.after_mm;
      where = fmt::format(
          "{} {} {}", axis_in_words(along.along), class_name(along.along.axis, each),
          axis_unit(along.along));
    }
  }
  return fmt::format("{:.4f} mm ({})", worst_mm, where);
}

/// What the figure of what is left shows, and what it should look like.
void say_left(report::Figure& figure, bool causes, bool unknown) {
  constexpr std::string_view kShows =
      "Root mean square of measured minus simulated readings, in ten classes of equally many "
      "readings along each quantity";
  if (unknown) {
    figure.shows = fmt::format(
        "{}: with the robot alone{}, and less the smooth part that has no name.", kShows,
        causes ? ", with the named causes" : "");
    figure.good = "The last line is flat and lies on the noise everywhere.";
  } else if (causes) {
    figure.shows = fmt::format("{}: with the robot alone, and with the named causes.", kShows);
    figure.good = "The second line is flat and lies on the noise everywhere.";
  } else {
    figure.shows = fmt::format("{}.", kShows);
    figure.good = "The line is flat and lies on the noise everywhere.";
  }
}

}  // namespace

std::optional<report::Figure> signature_figure(const FoundCause& cause) {
  if (!cause.signature) return std::nullopt;
  const SignatureCurve& curve = *cause.signature;
  const SignatureWords said = words_of(curve);
  report::Figure figure;
  figure.id = "signature";
  figure.title =
      capital(fmt::format("{}: {} against {}", named(cause), said.quantity, said.covariate));
  figure.table = signature_table(curve, said);
  Spread spread;
  for (const studies::CurvePanel& each : curve.panels) {
    figure.chart.panels.push_back(signature_panel(curve, each, said));
    for (const studies::CurveGroup& group : each.groups) spread.add(group);
  }
  const std::size_t panels = figure.chart.panels.size();
  figure.chart.panels_in_a_row = panels >= 3 ? 3 : static_cast<int>(panels);
  constexpr int kTall = 300;
  constexpr int kLow = 210;
  figure.chart.panel_height = panels > 2 ? kLow : kTall;
  if (said.as_it_came) {
    figure.shows =
        "Each reading as it was handed over, and as it is with the two dials exchanged, "
        "against what the simulation says of that dial.";
    figure.good = "Only the exchanged readings lie on the diagonal.";
    figure.here = fmt::format(
        "{} readings; as handed over they are {:.2f} mm off (rms).", spread.count,
        spread.rms());
    return figure;
  }
  figure.shows = fmt::format(
      "Points: {} if the model leaves this cause out, all else as fitted. {}: the cause as "
      "fitted.",
      points_in_words(curve), curve.is_function ? "Line" : "Triangles");
  figure.good =
      "The points follow the fitted cause over the whole range and scatter about it evenly.";
  const std::string how_large = size_in_words(cause);
  figure.here = fmt::format(
      "{}. The fitted cause reaches {} {}; {} points scatter about it by {} {} (rms).",
      capital(how_large.empty() ? named(cause) : how_large),
      simulation::in_digits(spread.largest_model, 3), said.unit, spread.count,
      simulation::in_digits(spread.rms(), 2), said.unit);
  return figure;
}

std::optional<report::Figure> left_figure(const DiagnosisResult& result) {
  report::Figure figure;
  figure.id = "left_by_covariate";
  figure.title = "What is left by joint value, position, time, temperature and reading";
  const double noise_mm = result.noise.sigma_mm;
  const bool causes = std::ranges::any_of(result.causes, &studies::FoundCause::is_in_fit);
  say_left(figure, causes, !result.unexplained.depends_on.empty());
  figure.table = left_table(result);
  for (const studies::LeftAlong& each : result.left_along) {
    if (!is_number(each.along.axis)) continue;
    figure.chart.panels.push_back(left_panel(each, causes, noise_mm));
  }
  if (figure.chart.panels.empty()) return std::nullopt;
  figure.chart.panels_in_a_row = 3;
  constexpr int kLow = 210;
  figure.chart.panel_height = kLow;
  figure.here = fmt::format(
      "{}t most {}; noise {}.", causes ? "With the causes a" : "A", worst_in_words(result),
      millimetres(noise_mm));
  return figure;
}

}  // namespace sixdial::report
