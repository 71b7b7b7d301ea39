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
#include "report/expanded.h"
#include "report/html_report.h"
#include "report/report_run.h"
#include "report/sections/diagnosis_figures.h"
#include "report/sections/rig_section.h"
#include "report/sections/sections_of_studies.h"
#include "report/tables.h"
#include "report/text.h"
#include "report/words/diagnosis_axes.h"
#include "report/words/diagnosis_verdict.h"
#include "report/words/diagnosis_words.h"

namespace sixdial::report {
namespace {

using report::Cell;
using report::number;
using report::Section;
using report::Table;
using studies::DiagnosisResult;
using studies::FoundCause;
using studies::GainRow;
using studies::Rival;
using studies::VerdictKind;

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
  return fmt::format("not told from {}", fmt::join(rivals, ", "));
}

Section summary(const DiagnosisResult& result, const DiagnosisVerdict& verdict, Beside beside) {
  Section section{.id = "diagnosis", .heading = "What the simulation gets wrong"};
  // Beside a calibration the first page has just said all of it.
  const bool said = beside == Beside::kCalibration && !result.causes.empty();
  for (const Line& line : verdict.found) {
    if (!said) section.blocks.emplace_back(line.text);
  }
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
        {capital(named(cause)), text_cell(size_in_words(cause)), standing_of(cause),
         certainty_of(cause), number(cause.visible_ratio, 2), number(cause.gain_mm)});
  }
  table.notes.emplace_back(
      "Strength: root mean square of what only this cause explains in the readings, over the "
      "noise. Gain: how much longer the mean tool shift on points that were not fitted is "
      "without it. After \u00B1: the expanded uncertainty, k = 2.");
  section.blocks.emplace_back(std::move(table));
  return section;
}

Table ties_of(const FoundCause& cause) {
  Table table{.id = "ties", .caption = "What these data do not tell it from"};
  table.columns = {
      column("rival", "rival"), column("odds", "odds for the first-named", "to 1")};
  for (const Rival& rival : cause.tied_with) {
    table.rows.push_back({capital(named(rival)), number(std::exp(rival.log_odds), 1)});
  }
  table.notes.emplace_back(
      "Odds below about 12 to 1 leave it open. Poses at which the two differ tell them apart: "
      "other "
      "working modes, a wider range of joint values, both sides of approach.");
  return table;
}

Section cause_section(const FoundCause& cause, int index) {
  Section section{.id = fmt::format("cause_{}", index), .heading = capital(named(cause))};
  const std::string size = size_in_words(cause);
  std::string first = size.empty() ? std::string() : capital(size) + ". ";
  first += capital(standing_of(cause)) + ". " + capital(certainty_of(cause)) + ".";
  if (std::isfinite(cause.delta_bic)) {
    first += fmt::format(
        " Evidence for it: the Bayesian information criterion is {:.0f} better than without "
        "it; 6 to 10 is strong, more is very strong.",
        cause.delta_bic);
  }
  section.blocks.emplace_back(first);
  const CauseTexts texts = texts_of(cause);
  section.blocks.emplace_back(
      fmt::format("How it shows: {} What it does: {}", texts.signature, texts.consequence));
  std::string last = fmt::format("What to do: {}", texts.advice);
  if (!texts.why_not_learned.empty()) last += fmt::format(" {}", texts.why_not_learned);
  section.blocks.emplace_back(last);
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
         number(each.size_mm, 3), text_cell(remark_on_gross(each))});
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
           report::whole(each.readings), number(each.before_mm, 5), number(each.after_mm, 5)});
    }
  }
  return table;
}

Table dependence_table(const DiagnosisResult& result) {
  Table table{
      .id = "dependence",
      .caption = "Does what is left depend smoothly on something? Log odds for it"};
  table.columns = {
      column("covariate", "depends on"),
      column("enters", "acts on"),
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
        {covariates_in_words(each.covariates), each.enters, number(each.log_odds_before, 1),
         number(each.log_odds_after, 1), number(each.rms_before_mm, 5),
         number(each.rms_after_mm, 5)});
  }
  constexpr std::size_t kOnPage = 24;
  table.rows_on_page = kOnPage;
  table.notes.push_back(fmt::format(
      "Natural logarithms. Below 0: noise explains what is left better. Above {:.0f}: it is "
      "reported "
      "as something unnamed.",
      result.settings.search.unknown_log_odds));
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
    std::vector<Cell> by_dial{gain_row_in_words(row)};
    for (const auto& [dial, rms_mm] : row.rms_by_dial_mm) by_dial.push_back(number(rms_mm, 5));
    table.rows.push_back(std::move(by_dial));
  }
  return table;
}

