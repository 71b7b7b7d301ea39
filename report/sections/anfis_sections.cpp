// The residual model of a calibration as a section of its report: the paper's networks with
// their membership functions, any other model with what it chose.
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <map>

#include "geometry/units.h"
#include "report/sections/sections_of_studies.h"
#include "studies/method_name.h"

namespace sixdial::report {
namespace {

using calibration::AnfisCandidate;
using calibration::AnfisModel;
using calibration::AnfisReport;
using report::number;
using report::whole;

constexpr int kCurvePoints = 61;
constexpr int kStyles = 8;

/// Both networks by the coordinate that they learned.
std::array<std::pair<const char*, const AnfisReport*>, 2> axes_of(
    const studies::Networks& networks) {
  return {std::pair{"x", &networks.x}, std::pair{"y", &networks.y}};
}

report::Table network_table(const studies::Networks& networks) {
  report::Table table{.id = "anfis", .caption = "The networks and what they used"};
  table.columns = {
      column("axis", "residual of"),
      column("functions", "functions per input"),
      column("rules", "rules"),
      column("consequents", "consequents"),
      column("samples", "samples"),
      column("effective_parameters", "effective parameters"),
      column("ridge", "ridge"),
      column("best_epoch", "best epoch"),
      column("target_reached", "target reached in epoch")};
  for (const auto& [axis, network] : axes_of(networks)) {
    const AnfisModel& model = network->model;
    table.rows.push_back(
        {std::string(axis), whole(model.functions), whole(model.rules()),
         whole(model.consequents.size()), whole(network->samples),
         number(model.effective_parameters, 1), fmt::format("{:g}", model.ridge),
         whole(network->best_epoch),
         network->target_reached > 0 ? whole(network->target_reached)
                                     : report::Cell{std::string("not reached")}});
  }
  table.notes.emplace_back(
      "Effective parameters: how many numbers the network has really learned (trace of the "
      "matrix "
      "from samples to outputs). Ridge least squares keeps that below the number of samples.");
  return table;
}

/// The best ridge of each number of functions, by leave-one-out error.
std::map<int, AnfisCandidate> best_by_size(const calibration::AnfisSelection& selection) {
  std::map<int, AnfisCandidate> best;
  for (const AnfisCandidate& each : selection.candidates) {
    const auto [known, is_new] = best.emplace(each.functions, each);
    if (!is_new && each.loo_rmse < known->second.loo_rmse) known->second = each;
  }
  return best;
}

report::Table size_table(const studies::Networks& networks) {
  report::Table table{
      .id = "anfis_sizes", .caption = "Sizes offered, by leave-one-out cross-validation"};
  table.columns = {
      column("axis", "residual of"),
      column("functions", "functions per input"),
      column("ridge", "best ridge"),
      column("effective_parameters", "effective parameters"),
      column("loo_rmse_mm", "leave-one-out RMSE", "mm"),
      column("remark", "remark")};
  const auto row = [&](const char* axis, const AnfisCandidate& each, std::string remark) {
    const bool none = each.functions == 0;
    table.rows.push_back(
        {std::string(axis),
         none ? report::Cell{std::string("no network")} : whole(each.functions),
         none ? report::Cell{} : report::Cell{fmt::format("{:g}", each.ridge)},
         number(each.effective_parameters, 1), number(each.loo_rmse, 5), std::move(remark)});
  };
  for (const auto& [axis, network] : axes_of(networks)) {
    if (!network->selection) continue;
    const calibration::AnfisSelection& selection = *network->selection;
    for (const auto& [functions, each] : best_by_size(selection)) {
      row(axis, each, functions == selection.chosen.functions ? "chosen" : "");
    }
    row(axis, selection.as_printed, "the paper's setting");
  }
  table.notes.emplace_back(
      "Each sample is predicted by a network that was made without it, before its functions "
      "are "
      "trained. A network is used only if it is better than none by two standard errors.");
  return table;
}

report::Figure membership_plot(const studies::Networks& networks) {
  report::Figure figure;
  figure.id = "membership";
  figure.title = "Membership functions after training";
  figure.shows =
      "How strongly each function of the network responds to a joint angle, over the range "
      "that it "
      "was trained on. Angles beyond it count as its ends.";
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
  for (const auto& [axis, network] : axes_of(networks)) {
    const AnfisModel& model = network->model;
    if (model.functions == 0) continue;
    for (int input = 0; input < model.inputs; ++input) {
      const double low = model.box_low[input];
      const double high = model.box_high[input];
      report::Panel panel;
      panel.title = fmt::format("network of {}, theta{}", axis, input + 1);
      panel.x = {
          .label = fmt::format("theta{}", input + 1),
          .unit = "deg",
          .low = geometry::kDegPerRad * low,
          .high = geometry::kDegPerRad * high};
      panel.y = {.label = "membership", .unit = "", .low = 0.0, .high = 1.0};
      for (int k = 0; k < model.functions; ++k) {
        panel.series.push_back({.name = "", .mark = report::Mark::kLine, .style = k % kStyles});
        const bool bell = model.slope.size() > 0;
        figure.table.rows.push_back(
            {std::string(axis), fmt::format("theta{}", input + 1), whole(k + 1),
             number(
                 geometry::kDegPerRad * (model.input_mean[input] +
                                         model.input_scale[input] * model.centre(k, input)),
                 3),
             number(geometry::kDegPerRad * model.input_scale[input] * model.width(k, input), 3),
             bell ? number(model.slope(k, input), 3) : report::Cell{}});
      }
      for (int i = 0; i < kCurvePoints; ++i) {
        const double at = low + (high - low) * i / (kCurvePoints - 1);
        const Eigen::VectorXd mu = model.membership(input, at);
        least_cover = std::min(least_cover, mu.maxCoeff());
        for (int k = 0; k < model.functions; ++k) {
          report::Series& series = panel.series[static_cast<std::size_t>(k)];
          series.x.push_back(geometry::kDegPerRad * at);
          series.y.push_back(mu[k]);
        }
      }
      figure.chart.panels.push_back(std::move(panel));
    }
  }
  figure.here = fmt::format(
      "At every angle in range some function responds with at least {:.2f}.", least_cover);
  return figure;
}

}  // namespace

std::vector<report::Section> anfis_sections(const studies::Networks& networks) {
  report::Section section{
      .id = "anfis", .heading = "What the networks learned", .in_annex = true};
  const bool used = networks.x.model.functions > 0 || networks.y.model.functions > 0;
  if (used) {
    section.blocks.emplace_back(
        "One ANFIS network for x and one for y learned from the joint angles what the "
        "parameters "
        "leave over. Outside the region of the measured points their outputs stay bounded.");
    section.blocks.emplace_back(network_table(networks));
  } else {
    section.blocks.emplace_back(
        "No network is used: what the parameters leave over does not differ from noise, and a "
        "network that learns noise makes the robot worse.");
  }
  if (networks.x.selection) section.blocks.emplace_back(size_table(networks));
  if (used) section.blocks.emplace_back(membership_plot(networks));
  return {std::move(section)};
}

std::vector<report::Section> residual_model_sections(const studies::CalibrationResult& result) {
  // Results of earlier versions do not say how many samples a network rests on.
  if (result.networks && result.networks->x.samples > 0) {
    return anfis_sections(*result.networks);
  }
  if (!result.residual_model) return {};
  const studies::StoredResidualModel& model = *result.residual_model;
  report::Section section{
      .id = "residual_model", .heading = "What the residual model learned", .in_annex = true};
  section.blocks.emplace_back(fmt::format(
      "{}: it learned from the joint angles what the parameters leave over. Outside the region "
      "of "
      "the measured points its output stays bounded. It chose: {}.",
      studies::method_name(result.result_method), model.note));
  report::Table table{.id = "residual_model", .caption = "What the residual model used"};
  table.columns = {
      column("axis", "residual of"), column("effective_parameters", "effective parameters")};
  constexpr std::array<const char*, 3> kCoordinates{"x", "y", "z"};
  for (Eigen::Index i = 0; i < model.effective_parameters.size() && i < 3; ++i) {
    table.rows.push_back(
        {std::string(kCoordinates[static_cast<std::size_t>(i)]),
         number(model.effective_parameters[i], 1)});
  }
  section.blocks.emplace_back(std::move(table));
  return {std::move(section)};
}

}  // namespace sixdial::report
