// A diagnosis as sections of a report, and as a page of its own. Figures:
// diagnosis_figures.cpp.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <iterator>
#include <limits>
#include <numbers>

#include "report/html_report.h"
#include "report/report_run.h"
#include "report/sections/diagnosis_figures.h"
#include "report/sections/sections_of_studies.h"
#include "report/tables.h"
#include "studies/diagnose.h"
#include "studies/diagnosis_words.h"

namespace sixdial::report {
namespace {

using report::Cell;
using report::Column;
using report::number;
using report::Section;
using report::Table;

constexpr double kDeg = 180.0 / std::numbers::pi;

Column column(
    std::string key, std::string title, std::string unit = "", std::string group = "") {
  return {
      .key = std::move(key),
      .title = std::move(title),
      .unit = std::move(unit),
      .group = std::move(group)};
}

double number_of(const Json& json) {
  return json.is_number() ? json.get<double>() : std::numeric_limits<double>::quiet_NaN();
}

Cell cell(const Json& value, int decimals = 4) { return number(number_of(value), decimals); }

Cell words(const std::string& text) { return text.empty() ? Cell{} : Cell{text}; }

std::string text_of(const Json& json) {
  return json.is_string() ? json.get<std::string>() : std::string();
}

std::string capital(std::string text) {
  if (!text.empty() && text[0] >= 'a' && text[0] <= 'z') {
    text[0] = static_cast<char>(text[0] - 'a' + 'A');
  }
  return text;
}

bool is_data_fault(const Json& cause) {
  return cause["cause"] == "outliers" || cause["cause"] == "stale_reading";
}

/// "joint_backlash@joint2" in words.
std::string name_in_words(const std::string& name) {
  const std::size_t at = name.find('@');
  return at == std::string::npos
             ? name
             : studies::cause_in_words(name.substr(0, at), name.substr(at + 1));
}

std::string standing_of(const Json& cause) {
  if (is_data_fault(cause)) return "seen in the readings themselves";
  return cause["standing"] == "confirmed"
             ? "confirmed: shown by the fitted points and by the others"
             : "suspected: not shown clearly by the fitted and by the other points alike";
}

std::string certainty_of(const Json& cause) {
  if (cause["certainty"] == "certain") return "certain: nothing else explains it as well";
  std::string text = "tied with ";
  bool first = true;
  for (const Json& rival : cause["tied_with"]) {
    text += fmt::format("{}{}", first ? "" : ", ", studies::named(rival));
    first = false;
  }
  return text;
}

Section summary(const Json& document) {
  const Json& verdict = document["verdict"];
  Section section{.id = "diagnosis", .heading = "What the simulation gets wrong"};
  for (const Json& line : verdict["found"]) {
    section.blocks.emplace_back(line.get<std::string>());
  }
  if (!document["causes"].empty()) {
    Table table{.id = "causes", .caption = "Causes found"};
    table.columns = {
        column("cause", "cause"),
        column("size", "size"),
        column("standing", "standing"),
        column("certainty", "how sure of the name"),
        column("visible_ratio", "strength", "times the noise"),
        column("gain_mm", "gain", "mm")};
    for (const Json& cause : document["causes"]) {
      table.rows.push_back(
          {capital(studies::named(cause)), words(studies::size_in_words(cause)),
           standing_of(cause), certainty_of(cause), cell(cause["visible_ratio"], 2),
           cell(cause["gain"])});
    }
    table.notes.emplace_back(
        "Strength: root mean square of what only this cause explains in the readings, over the "
        "noise. Gain: mean position error on held-out points without it less with it. After "
        "\u00B1: one standard deviation.");
    section.blocks.emplace_back(std::move(table));
  }
  return section;
}

Table ties_of(const Json& cause) {
  Table table{.id = "ties", .caption = "What these data cannot tell it from"};
  table.columns = {
      column("rival", "rival"), column("odds", "odds for the first-named", "to 1")};
  for (const Json& rival : cause["tied_with"]) {
    table.rows.push_back(
        {capital(studies::named(rival)), number(std::exp(number_of(rival["log_odds"])), 1)});
  }
  table.notes.emplace_back(
      "Odds below about 12 to 1 are a tie. Poses that move the two differently separate them: "
      "other working modes, a wider range of joint angles, both approach directions.");
  return table;
}

Section cause_section(const Json& cause, int index) {
  Section section{
      .id = fmt::format("cause_{}", index), .heading = capital(studies::named(cause))};
  const std::string size = studies::size_in_words(cause);
  std::string first = size.empty() ? std::string() : capital(size) + ". ";
  first += capital(standing_of(cause)) + ". " + capital(certainty_of(cause)) + ".";
  section.blocks.emplace_back(first);
  if (cause["delta_bic"].is_number()) {
    section.blocks.emplace_back(fmt::format(
        "Evidence for it: BIC difference {:.0f} against a model without it; 6 to 10 is strong, "
        "more is very strong.",
        number_of(cause["delta_bic"])));
  }
  section.blocks.emplace_back("How it shows: " + text_of(cause["signature"]));
  section.blocks.emplace_back("What it does: " + text_of(cause["consequence"]));
  section.blocks.emplace_back("What to do: " + text_of(cause["advice"]));
  const std::string why = text_of(cause["why_not_learned"]);
  if (!why.empty()) section.blocks.emplace_back(why);
  if (auto figure = signature_figure(cause)) section.blocks.emplace_back(std::move(*figure));
  if (!cause["tied_with"].empty()) section.blocks.emplace_back(ties_of(cause));
  return section;
}

Section gross_section(const Json& document) {
  Section section{.id = "gross_readings", .heading = "Readings left out as gross errors"};
  Table table{.id = "gross_readings", .caption = "Gross readings by number"};
  table.columns = {
      column("set", "set"),   column("point", "point"),          column("repeat", "repeat"),
      column("dial", "dial"), column("size_mm", "off by", "mm"), column("remark", "remark")};
  for (const Json& each : document["gross_readings"]) {
    table.rows.push_back(
        {text_of(each["set"]), report::whole(each["point"].get<int>()),
         report::whole(each["repeat"].get<int>()), text_of(each["dial"]),
         cell(each["size_mm"], 3), words(studies::remark_on_gross(each))});
  }
  section.blocks.emplace_back(std::move(table));
  return section;
}

Section left_section(const Json& document) {
  Section section{.id = "left", .heading = "What is left, and whether that is noise"};
  section.blocks.emplace_back(fmt::format(
      "Noise of a reading: {}. What the good readings leave{}: {} rms.",
      text_of(document["noise"]["in_words"]),
      document["extended_model"]["effects"].empty() ? "" : " after the causes",
      studies::millimetres(document["unexplained"]["rms_mm"])));
  if (auto figure = left_figure(document)) section.blocks.emplace_back(std::move(*figure));
  if (auto figure = shift_figure(document)) section.blocks.emplace_back(std::move(*figure));
  Table classes{.id = "left_by_class", .caption = "What is left by dial and direction (rms)"};
  classes.columns = {
      column("by", "by"), column("class", "class"), column("readings", "readings"),
      column("before_mm", "before", "mm"), column("after_mm", "after", "mm")};
  for (const Json& each : document["by_covariate"]) {
    if (each["kind"] != "class") continue;
    for (std::size_t i = 0; i < each["label"].size(); ++i) {
      classes.rows.push_back(
          {text_of(each["covariate"]), text_of(each["label"][i]),
           report::whole(each["readings"][i].get<int>()), cell(each["before_mm"][i], 5),
           cell(each["after_mm"][i], 5)});
    }
  }
  if (!classes.rows.empty()) section.blocks.emplace_back(std::move(classes));

  Table table{
      .id = "dependence",
      .caption = "Is there something smooth in what is left? Log odds for it, by covariate"};
  table.columns = {
      column("covariate", "depends on"),
      column("enters", "enters at"),
      column("log_odds_before", "before", "", "log odds"),
      column("log_odds_after", "after", "", "log odds"),
      column("rms_before_mm", "before", "mm", "size of it, rms"),
      column("rms_after_mm", "after", "mm", "size of it, rms")};
  std::vector<const Json*> rows;
  for (const Json& each : document["dependence"]) rows.push_back(&each);
  const auto strongest = [](const Json* each) {
    return std::max(
        number_of((*each)["log_odds_after"]), 1e-3 * number_of((*each)["log_odds_before"]));
  };
  std::ranges::stable_sort(
      rows, [&](const Json* a, const Json* b) { return strongest(a) > strongest(b); });
  for (const Json* each : rows) {
    table.rows.push_back(
        {text_of((*each)["covariate"]), text_of((*each)["enters"]),
         cell((*each)["log_odds_before"], 1), cell((*each)["log_odds_after"], 1),
         cell((*each)["rms_before_mm"], 5), cell((*each)["rms_after_mm"], 5)});
  }
  constexpr std::size_t kOnPage = 24;
  table.rows_on_page = kOnPage;
  table.notes.push_back(fmt::format(
      "Natural logarithms. Below 0: noise explains what is left better. Above {:.0f}: an "
      "unknown is reported.",
      number_of(document["inputs"]["settings"]["unknown_log_odds"])));
  if (!table.rows.empty()) section.blocks.emplace_back(std::move(table));
  return section;
}

std::string row_name(const Json& row) {
  const std::string without = text_of(row["without"]);
  return without.empty() ? text_of(row["name"]) : "without " + name_in_words(without);
}

Section gain_section(const Json& document) {
  Section section{.id = "gain", .heading = "What naming the causes gains"};
  if (document["gain"].empty()) {
    section.blocks.emplace_back(
        "Not measured: it was not asked for, or there are too few points to fit and to judge "
        "on.");
    return section;
  }
  const Json& on = document["judged_on"];
  section.blocks.emplace_back(fmt::format(
      "Every model was fitted to {} samples and judged on {} others{}. ANFIS is a network that "
      "learns what is left from the joint angles.",
      on["fitted_samples"].get<int>(), on["samples"].get<int>(),
      on["held_out_by_program"].get<bool>() ? ", every third, as the session has no G2"
                                            : " (G2)"));
  Table table{.id = "gain", .caption = "Held-out position error by model"};
  table.columns = {
      column("model", "model"),
      column("mean_mm", "mean", "mm", "position error"),
      column("std_mm", "std", "mm", "position error"),
      column("max_mm", "max", "mm", "position error"),
      column("rms_mm", "readings, rms", "mm"),
      column("difference_mm", "change", "mm", "mean against calibrated"),
      column("low_mm", "from", "mm", "mean against calibrated"),
      column("high_mm", "to", "mm", "mean against calibrated"),
      column("removed_percent", "removed", "%")};
  Table dials{.id = "gain_by_dial", .caption = "Held-out residual by dial (rms)"};
  dials.columns = {column("model", "model")};
  for (const auto& [dial, value] : document["gain"][0]["rms_by_dial_mm"].items()) {
    dials.columns.push_back(column(fmt::format("rms_{}_mm", dial), dial, "mm"));
  }
  for (const Json& row : document["gain"]) {
    if (row["name"] == "extended") table.main_row = table.rows.size();
    constexpr double kPercent = 100.0;
    table.rows.push_back(
        {row_name(row), cell(row["mean_mm"]), cell(row["std_mm"]), cell(row["max_mm"]),
         cell(row["rms_mm"], 5), cell(row["difference_mm"]), cell(row["low_mm"]),
         cell(row["high_mm"]), number(kPercent * number_of(row["removed_share"]), 0)});
    std::vector<Cell> by_dial{row_name(row)};
    for (const auto& [dial, value] : row["rms_by_dial_mm"].items()) {
      by_dial.push_back(cell(value, 5));
    }
    dials.rows.push_back(std::move(by_dial));
  }
  table.notes.emplace_back(
      "Position error: the shift of the tool that explains a sample's residuals best. From, "
      "to: "
      "95 % interval of the change, by drawing poses anew (bootstrap). A row \"without\" a "
      "cause shows what that one alone is worth. Removed: share of the calibrated robot's "
      "error "
      "above the noise; a dash where there is next to none.");
  section.blocks.emplace_back(std::move(table));
  section.blocks.emplace_back(std::move(dials));
  for (const Json& cause : document["causes"]) {
    const std::string why = text_of(cause["why_not_learned"]);
    if (!why.empty()) {
      section.blocks.emplace_back(fmt::format("{}: {}", capital(studies::named(cause)), why));
    }
  }
  return section;
}

Section parameter_section(const Json& document) {
  Section section{
      .id = "moved_parameters", .heading = "How the fitted robot moves when causes are named"};
  section.blocks.emplace_back(
      "A fit without the causes bends the robot's parameters to make up for them. The last "
      "column says by how many of its own standard deviations each had been pulled away.");
  Table table{.id = "moved_parameters", .caption = "Parameters without and with the causes"};
  table.columns = {
      column("name", "parameter"),
      column("unit", "unit"),
      column("nominal", "nominal"),
      column("baseline", "value", "", "robot alone"),
      column("baseline_sd", "sd", "", "robot alone"),
      column("extended", "value", "", "with the causes"),
      column("extended_sd", "sd", "", "with the causes"),
      column("moved", "moved"),
      column("moved_sigma", "times its sd")};
  const Json& before = document["baseline"]["parameters"];
  const Json& after = document["extended"]["parameters"];
  for (std::size_t i = 0; i < before.size(); ++i) {
    const bool angle = before[i]["unit"] == "rad";
    const auto shown = [&](const Json& value) {
      return number((angle ? kDeg : 1.0) * number_of(value), angle ? 5 : 4);
    };
    table.rows.push_back(
        {report::symbol(text_of(before[i]["name"])), std::string(angle ? "deg" : "mm"),
         shown(before[i]["nominal"]), shown(before[i]["value"]), shown(before[i]["sd"]),
         shown(after[i]["value"]), shown(after[i]["sd"]), shown(after[i]["moved"]),
         cell(after[i]["moved_sigma"], 1)});
  }
  section.blocks.emplace_back(std::move(table));
  return section;
}

Section not_testable_section(const Json& document) {
  Section section{.id = "not_testable", .heading = "What could not be tested, and why"};
  if (document["not_testable"].empty()) {
    section.blocks.emplace_back("Every cause of the catalogue could be tested at every place.");
    return section;
  }
  section.blocks.emplace_back(
      "These may be there or not: this session cannot say. The last column says what would be "
      "needed.");
  Table table{.id = "not_testable", .caption = "Not testable here"};
  table.columns = {
      column("cause", "cause"), column("reason", "why not"), column("needs", "needs")};
  for (const Json& each : document["not_testable"]) {
    table.rows.push_back(
        {capital(studies::named(each)), words(text_of(each["reason"])),
         words(text_of(each["needs"]))});
  }
  section.blocks.emplace_back(std::move(table));
  return section;
}

Section limits_section(const Json& document) {
  Section section{.id = "detection_limits", .heading = "What this session would have seen"};
  if (document["detection_limits"].empty()) {
    section.blocks.emplace_back("The limits were not computed.");
    return section;
  }
  section.blocks.emplace_back(
      "Smallest size of each cause that would have been detected here, and smallest at which "
      "it would have been named rightly, each in four of five cases. Between the two a cause "
      "shows, but as one of a set. Not found means: smaller than the first figure.");
  Table table{.id = "detection_limits", .caption = "Limits of each cause on this session"};
  table.columns = {
      column("cause", "cause"),
      column("detect", "detected from"),
      column("name", "named rightly from"),
      column("plausible", "size to expect on such a rig"),
      column("rival", "most alike"),
      column("surviving_percent", "not absorbed by the fit", "%"),
      column("absorbed_by", "absorbed by")};
  for (const Json& each : document["detection_limits"]) {
    const std::string unit = text_of(each["unit"]);
    const auto size = [&](const Json& value) -> Cell {
      if (!value.is_number()) return std::string("at no size");
      return studies::quantity_in_words(
          value.get<double>(), std::numeric_limits<double>::quiet_NaN(), unit);
    };
    constexpr double kPercent = 100.0;
    table.rows.push_back(
        {capital(studies::named(each)), size(each["detect"]), size(each["name"]),
         size(each["plausible"]), words(name_in_words(text_of(each["rival"]))),
         number(kPercent * number_of(each["surviving"]), 1),
         words(fmt::format(
             "{}", fmt::join(each["absorbed_by"].get<std::vector<std::string>>(), ", ")))});
  }
  section.blocks.emplace_back(std::move(table));
  return section;
}

std::vector<std::string> lines_of(const Json& list) {
  return list.get<std::vector<std::string>>();
}

report::Opening opening_of(const Json& document) {
  const Json& verdict = document["verdict"];
  const std::string kind = verdict["kind"];
  report::Opening box{.subject = "Diagnosis", .title = verdict["title"]};
  box.mood = kind == "nothing"                        ? "good"
             : kind == "unknown" || kind == "scatter" ? "bad"
                                                      : "open";
  box.headline = text_of(verdict["gain"]);
  if (kind == "nothing") {
    box.headline = "Nothing was found that the simulation gets wrong. " + box.headline;
  }
  const bool extended = std::any_of(
      document["causes"].begin(), document["causes"].end(),
      [](const Json& cause) { return !is_data_fault(cause); });
  for (const Json& row : document["gain"]) {
    if (row["name"] == "calibrated" && extended) box.before_mm = number_of(row["mean_mm"]);
    if (row["name"] == "extended" && extended) box.after_mm = number_of(row["mean_mm"]);
  }
  if (extended) {
    box.basis = fmt::format(
        "mean position error on {} held-out samples, robot alone and with what was named",
        document["judged_on"]["samples"].get<int>());
  }
  if (kind != "nothing") box.lists.push_back({"Found", "to_do", lines_of(verdict["found"])});
  box.lists.push_back({"What to do", "to_do", lines_of(verdict["to_do"])});
  box.lists.push_back({"How sure", "cautions", lines_of(verdict["trust"])});
  box.lists.push_back(
      {"What could not be judged", "not_judged", lines_of(verdict["not_judged"])});
  if (verdict["not_judged"].empty()) {
    box.lists.back().lines = {"Nothing: every cause could be tested at every place."};
  }
  return box;
}

}  // namespace

std::vector<Section> diagnosis_sections(const Json& document) {
  studies::check_diagnosis(document);
  std::vector<Section> sections{summary(document)};
  int index = 0;
  for (const Json& cause : document["causes"]) {
    sections.push_back(cause_section(cause, ++index));
  }
  if (!document["gross_readings"].empty()) sections.push_back(gross_section(document));
  sections.push_back(left_section(document));
  sections.push_back(gain_section(document));
  sections.push_back(parameter_section(document));
  sections.push_back(not_testable_section(document));
  sections.push_back(limits_section(document));
  return sections;
}

std::string diagnosis_page(
    const Json& document, const session::Session& session, const std::string& operator_name) {
  studies::check_diagnosis(document);
  report::ReportData data;
  data.head = report_head(document, session, operator_name);
  data.head.title = "Diagnosis report";
  data.opening = opening_of(document);
  data.sections = diagnosis_sections(document);
  data.samples = static_cast<int>(session.samples.size());
  return report::html_report(data);
}

}  // namespace sixdial::report