Section left_section(const DiagnosisResult& result) {
  Section section{
      .id = "left", .heading = "What is left, and whether that is noise", .in_annex = true};
  section.blocks.emplace_back(fmt::format(
      "Noise of a reading: {}. What the good readings leave{}: {} rms.", noise_in_words(result),
      std::ranges::any_of(result.causes, &studies::FoundCause::is_in_fit) ? " after the causes"
                                                                          : "",
      millimetres(result.unexplained.rms_mm)));
  if (auto figure = left_figure(result)) section.blocks.emplace_back(std::move(*figure));
  if (auto figure = shift_figure(result)) section.blocks.emplace_back(std::move(*figure));
  for (Table table : {classes_table(result), dependence_table(result)}) {
    if (!table.rows.empty()) section.blocks.emplace_back(std::move(table));
  }
  if (!result.gain.empty()) section.blocks.emplace_back(gain_by_dial_table(result));
  return section;
}

Table gain_table(const DiagnosisResult& result) {
  Table table{
      .id = "gain", .caption = "Mean tool shift on points that were not fitted, by model"};
  table.columns = {
      column("model", "model"),
      column("mean_mm", "mean", "mm", "tool shift"),
      column("std_mm", "std", "mm", "tool shift"),
      column("max_mm", "max", "mm", "tool shift"),
      column("rms_mm", "readings, rms", "mm"),
      column("difference_mm", "change", "mm", "mean against robot alone"),
      column("low_mm", "from", "mm", "mean against robot alone"),
      column("high_mm", "to", "mm", "mean against robot alone"),
      column("mean_falls_percent", "mean falls by", "%")};
  const GainRow* calibrated = gain_row(result, diagnosis::GainModel::kCalibrated);
  const GainRow* extended = gain_row(result, diagnosis::GainModel::kExtended);
  for (const GainRow& row : result.gain) {
    if (&row == extended) table.main_row = table.rows.size();
    constexpr double kPercent = 100.0;
    const bool is_drawing = row.model == diagnosis::GainModel::kNominal;
    const double falls = calibrated == nullptr || is_drawing
                             ? std::nan("")
                             : kPercent * (1.0 - row.mean_mm / calibrated->mean_mm);
    table.rows.push_back(
        {gain_row_in_words(row), number(row.mean_mm), number(row.std_mm), number(row.max_mm),
         number(row.rms_mm, 5), number(row.difference_mm), number(row.low_mm),
         number(row.high_mm), number(falls, 0)});
  }
  table.notes.emplace_back(
      "Tool shift: the one shift of the tool that explains all readings of a sample best. It "
      "is "
      "not the position error of the tables above, which rests on the dials that give a "
      "position. From, to: 95 % interval of the change, by drawing poses anew (bootstrap). A "
      "row \"without\" a cause shows what that one alone is worth.");
  return table;
}

Section gain_section(const DiagnosisResult& result) {
  Section section{.id = "gain", .heading = "What naming the causes gains"};
  if (result.gain.empty()) {
    section.blocks.emplace_back(
        "Not measured: it was not asked for, or there are too few points to fit some and to "
        "judge by "
        "the others.");
    return section;
  }
  const studies::JudgedOn& on = result.judged_on;
  section.blocks.emplace_back(fmt::format(
      "Every model was fitted to {} samples and judged by {} others{}. ANFIS is a network that "
      "learns from the joint values what is left.",
      on.fitted_samples, on.samples,
      on.held_out_by_program ? ", every third, as the session has no G2" : " (G2)"));
  section.blocks.emplace_back(gain_table(result));
  return section;
}

