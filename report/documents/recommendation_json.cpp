#include "report/documents/recommendation_json.h"

#include "report/documents/assessment_json.h"
#include "report/documents/fields.h"
#include "report/words/recommendation_words.h"

namespace sixdial::report {

template <class Fields>
void describe_keys(Fields& at, Of<Fields, studies::RecommendedWay>& candidate) {
  at.named(
      "id", candidate.by, [](studies::CompensateBy each) { return studies::to_string(each); },
      studies::compensate_by_from);
  if constexpr (!Fields::kReads) at("name", model_name(candidate.by));
  at("held_out_mm", candidate.held_out_mm);
  at("g2_mm", candidate.g2_mm);
  at("reached_mm", candidate.reached_mm);
  at("ruled_out", candidate.ruled_out);
}

Json to_json(const studies::Recommendation& recommended) {
  Json causes = Json::array();
  for (const studies::HypothesisId& cause : recommended.causes) {
    causes.push_back({{"cause", cause.cause}, {"where", cause.where}});
  }
  return {
      {"schema", "sixdial.recommendation"},
      {"schema_version", kRecommendationSchemaVersion},
      {"by", studies::to_string(recommended.by)},
      {"name", recommended_name(recommended)},
      {"why", why_recommended(recommended)},
      {"folds", recommended.folds},
      {"samples", recommended.samples},
      {"compared_by", recommended.by_diagnosis ? "diagnosis" : "calibration"},
      {"candidates", write(recommended.candidates)},
      {"parameters", write(recommended.parameters)},
      {"causes", std::move(causes)},
      {"residual_model",
       recommended.residual_model ? Json(*recommended.residual_model) : Json(nullptr)}};
}

}  // namespace sixdial::report
