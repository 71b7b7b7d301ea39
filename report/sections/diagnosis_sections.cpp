// A diagnosis as sections of a report, and as a page of its own. Figures:
// diagnosis_figures.cpp.
#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <iterator>

#include "geometry/units.h"
#include "report/documents/diagnosis_json.h"
#include "report/documents/summary.h"
#include "report/html_report.h"
#include "report/report_run.h"
#include "report/sections/diagnosis_figures.h"
#include "report/sections/sections_of_studies.h"
#include "report/tables.h"
#include "report/text.h"
#include "report/words/diagnosis_axes.h"
#include "report/words/diagnosis_verdict.h"
#include "report/words/diagnosis_words.h"

namespace sixdial::report {
namespace {

using report::Cell;
using report::Column;
using report::number;
using report::Section;
using report::Table;
using studies::DiagnosisResult;
using studies::FoundCause;
using studies::GainRow;
using studies::Rival;
using studies::VerdictKind;

Column column(
    std::string key, std::string title, std::string unit = "", std::string group = "") {
  return {
      .key = std::move(key),
      .title = std::move(title),
      .unit = std::move(unit),
      .group = std::move(group)};
}

Cell cell(double value, int decimals = 4) { return number(value, decimals); }

Cell words(const std::string& text) { return text.empty() ? Cell{} : Cell{text}; }

std::string standing_of(const FoundCause& cause) {
  if (cause.is_data_fault()) return "seen in the readings themselves";
  return cause.standing == studies::Standing::kConfirmed
             ? "confirmed: shown by the fitted points and by the others"
             : "suspected: not shown clearly by the fitted and by the other points alike";
}

std::string certainty_of(const FoundCause& cause) {
  if (cause.certainty() == studies::Certainty::kCertain) {
    return "certain: nothing else explains it as well";
  }
  std::vector<std::string> rivals;
  for (const Rival& rival : cause.tied_with) rivals.push_back(named(rival));
  return fmt::format("tied with {}", fmt::join(rivals, ", "));
}

Section summary(const DiagnosisResult& result, const DiagnosisVerdict& verdict) {
  Section section{.id = "diagnosis", .heading = "What the simulation gets wrong"};
  for (const Line& line : verdict.found) section.blocks.emplace_back(line.text);
  if (result.causes.empty()) return section;
  Table table{.id = "causes", .caption = "Causes found"};
  table.columns = {
      column("cause", "cause"),
      column("size", "size"),
      column("standing", "standing"),
      column("certainty", "how sure of the name"),
      column("visible_ratio", "strength", "times the noise"),
      column("gain_mm", "gain", "mm")};
  for (const FoundCause& cause : result.causes) {
    table.rows.push_back(
        {capital(named(cause)), words(size_in_words(cause)), standing_of(cause),
         certainty_of(cause), cell(cause.visible_ratio, 2), cell(cause.gain_mm)});
  }
  table.notes.emplace_back(
      "Strength: root mean square of what only this cause explains in the readings, over the "
      "noise. Gain: mean position error on held-out points without it less with it. After "
      "\u00B1: one standard deviation.");
  section.blocks.emplace_back(std::move(table));
  return section;
}

Table ties_of(const FoundCause& cause) {
  Table table{.id = "ties", .caption = "What these data cannot tell it from"};
  table.columns = {
      column("rival", "rival"), column("odds", "odds for the first-named", "to 1")};
  for (const Rival& rival : cause.tied_with) {
    table.rows.push_back({capital(named(rival)), number(std::exp(rival.log_odds), 1)});
  }
  table.notes.emplace_back(
      "Odds below about 12 to 1 are a tie. Poses that move the two differently separate them: "
      "other working modes, a wider range of joint angles, both approach directions.");
  return table;
}

Section cause_section(const FoundCause& cause, int index) {
  Section section{.id = fmt::format("cause_{}", index), .heading = capital(named(cause))};
  const std::string size = size_in_words(cause);
  std::string first = size.empty() ? std::string() : capital(size) + ". ";
  first += capital(standing_of(cause)) + ". " + capital(certainty_of(cause)) + ".";
  section.blocks.emplace_back(first);
  if (std::isfinite(cause.delta_bic)) {
    section.blocks.emplace_back(fmt::format(
        "Evidence for it: BIC difference {:.0f} against a model without it; 6 to 10 is strong, "
        "more is very strong.",
        cause.delta_bic));
  }
  const CauseTexts texts = texts_of(cause);
  section.blocks.emplace_back(fmt::format("How it shows: {}", texts.signature));
  section.blocks.emplace_back(fmt::format("What it does: {}", texts.consequence));
  section.blocks.emplace_back(fmt::format("What to do: {}", texts.advice));
  if (!texts.why_not_learned.empty()) {
    section.blocks.emplace_back(std::string(texts.why_not_learned));
  }
  if (auto figure = signature_figure(cause)) section.blocks.emplace_back(std::move(*figure));
  if (!cause.tied_with.empty()) section.blocks.emplace_back(ties_of(cause));
  return section;
}

Section gross_section(const DiagnosisResult& result) {
  Section section{.id = "gross_readings", .heading = "Readings left out as gross errors"};
  Table table{.id = "gross_readings", .caption = "Gross readings by number"};
  table.columns = {
      column("set", "set"),   column("point", "point"),          column("repeat", "repeat"),
      column("dial", "dial"), column("size_mm", "off by", "mm"), column("remark", "remark")};
  for (const studies::GrossReading& each : result.gross_readings) {
    table.rows.push_back(
        {each.set, report::whole(each.point), report::whole(each.repeat), each.dial,
         cell(each.size_mm, 3), words(remark_on_gross(each))});
  }
  section.blocks.emplace_back(std::move(table));
  return section;
}

Table classes_table(const DiagnosisResult& result) {
  Table table{
      .id = "left_by_class",
      .caption = result.has_dials ? "What is left by dial and direction (rms)"
                                  : "What is left by coordinate and direction (rms)"};
  table.columns = {
      column("by", "by"), column("class", "class"), column("readings", "readings"),
      column("before_mm", "before", "mm"), column("after_mm", "after", "mm")};
  for (const studies::LeftAlong& along : result.left_along) {
    if (is_number(along.along.axis)) continue;
    for (const studies::LeftInClass& each : along.classes) {
      table.rows.push_back(
          {axis_name(along.along), class_name(along.along.axis, each),
           report::whole(each.readings), cell(each.before_mm, 5), cell(each.after_mm, 5)});
    }
  }
  return table;
}

Table dependence_table(const DiagnosisResult& result) {
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
  std::vector<diagnosis::Dependence> rows = result.dependence;
  const auto strongest = [](const diagnosis::Dependence& each) {
    return std::max(each.log_odds_after, 1e-3 * each.log_odds_before);
  };
  std::ranges::stable_sort(rows, std::greater{}, strongest);
  for (const diagnosis::Dependence& each : rows) {
    table.rows.push_back(
        {fmt::format("{}", fmt::join(each.covariates, ", ")), each.enters,
         cell(each.log_odds_before, 1), cell(each.log_odds_after, 1),
         cell(each.rms_before_mm, 5), cell(each.rms_after_mm, 5)});
  }
  constexpr std::size_t kOnPage = 24;
  table.rows_on_page = kOnPage;
  table.notes.push_back(fmt::format(
      "Natural logarithms. Below 0: noise explains what is left better. Above {:.0f}: an "
      "unknown is reported.",
      result.settings.search.unknown_log_odds));
  return table;
}

Section left_section(const DiagnosisResult& result) {
  Section section{.id = "left", .heading = "What is left, and whether that is noise"};
  section.blocks.emplace_back(fmt::format(
      "Noise of a reading: {}. What the good readings leave{}: {} rms.", noise_in_words(result),
      result.extended_fit.effects.empty() ? "" : " after the causes",
      millimetres(result.unexplained.rms_mm)));
  if (auto figure = left_figure(result)) section.blocks.emplace_back(std::move(*figure));
  if (auto figure = shift_figure(result)) section.blocks.emplace_back(std::move(*figure));
  for (Table table : {classes_table(result), dependence_table(result)}) {
    if (!table.rows.empty()) section.blocks.emplace_back(std::move(table));
  }
  return section;
}

std::string row_name(const GainRow& row) {
  return row.without ? "without " + named(*row.without) : gain_row_name(row);
}

Table gain_table(const DiagnosisResult& result) {
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
  const GainRow* extended = gain_row(result, diagnosis::GainModel::kExtended);
  for (const GainRow& row : result.gain) {
    if (&row == extended) table.main_row = table.rows.size();
    constexpr double kPercent = 100.0;
    table.rows.push_back(
        {row_name(row), cell(row.mean_mm), cell(row.std_mm), cell(row.max_mm),
         cell(row.rms_mm, 5), cell(row.difference_mm), cell(row.low_mm), cell(row.high_mm),
         number(kPercent * row.removed_share, 0)});
  }
  table.notes.emplace_back(
      "Position error: the shift of the tool that explains a sample's residuals best. From, "
      "to: 95 % interval of the change, by drawing poses anew (bootstrap). A row \"without\" a "
      "cause shows what that one alone is worth. Removed: share of the calibrated robot's "
      "error above the noise; a dash where there is next to none.");
  return table;
}

Table gain_by_dial_table(const DiagnosisResult& result) {
  Table table{
      .id = "gain_by_dial",
      .caption = result.has_dials ? "Held-out residual by dial (rms)"
                                  : "Held-out residual by coordinate (rms)"};
  table.columns = {column("model", "model")};
  for (const auto& [dial, rms_mm] : result.gain.front().rms_by_dial_mm) {
    table.columns.push_back(column(fmt::format("rms_{}_mm", dial), dial, "mm"));
  }
  for (const GainRow& row : result.gain) {
    std::vector<Cell> by_dial{row_name(row)};
    for (const auto& [dial, rms_mm] : row.rms_by_dial_mm) by_dial.push_back(cell(rms_mm, 5));
    table.rows.push_back(std::move(by_dial));
  }
  return table;
}

Section gain_section(const DiagnosisResult& result) {
  Section section{.id = "gain", .heading = "What naming the causes gains"};
  if (result.gain.empty()) {
    section.blocks.emplace_back(
        "Not measured: it was not asked for, or there are too few points to fit and to judge "
        "on.");
    return section;
  }
  const studies::JudgedOn& on = result.judged_on;
  section.blocks.emplace_back(fmt::format(
      "Every model was fitted to {} samples and judged on {} others{}. ANFIS is a network that "
      "learns what is left from the joint angles.",
      on.fitted_samples, on.samples,
      on.held_out_by_program ? ", every third, as the session has no G2" : " (G2)"));
  section.blocks.emplace_back(gain_table(result));
  section.blocks.emplace_back(gain_by_dial_table(result));
  for (const FoundCause& cause : result.causes) {
    const std::string_view why = texts_of(cause).why_not_learned;
    if (!why.empty()) {
      section.blocks.emplace_back(fmt::format("{}: {}", capital(named(cause)), why));
    }
  }
  return section;
}

Section parameter_section(const DiagnosisResult& result) {
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
  for (const diagnosis::ParameterChange& each : result.parameters) {
    const geometry::ShownUnit unit = geometry::shown_unit(each.unit);
    constexpr int kOfLength = 4;
    constexpr int kOfAngle = 5;
    const int decimals = unit.name == each.unit ? kOfLength : kOfAngle;
    const auto shown = [&](double value) { return number(unit.per_unit * value, decimals); };
    table.rows.push_back(
        {report::symbol(each.name), std::string(unit.name), shown(each.nominal),
         shown(each.baseline), shown(each.baseline_sd), shown(each.extended),
         shown(each.extended_sd), shown(studies::moved(each)),
         cell(studies::moved_sigma(each), 1)});
  }
  section.blocks.emplace_back(std::move(table));
  return section;
}

Section not_testable_section(const DiagnosisResult& result) {
  Section section{.id = "not_testable", .heading = "What could not be tested, and why"};
  if (result.not_testable.empty()) {
    section.blocks.emplace_back("Every cause of the catalogue could be tested at every place.");
    return section;
  }
  section.blocks.emplace_back(
      "These may be there or not: this session cannot say. The last column says what would be "
      "needed.");
  Table table{.id = "not_testable", .caption = "Not testable here"};
  table.columns = {
      column("cause", "cause"), column("reason", "why not"), column("needs", "needs")};
  for (const studies::NotTestable& each : result.not_testable) {
    const auto [reason, needs] = not_testable_in_words(result, each);
    table.rows.push_back({capital(named(each.id)), words(reason), words(needs)});
  }
  section.blocks.emplace_back(std::move(table));
  return section;
}

Section limits_section(const DiagnosisResult& result) {
  Section section{.id = "detection_limits", .heading = "What this session would have seen"};
  if (result.limits.empty()) {
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
  for (const studies::Limit& each : result.limits) {
    const auto size = [&](double value) -> Cell {
      if (!std::isfinite(value)) return std::string("at no size");
      return quantity_in_words(value, std::nan(""), each.unit);
    };
    constexpr double kPercent = 100.0;
    table.rows.push_back(
        {capital(named(each.id)), size(each.detect), size(each.name), size(each.plausible),
         words(each.rival ? named(*each.rival) : std::string()),
         number(kPercent * each.surviving, 1),
         words(fmt::format("{}", fmt::join(each.absorbed_by, ", ")))});
  }
  section.blocks.emplace_back(std::move(table));
  return section;
}

report::Opening opening_of(const DiagnosisResult& result, const DiagnosisVerdict& verdict) {
  const VerdictKind kind = verdict.kind;
  report::Opening box{.subject = "Diagnosis", .title = verdict.title};
  box.mood = kind == VerdictKind::kNothing                                    ? "good"
             : kind == VerdictKind::kUnknown || kind == VerdictKind::kScatter ? "bad"
                                                                              : "open";
  box.headline = verdict.gain;
  if (kind == VerdictKind::kNothing) {
    box.headline = "Nothing was found that the simulation gets wrong. " + box.headline;
  }
  if (studies::names_an_effect(result)) {
    const auto mean_of = [&](diagnosis::GainModel model) -> std::optional<double> {
      const GainRow* row = gain_row(result, model);
      return row == nullptr ? std::nullopt : std::optional(row->mean_mm);
    };
    box.before_mm = mean_of(diagnosis::GainModel::kCalibrated);
    box.after_mm = mean_of(diagnosis::GainModel::kExtended);
    box.basis = fmt::format(
        "mean position error on {} held-out samples, robot alone and with what was named",
        result.judged_on.samples);
  }
  if (kind != VerdictKind::kNothing) {
    box.lists.push_back({"Found", "to_do", texts_of(verdict.found)});
  }
  box.lists.push_back({"What to do", "to_do", texts_of(verdict.to_do)});
  box.lists.push_back({"How sure", "cautions", verdict.trust});
  box.lists.push_back({"What could not be judged", "not_judged", verdict.not_judged});
  if (verdict.not_judged.empty()) {
    box.lists.back().lines = {"Nothing: every cause could be tested at every place."};
  }
  return box;
}

}  // namespace

std::vector<Section> diagnosis_sections(const DiagnosisResult& result) {
  std::vector<Section> sections{summary(result, verdict_in_words(result))};
  int index = 0;
  for (const FoundCause& cause : result.causes) {
    sections.push_back(cause_section(cause, ++index));
  }
  if (!result.gross_readings.empty()) sections.push_back(gross_section(result));
  sections.push_back(left_section(result));
  sections.push_back(gain_section(result));
  sections.push_back(parameter_section(result));
  sections.push_back(not_testable_section(result));
  sections.push_back(limits_section(result));
  return sections;
}

std::string diagnosis_page(
    const DiagnosisResult& result, const session::Session& session,
    const std::string& operator_name) {
  report::ReportData data;
  data.head =
      report_head(result.inputs, settings_rows(settings_json(result)), session, operator_name);
  data.head.title = "Diagnosis report";
  data.opening = opening_of(result, verdict_in_words(result));
  if (result.warnings) data.warnings = *result.warnings;
  data.sections = diagnosis_sections(result);
  data.samples = static_cast<int>(session.samples.size());
  return report::html_report(data);
}

}  // namespace sixdial::report