Section parameter_section(const DiagnosisResult& result) {
  Section section{
      .id = "moved_parameters",
      .heading = "How the fitted robot moves when causes are named",
      .in_annex = true};
  section.blocks.emplace_back(
      "A fit without the causes bends the robot's parameters to make up for them. The last "
      "column "
      "says how far each had been pulled away, in its own standard deviations.");
  Table table{.id = "moved_parameters", .caption = "Parameters without and with the causes"};
  table.columns = {
      column("name", "parameter"),
      column("unit", "unit"),
      column("nominal", "nominal"),
      column("baseline", "value", "", "robot alone"),
      expanded_column("baseline_sd", "", "robot alone"),
      column("extended", "value", "", "with the causes"),
      expanded_column("extended_sd", "", "with the causes"),
      column("moved", "moved"),
      column("moved_sigma", "moved, in standard deviations")};
  for (const diagnosis::ParameterChange& each : result.parameters) {
    const geometry::ShownUnit unit = geometry::shown_unit(each.unit);
    constexpr int kOfLength = 4;
    constexpr int kOfAngle = 5;
    const int decimals = unit.name == each.unit ? kOfLength : kOfAngle;
    const auto shown = [&](double value) { return number(unit.per_unit * value, decimals); };
    table.rows.push_back(
        {report::symbol(each.name), std::string(unit.name), shown(each.nominal),
         shown(each.baseline), expanded(unit.per_unit * each.baseline_sd, decimals),
         shown(each.extended), expanded(unit.per_unit * each.extended_sd, decimals),
         shown(studies::moved(each)), number(studies::moved_sigma(each), 1)});
  }
  section.blocks.emplace_back(std::move(table));
  return section;
}

Section not_testable_section(const DiagnosisResult& result) {
  Section section{
      .id = "not_testable", .heading = "What could not be tested, and why", .in_annex = true};
  if (result.not_testable.empty()) {
    section.blocks.emplace_back("Every cause of the catalogue could be tested at every place.");
    return section;
  }
  section.blocks.emplace_back(
      "This session cannot say whether these are there. The last column says what it would "
      "take.");
  Table table{.id = "not_testable", .caption = "Not testable here"};
  table.columns = {
      column("cause", "cause"), column("reason", "why not"), column("needs", "needs")};
  for (const studies::NotTestable& each : result.not_testable) {
    const auto [reason, needs] = not_testable_in_words(result, each);
    table.rows.push_back({capital(named(each.id)), text_cell(reason), text_cell(needs)});
  }
  section.blocks.emplace_back(std::move(table));
  return section;
}

Section limits_section(const DiagnosisResult& result) {
  Section section{
      .id = "detection_limits",
      .heading = "What this session would have seen",
      .in_annex = true};
  if (result.limits.empty()) {
    section.blocks.emplace_back("The limits were not computed.");
    return section;
  }
  section.blocks.emplace_back(
      "The smallest size at which each cause would have been seen here, and the smallest at "
      "which "
      "it would have got its right name, each in four of five cases. Between the two it is "
      "seen, "
      "but not told from others. A cause that was not found is smaller than the first figure. "
      "At no "
      "plausible size: it would have to be more than 50 times the size to expect, so that this "
      "session cannot show it.");
  Table table{.id = "detection_limits", .caption = "Limits of each cause on this session"};
  table.columns = {
      column("cause", "cause"),
      column("detect", "detected from"),
      column("name", "named rightly from"),
      column("plausible", "size to expect on such a rig"),
      column("rival", "most alike"),
      column("surviving_percent", "left by the fit", "%"),
      column("absorbed_by", "imitated by")};
  for (const studies::Limit& each : result.limits) {
    const auto size = [&](double value) -> Cell {
      if (!std::isfinite(value)) return std::string("at no size");
      if (is_beyond_plausible(each, value)) return std::string(kAtNoPlausibleSize);
      return quantity_in_words(value, std::nan(""), each.unit);
    };
    constexpr double kPercent = 100.0;
    table.rows.push_back(
        {capital(named(each.id)), size(each.detect), size(each.name), size(each.plausible),
         text_cell(each.rival ? named(*each.rival) : std::string()),
         number(kPercent * each.surviving, 1),
         text_cell(fmt::format("{}", fmt::join(each.absorbed_by, ", ")))});
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
        "mean tool shift on {} samples that were not fitted, robot alone and with the causes",
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

std::vector<Section> diagnosis_sections(const DiagnosisResult& result, Beside beside) {
  std::vector<Section> sections{summary(result, verdict_in_words(result), beside)};
  int index = 0;
  const bool alone = beside == Beside::kNothing;
  // The table of causes has them all; a report that is read has room for the strongest.
  constexpr int kCausesInFront = 2;
  int shown = 0;
  for (const FoundCause& cause : result.causes) {
    ++index;
    // Faults of the data are listed with the data.
    if (!alone && cause.is_data_fault()) continue;
    sections.push_back(cause_section(cause, index));
    sections.back().in_annex = !alone && ++shown > kCausesInFront;
  }
  if (alone && !result.gross_readings.empty()) sections.push_back(gross_section(result));
  sections.push_back(left_section(result));
  if (result.rig && !result.rig->empty()) sections.push_back(rig_seen_section(*result.rig));
  sections.push_back(gain_section(result));
  if (alone) sections.push_back(parameter_section(result));
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
