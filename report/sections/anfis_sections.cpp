// The networks of a calibration as a section of its report.
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <numbers>

#include "report/sections/sections_of_studies.h"
#include "studies/network_json.h"

namespace sixdial::report {
namespace {

using calibration::AnfisModel;
using report::Column;
using report::number;
using report::whole;

constexpr double kDeg = 180.0 / std::numbers::pi;
constexpr int kCurvePoints = 61;
constexpr int kStyles = 8;
constexpr std::array kAxes{"x", "y"};

Column column(std::string key, std::string title, std::string unit = "") {
  return {
      .key = std::move(key), .title = std::move(title), .unit = std::move(unit), .group = ""};
}

report::Table network_table(const Json& anfis) {
  report::Table table{.id = "anfis", .caption = "The networks and what they used"};
  table.columns = {
      column("axis", "residual of"), column("functions", "functions per input"),
      column("rules", "rules"),      column("consequents", "consequents"),
      column("samples", "samples"),  column("effective_parameters", "effective parameters"),
      column("ridge", "ridge"),      column("best_epoch", "best epoch")};
  for (const char* axis : kAxes) {
    const Json& network = anfis.at(axis);
    table.rows.push_back(
        {std::string(axis), whole(network["functions"].get<int>()),
         whole(network["rules"].get<int>()), whole(network["consequents_count"].get<int>()),
         whole(network["samples"].get<int>()),
         number(network["effective_parameters"].get<double>(), 1),
         fmt::format("{:g}", network["ridge"].get<double>()),
         whole(network["best_epoch"].get<int>())});
  }
  table.notes.emplace_back(
      "Effective parameters: trace of the matrix that maps the samples to the network's "
      "outputs. Ridge least squares keeps it below the number of samples however many "
      "consequents there are.");
  return table;
}

/// The best ridge of each number of functions, by leave-one-out error.
std::map<int, Json> best_by_size(const Json& selection) {
  std::map<int, Json> best;
  for (const Json& each : selection["candidates"]) {
    const int functions = each["functions"].get<int>();
    const auto known = best.find(functions);
    if (known == best.end() ||
        each["loo_rmse_mm"].get<double>() < known->second["loo_rmse_mm"].get<double>()) {
      best[functions] = each;
    }
  }
  return best;
}

report::Table size_table(const Json& anfis) {
  report::Table table{
      .id = "anfis_sizes", .caption = "Sizes offered, by leave-one-out cross-validation"};
  table.columns = {
      column("axis", "residual of"),
      column("functions", "functions per input"),
      column("ridge", "best ridge"),
      column("effective_parameters", "effective parameters"),
      column("loo_rmse_mm", "leave-one-out RMSE", "mm"),
      column("remark", "remark")};
  const auto row = [&](const char* axis, const Json& each, std::string remark) {
    const int functions = each["functions"].get<int>();
    table.rows.push_back(
        {std::string(axis),
         functions == 0 ? report::Cell{std::string("no network")} : whole(functions),
         functions == 0 ? report::Cell{}
                        : report::Cell{fmt::format("{:g}", each["ridge"].get<double>())},
         number(each["effective_parameters"].get<double>(), 1),
         number(each["loo_rmse_mm"].get<double>(), 5), std::move(remark)});
  };
  for (const char* axis : kAxes) {
    const Json& selection = anfis.at(axis)["selection"];
    for (const auto& [functions, each] : best_by_size(selection)) {
      row(axis, each, functions == selection["functions"].get<int>() ? "chosen" : "");
    }
    row(axis, selection["as_printed"], "the paper's setting");
  }
  table.notes.emplace_back(
      "Each sample is predicted by the network that did not see it, premises as they start. "
      "A network is chosen only where it beats having none by two standard errors.");
  return table;
}

report::Figure membership_plot(const Json& anfis) {
  report::Figure figure;
  figure.id = "membership";
  figure.title = "Membership functions after training";
  figure.shows =
      "How strongly each function of an input answers, over the trained range of the joint "
      "angle. Beyond that range inputs are clamped to its ends.";
  figure.good =
      "Functions that overlap and cover the whole range; a spike between two samples, or a "
      "range that none covers, is a network that fitted noise.";
  figure.chart.panels_in_a_row = 2;
  figure.chart.panel_height = 200;
  figure.table = {.id = "membership", .caption = "Premises"};
  figure.table.columns = {
      column("axis", "residual of"),       column("input", "input"),
      column("function", "function"),      column("centre_deg", "centre", "deg"),
      column("width_deg", "width", "deg"), column("slope", "slope")};
  double least_cover = 1.0;
  for (const char* axis : kAxes) {
    const AnfisModel model = studies::network_from(anfis.at(axis));
    if (model.functions == 0) continue;
    for (int input = 0; input < model.inputs; ++input) {
      const double low = model.box_low[input];
      const double high = model.box_high[input];
      report::Panel panel;
      panel.title = fmt::format("network of {}, theta{}", axis, input + 1);
      panel.x = {
          .label = fmt::format("theta{}", input + 1),
          .unit = "deg",
          .low = kDeg * low,
          .high = kDeg * high};
      panel.y = {.label = "membership", .unit = "", .low = 0.0, .high = 1.0};
      for (int k = 0; k < model.functions; ++k) {
        panel.series.push_back({.name = "", .mark = report::Mark::kLine, .style = k % kStyles});
        const bool bell = model.slope.size() > 0;
        figure.table.rows.push_back(
            {std::string(axis), fmt::format("theta{}", input + 1), whole(k + 1),
             number(
                 kDeg * (model.input_mean[input] +
                         model.input_scale[input] * model.centre(k, input)),
                 3),
             number(kDeg * model.input_scale[input] * model.width(k, input), 3),
             bell ? number(model.slope(k, input), 3) : report::Cell{}});
      }
      for (int i = 0; i < kCurvePoints; ++i) {
        const double at = low + (high - low) * i / (kCurvePoints - 1);
        const Eigen::VectorXd mu = model.membership(input, at);
        least_cover = std::min(least_cover, mu.maxCoeff());
        for (int k = 0; k < model.functions; ++k) {
          report::Series& series = panel.series[static_cast<std::size_t>(k)];
          series.x.push_back(kDeg * at);
          series.y.push_back(mu[k]);
        }
      }
      figure.chart.panels.push_back(std::move(panel));
    }
  }
  figure.here = fmt::format(
      "Everywhere in range some function answers with at least {:.2f}.", least_cover);
  return figure;
}

}  // namespace

std::vector<report::Section> anfis_sections(const Json& anfis) {
  report::Section section{.id = "anfis", .heading = "What the networks learned"};
  const auto functions = [&](const char* axis) {
    return anfis.at(axis)["functions"].get<int>();
  };
  if (functions("x") == 0 && functions("y") == 0) {
    section.blocks.emplace_back(
        "No network is used: what the parameters leave over cannot be told from noise, and a "
        "network that learns noise makes the robot worse.");
  } else {
    section.blocks.emplace_back(
        "One ANFIS network for x and one for y learned from the joint angles what the "
        "parameters leave over. Their outputs are bounded outside the trained region.");
    section.blocks.emplace_back(network_table(anfis));
  }
  if (anfis.at("x")["selection"].is_object()) section.blocks.emplace_back(size_table(anfis));
  if (functions("x") > 0 || functions("y") > 0) {
    section.blocks.emplace_back(membership_plot(anfis));
  }
  return {std::move(section)};
}

}  // namespace sixdial::report
