#include "report/words/recommendation_words.h"

#include <fmt/format.h>

#include "calibration/residual_model.h"
#include "report/text.h"
#include "report/words/diagnosis_words.h"

namespace sixdial::report {
namespace {

using studies::ChosenBecause;
using studies::CompensateBy;
using studies::Recommendation;
using studies::RecommendedWay;

std::string residual_model_title(const std::string& name) {
  const calibration::ResidualModel* model = calibration::find_residual_model(name);
  return std::string(model != nullptr ? model->title : name);
}

std::string held_out(const Recommendation& recommended, CompensateBy by) {
  const RecommendedWay* candidate = recommended.of(by);
  return candidate != nullptr && candidate->held_out_mm ? length(*candidate->held_out_mm)
                                                        : std::string("-");
}

/// "identified parameters 15.2 µm, robot and named causes 11.8 µm".
std::string others(const Recommendation& recommended) {
  std::vector<std::string> parts;
  for (const RecommendedWay& each : recommended.candidates) {
    if (each.by == recommended.by || !each.held_out_mm) continue;
    parts.push_back(fmt::format("{} {}", model_name(each.by), held_out(recommended, each.by)));
  }
  return list_of(parts);
}

std::string comparison(const Recommendation& recommended) {
  const std::string rest = others(recommended);
  return fmt::format(
      "On {} of G1 that were left out in turn ({} parts, whole poses) it misses by {} on "
      "average{}.",
      counted(recommended.samples, "sample", "samples"), recommended.folds,
      held_out(recommended, recommended.by),
      rest.empty() ? std::string() : fmt::format("; {}", rest));
}

/// Models that were commanded again and missed by more than plain kinematics.
std::string ruled_out(const Recommendation& recommended) {
  std::vector<std::string> parts;
  for (const RecommendedWay& each : recommended.candidates) {
    if (!each.ruled_out || !each.reached_mm) continue;
    parts.push_back(fmt::format("{} ({})", model_name(each.by), length(*each.reached_mm)));
  }
  const RecommendedWay* plain = recommended.of(CompensateBy::kKinematics);
  if (parts.empty() || plain == nullptr || !plain->reached_mm) return "";
  return fmt::format(
      " Commanded again, {} missed by more than the {} ({}), and {} not recommended.",
      list_of(parts), model_name(CompensateBy::kKinematics), length(*plain->reached_mm),
      parts.size() == 1 ? "is" : "are");
}

}  // namespace

std::string model_name(CompensateBy by) {
  switch (by) {
    case CompensateBy::kBefore:
      return "nominal parameters";
    case CompensateBy::kKinematics:
      return "identified parameters";
    case CompensateBy::kFull:
      return "identified parameters + residual model";
    case CompensateBy::kExtended:
      return "robot and named causes";
    case CompensateBy::kExtendedFull:
      return "robot and named causes + residual model";
  }
  return "";
}

std::string recommended_name(const Recommendation& recommended) {
  if (!is_extended(recommended.by)) {
    const std::string name = model_name(recommended.by);
    return recommended.residual_model
               ? fmt::format("{} ({})", name, residual_model_title(*recommended.residual_model))
               : name;
  }
  std::vector<std::string> parts{"robot"};
  for (const studies::HypothesisId& cause : recommended.causes) parts.push_back(named(cause));
  std::string name = list_of(parts);
  if (recommended.residual_model) {
    name += fmt::format(
        " + residual model ({})", residual_model_title(*recommended.residual_model));
  }
  return name;
}

std::string why_recommended(const Recommendation& recommended) {
  const std::string name = recommended_name(recommended);
  std::string text;
  switch (recommended.because) {
    case ChosenBecause::kNothingHelps:
      return "Nothing is recommended: no model does better than the nominal parameters." +
             ruled_out(recommended);
    case ChosenBecause::kNotCompared:
      return fmt::format(
          "Recommended: {}. Models were not compared: G1 has too few poses to leave some out.",
          name);
    case ChosenBecause::kOnlyOne:
      text = fmt::format(
          "Recommended: {}, the only model: no cause is named and no residual model was "
          "trained. {}",
          name, comparison(recommended));
      break;
    case ChosenBecause::kBest:
      text = fmt::format(
          "Recommended: {}. {} No simpler model does as well.", name, comparison(recommended));
      break;
    case ChosenBecause::kSimplest:
      text = fmt::format(
          "Recommended: {}. {} The {} would be better by less than one standard error or a "
          "twentieth, which may be chance or is not worth it: the simpler model is taken.",
          name, comparison(recommended), model_name(recommended.best.value()));
      break;
    case ChosenBecause::kRuledOut:
      text = fmt::format("Recommended: {}. {}", name, comparison(recommended));
      break;
  }
  return text + ruled_out(recommended);
}

std::vector<std::string> how_to_use(
    const Recommendation& recommended, const std::string& session) {
  const std::string command = fmt::format("\"sixdial compensate {} --plan PLAN.csv\"", session);
  switch (recommended.by) {
    case CompensateBy::kBefore:
      return {
          "Change nothing in the controller: no model does better than the nominal "
          "parameters."};
    case CompensateBy::kKinematics:
      return {"Enter the identified parameters in the controller."};
    case CompensateBy::kFull:
      return {
          "Enter the identified parameters in the controller.",
          fmt::format(
              "Use the residual model on top, inside the measured area only: {} gives the "
              "joint values. The parameters alone leave {} instead of {} (G1, left out in "
              "turn).",
              command, held_out(recommended, CompensateBy::kKinematics),
              held_out(recommended, CompensateBy::kFull))};
    case CompensateBy::kExtended:
    case CompensateBy::kExtendedFull:
      break;
  }
  return {fmt::format(
      "Command by the recommended model ({}), inside the measured area only: {} gives the "
      "joint values. Its parameters belong together with the causes; a controller that takes "
      "parameters only leaves {} instead of {} (G1, left out in turn).",
      recommended_name(recommended), command, held_out(recommended, CompensateBy::kKinematics),
      held_out(recommended, recommended.by))};
}

}  // namespace sixdial::report
