#include "report/sections/against_sections.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <optional>

#include "geometry/coverage.h"
#include "geometry/tool.h"
#include "geometry/units.h"
#include "report/expanded.h"
#include "report/tables.h"
#include "report/text.h"
#include "session/trials.h"
#include "studies/compensate.h"

namespace sixdial::report {
namespace {

constexpr double kChanged = geometry::kCoverage;  // standard deviations of a difference

using report::number;

/// Time of the first sample; empty where none has one.
std::string measured_at(const session::Session& session) {
  std::optional<session::TimePoint> first;
  for (const session::Sample& sample : session.samples) {
    if (sample.time_utc && (!first || *sample.time_utc < *first)) first = sample.time_utc;
  }
  return first ? session::to_iso8601(*first) : "";
}

std::string name_and_time(const session::Session& session) {
  const std::string time = measured_at(session);
  return time.empty() ? session.name
                      : fmt::format("{}, {}", session.name, report::readable_time(time));
}

std::optional<double> sd_of(const studies::ParameterRow& parameter) {
  if (parameter.fixed || !std::isfinite(parameter.sd)) return std::nullopt;
  return parameter.sd;
}

struct Shift {
  double mean_mm = 0.0, max_mm = 0.0;
  int poses = 0;
};

/// The tool by the one against the other parameters, at the joint angles of this session.
Shift shift_of(const Calibrated& here, const Calibrated& other) {
  const geometry::Tool tool(here.session.rig);
  const Eigen::VectorXd v = here.result.identified();
  const Eigen::VectorXd w = other.result.identified();
  Shift shift;
  for (const session::Sample& sample : here.session.samples) {
    const auto assembly = session::assembly_of(here.session.rig, sample);
    const auto a = tool.position(v, sample.q, assembly);
    const auto b = tool.position(w, sample.q, assembly);
    if (!a || !b) continue;
    const double apart_mm = (*a - *b).norm();
    shift.mean_mm += apart_mm;
    shift.max_mm = std::max(shift.max_mm, apart_mm);
    ++shift.poses;
  }
  if (shift.poses > 0) shift.mean_mm /= shift.poses;
  return shift;
}

report::Table error_table(const Calibrated& earlier, const Calibrated& later) {
  report::Table t{.id = "against_errors", .caption = "Position error of both sessions"};
  t.columns = {column("state", "")};
  for (const char* set : {"g1", "g2"}) {
    const std::string group = set == std::string("g1") ? "G1 calibration" : "G2 validation";
    t.columns.push_back(column(fmt::format("{}_mean_mm", set), "mean", "mm", group));
    t.columns.push_back(column(fmt::format("{}_max_mm", set), "max", "mm", group));
    t.columns.push_back(column(fmt::format("{}_points", set), "points", "", group));
  }
  const auto row = [&](const Calibrated& each, const std::string& id, std::string words) {
    std::vector<report::Cell> cells{std::move(words)};
    const studies::MethodRow* method = each.result.method(id);
    for (const auto set : {&studies::MethodRow::g1, &studies::MethodRow::g2}) {
      const bool known = method != nullptr && (method->*set).has_value();
      cells.push_back(known ? number((method->*set)->mean_mm) : report::Cell{});
      cells.push_back(known ? number((method->*set)->max_mm) : report::Cell{});
      cells.push_back(known ? report::whole((method->*set)->points) : report::Cell{});
    }
    t.rows.push_back(std::move(cells));
  };
  row(earlier, "before", fmt::format("as found: {}, before", earlier.session.name));
  row(earlier, earlier.result.result_method,
      fmt::format("as found: {}, calibrated", earlier.session.name));
  row(later, "before", fmt::format("as left: {}, before", later.session.name));
  row(later, later.result.result_method,
      fmt::format("as left: {}, calibrated", later.session.name));
  t.notes.emplace_back(
      "\"Before\" is with the nominal parameters of each session's rig file. If the identified "
      "ones were entered there, as left begins where as found ended.");
  return t;
}

report::Table parameter_table(
    const Calibrated& earlier, const Calibrated& later, int& changed, int& judged) {
  report::Table t{
      .id = "against_parameters", .caption = "Identified parameters of both sessions"};
  t.columns = {
      column("parameter", "parameter"),
      column("unit", "unit"),
      column("as_found", "value", "", "as found"),
      expanded_column("as_found_sd", "", "as found"),
      column("as_left", "value", "", "as left"),
      expanded_column("as_left_sd", "", "as left"),
      column("change", "change"),
      expanded_column("change_sd"),
      column("times", "change / U"),
      column("verdict", "")};
  for (const studies::ParameterRow& a : earlier.result.parameters) {
    const auto found =
        std::ranges::find(later.result.parameters, a.name, &studies::ParameterRow::name);
    if (found == later.result.parameters.end()) continue;
    const studies::ParameterRow& b = *found;
    const geometry::ShownUnit unit = geometry::shown_unit(a.unit);
    const double shown = unit.per_unit;
    const double change = b.identified - a.identified;
    const auto sd_a = sd_of(a);
    const auto sd_b = sd_of(b);
    std::optional<double> sd, times;
    std::string verdict = "not judged: held or without uncertainty";
    if (sd_a && sd_b && std::hypot(*sd_a, *sd_b) > 0.0) {
      sd = std::hypot(*sd_a, *sd_b);
      times = std::abs(change) / *sd;
      verdict = *times > kChanged ? "changed" : "the same";
      ++judged;
      if (*times > kChanged) ++changed;
    }
    const int decimals =
        report::decimals_for(geometry::kCoverage * shown * sd.value_or(0.5e-4));
    const auto scaled = [&](const std::optional<double>& value) {
      return number(value ? std::optional(shown * *value) : std::nullopt, decimals);
    };
    const auto uncertain = [&](const std::optional<double>& sd_of_it) {
      return expanded(sd_of_it ? std::optional(shown * *sd_of_it) : std::nullopt, decimals);
    };
    t.rows.push_back(
        {report::symbol(a.name), std::string(unit.name), scaled(a.identified), uncertain(sd_a),
         scaled(b.identified), uncertain(sd_b), scaled(change), uncertain(sd),
         times ? report::Number{*times, 1, 1.0 / geometry::kCoverage} : report::Cell{},
         std::move(verdict)});
  }
  t.notes.emplace_back(
      "Change is as left minus as found: +0.010 mm is a link that is 0.010 mm longer now. It "
      "is "
      "called changed where it is larger than its expanded uncertainty U (about 95 %); of ten "
      "parameters that did not change one does so by chance in every second comparison.");
  return t;
}

}  // namespace

std::vector<report::Section> against_sections(const Calibrated& here, const Calibrated& other) {
  const bool here_is_later = measured_at(here.session) >= measured_at(other.session);
  const Calibrated& earlier = here_is_later ? other : here;
  const Calibrated& later = here_is_later ? here : other;
  int changed = 0;
  int judged = 0;
  report::Table parameters = parameter_table(earlier, later, changed, judged);
  const Shift shift = shift_of(here, other);

  report::Section out{.id = "against", .heading = "As found and as left"};
  out.blocks.emplace_back(fmt::format(
      "As found: {}. As left: {}. At the joint values of this session ({}) the two sets of "
      "parameters put the tool {} apart on average and {} at most. {} of {} parameters changed "
      "by "
      "more than the expanded uncertainty of the change (k = 2).",
      name_and_time(earlier.session), name_and_time(later.session),
      report::counted(shift.poses, "pose", "poses"), report::length(shift.mean_mm),
      report::length(shift.max_mm), changed, judged));
  if (earlier.result.inputs.rig_hash != later.result.inputs.rig_hash) {
    out.blocks.emplace_back(
        "The two rig files differ. A dial that was moved on the table looks like a robot that "
        "moved: see x0, y0 and alpha.");
  }
  out.blocks.emplace_back(error_table(earlier, later));
  out.blocks.emplace_back(std::move(parameters));
  return {std::move(out)};
}

}  // namespace sixdial::report
