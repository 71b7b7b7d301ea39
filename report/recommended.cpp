#include "report/recommended.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "geometry/units.h"
#include "report/expanded.h"
#include "report/tables.h"
#include "report/text.h"
#include "report/words/recommendation_words.h"
#include "studies/method_name.h"

namespace sixdial::report {
namespace {

using studies::CompensateBy;

ErrorStatistics statistics_of(const studies::GainRow& row, int points) {
  return {.mean_mm = row.mean_mm, .std_mm = row.std_mm, .max_mm = row.max_mm, .points = points};
}

std::optional<ErrorStatistics> modelled_on_g2(
    const studies::CalibrationResult& calibration, const studies::DiagnosisResult* diagnosis,
    CompensateBy by) {
  if (is_extended(by)) {
    const studies::GainRow* row = diagnosis == nullptr
                                      ? nullptr
                                      : gain_row(
                                            *diagnosis, diagnosis::GainModel::kExtended,
                                            by == CompensateBy::kExtendedFull);
    if (row == nullptr) return std::nullopt;
    return statistics_of(*row, diagnosis->judged_on.samples);
  }
  const studies::MethodRow* row = calibration.method(
      by == CompensateBy::kFull ? calibration.result_method
                                : studies::without_residual_model(calibration.result_method));
  if (row == nullptr || !row->g2) return std::nullopt;
  return ErrorStatistics{
      .mean_mm = row->g2->mean_mm,
      .std_mm = row->g2->std_mm,
      .max_mm = row->g2->max_mm,
      .points = row->g2->points};
}

const studies::ValidatedWay* measured_way(
    const studies::ValidationResult* validation, CompensateBy by) {
  if (validation == nullptr) return nullptr;
  const auto found = std::ranges::find(validation->methods, by, &studies::ValidatedWay::by);
  return found == validation->methods.end() || !found->errors ? nullptr : &*found;
}

ErrorStatistics statistics_of(const studies::ReachedErrors& errors) {
  return {
      .mean_mm = errors.mean_mm,
      .std_mm = errors.std_mm,
      .max_mm = errors.max_mm,
      .points = errors.points};
}

/// The figures of what was measured again; else those on G2; else none.
std::optional<Headline> headline_of(
    const studies::Recommendation& recommended, const studies::CalibrationResult& calibration,
    const studies::DiagnosisResult* diagnosis, const studies::ValidationResult* validation) {
  if (recommended.by == CompensateBy::kBefore) return std::nullopt;
  const studies::MethodRow* before = calibration.method("before");
  if (before == nullptr || !before->g2) return std::nullopt;
  Headline headline{
      .model = recommended_name(recommended),
      .before = {
          .mean_mm = before->g2->mean_mm,
          .std_mm = before->g2->std_mm,
          .max_mm = before->g2->max_mm,
          .points = before->g2->points}};
  const auto modelled = modelled_on_g2(calibration, diagnosis, recommended.by);
  if (const auto* way = measured_way(validation, recommended.by)) {
    headline.after = statistics_of(*way->errors);
    headline.predicted_mm = way->predicted_mean_mm();
    headline.measured_in = validation->inputs.validation_session;
    if (const auto* nominal = measured_way(validation, CompensateBy::kBefore)) {
      headline.before = statistics_of(*nominal->errors);
    }
    return headline;
  }
  if (!modelled) return std::nullopt;
  headline.after = *modelled;
  // Of a diagnosis both figures are tool shifts: one definition on either side of the arrow.
  const studies::GainRow* drawn = is_extended(recommended.by)
                                      ? gain_row(*diagnosis, diagnosis::GainModel::kNominal)
                                      : nullptr;
  if (drawn != nullptr) {
    headline.by_tool_shift = true;
    headline.before = statistics_of(*drawn, diagnosis->judged_on.samples);
  }
  return headline;
}

Table candidates_table(const studies::Recommendation& recommended) {
  Table table{
      .id = "recommendation",
      .caption = "Mean position error of each model that could be commanded by"};
  table.columns = {
      {.key = "model", .title = "model"},
      {.key = "held_out_mm", .title = "G1, left out in turn", .unit = "mm"},
      {.key = "g2_mm", .title = "G2, modelled", .unit = "mm"},
      {.key = "reached_mm", .title = "commanded again, reached", .unit = "mm"},
      {.key = "remark", .title = "remark"}};
  for (const studies::RecommendedWay& each : recommended.candidates) {
    const bool chosen = each.by == recommended.by;
    if (chosen) table.main_row = table.rows.size();
    table.rows.push_back(
        {model_name(each.by), number(each.held_out_mm), number(each.g2_mm),
         number(each.reached_mm),
         std::string(
             chosen           ? "recommended"
             : each.ruled_out ? "missed by more than the identified parameters"
                              : "")});
  }
  table.notes.emplace_back(
      "The first column decides: models are fitted to the other poses of G1. G2 only reports. "
      "What was commanded again and missed by more than the identified parameters is never "
      "recommended.");
  if (recommended.by_diagnosis) {
    table.notes.emplace_back(
        "The first column is the mean tool shift: the one shift of the tool that explains all "
        "readings of a sample best.");
  }
  if (std::ranges::any_of(recommended.candidates, [](const studies::RecommendedWay& each) {
        return is_extended(each.by) && each.g2_mm.has_value();
      })) {
    table.notes.emplace_back(
        "On G2 models with causes are told by the mean tool shift, the others by the mean "
        "position error.");
  }
  return table;
}

bool leaves_more_than_noise(
    const ReportData& data, const studies::Recommendation& recommended) {
  const studies::RecommendedWay* chosen = recommended.of(recommended.by);
  if (chosen == nullptr || !data.position_noise_mm) return false;
  const std::optional<double> left_mm =
      chosen->held_out_mm ? chosen->held_out_mm : chosen->g2_mm;
  constexpr double kAtTheNoise = 1.5;
  return left_mm && *left_mm > kAtTheNoise * *data.position_noise_mm;
}

/// The parameters of a model with causes; those of the others are the identified ones, which
/// have a table already.
Table parameters_table(
    const studies::Recommendation& recommended, const geometry::RobotModel& robot) {
  Table table{
      .id = "recommended_parameters",
      .caption = "Recommended parameters, of robot and causes together"};
  table.columns = {
      {.key = "parameter", .title = "parameter"},
      {.key = "meaning", .title = "what it is"},
      {.key = "unit", .title = "unit"},
      {.key = "nominal", .title = "nominal"},
      {.key = "recommended", .title = "recommended"},
      expanded_column("sd")};
  for (const studies::ParameterRow& each : recommended.parameters) {
    const geometry::ShownUnit unit = geometry::shown_unit(each.unit);
    const double sd = each.sd * unit.per_unit;
    const int decimals =
        std::max(3, std::isfinite(sd) && sd > 0 ? decimals_for(geometry::kCoverage * sd) : 3);
    const auto cell = [&](double value) { return number(value * unit.per_unit, decimals); };
    std::string meaning;
    if (const auto known = robot.find_parameter(each.name)) {
      meaning = robot.parameters[static_cast<std::size_t>(*known)].meaning;
    }
    table.rows.push_back(
        {symbol(each.name), std::move(meaning), std::string(unit.name), cell(each.nominal),
         cell(each.identified), expanded(sd, decimals)});
  }
  return table;
}

}  // namespace

void add_recommendation(
    ReportData& data, const studies::Recommendation& recommended,
    const studies::CalibrationResult& calibration, const geometry::RobotModel& robot,
    const studies::DiagnosisResult* diagnosis, const studies::ValidationResult* validation) {
  const std::string session = calibration.inputs.session;
  data.headline = headline_of(recommended, calibration, diagnosis, validation);
  data.measured_again = data.headline && data.headline->measured_in.has_value();
  data.first_to_do = how_to_use(recommended, session);
  if (diagnosis == nullptr && leaves_more_than_noise(data, recommended)) {
    data.first_to_do.insert(
        data.first_to_do.begin(),
        fmt::format(
            "Diagnose first: \"sixdial diagnose {}\". More is left than the noise of the "
            "measured positions; if that is a cause with a name, other parameters will be "
            "recommended.",
            session));
  }
  const bool helps = recommended.by != CompensateBy::kBefore;
  if (helps && !data.measured_again) {
    data.first_to_do.push_back(fmt::format(
        "Confirm on the robot: \"sixdial validate {}\" commands the targets of G2 by the "
        "recommended model and measures again. The figures here compare measured with modelled "
        "positions.",
        session));
  }
  Section section{.id = "recommendation", .heading = "Which model to use"};
  section.blocks.emplace_back(why_recommended(recommended));
  section.blocks.emplace_back(candidates_table(recommended));
  if (is_extended(recommended.by)) {
    section.blocks.emplace_back(parameters_table(recommended, robot));
    data.parameters_note =
        "These are of the robot alone. They also make up for what the named causes do, which "
        "their U does not contain, so they are not recommended: the recommended ones stand "
        "under "
        "\"Which model to use\".";
  }
  data.sections.insert(data.sections.begin(), std::move(section));
}

}  // namespace sixdial::report
