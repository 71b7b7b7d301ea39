#include "service/recommended_model.h"

#include <algorithm>
#include <vector>

#include "report/documents/calibration_json.h"
#include "report/documents/diagnosis_json.h"
#include "report/documents/validation_json.h"
#include "report/documents/warnings_document.h"
#include "service/methods/method.h"
#include "service/result_lookup.h"
#include "studies/stored_warnings.h"

namespace sixdial::service {
namespace {

/// Whether two stored results say the same under all of these keys.
bool agree(
    const db::ResultRecord& one, const Json& other, std::initializer_list<const char*> keys) {
  const Json json = Json::parse(one.json);
  return std::ranges::all_of(keys, [&](const char* key) {
    return json.value(key, Json()) == other.value(key, Json());
  });
}

/// Whether result `number` is `record`, or commands as it does.
bool commands_as(
    db::Store& reader, std::int64_t number, const db::ResultRecord& record,
    std::initializer_list<const char*> keys) {
  if (number == record.id.value) return true;
  return agree(reader.load_result({number}), Json::parse(record.json), keys);
}

/// A session is only loaded for a result of a version that did not judge.
void judge(db::Store& reader, const db::ResultRecord& record, auto& result) {
  if (!result.warnings) studies::judge_stored(result, reader.load_session(record.session));
}

}  // namespace

std::vector<studies::Warning> warnings_of(
    db::Store& reader, const db::ResultRecord& record, const Json& document) {
  const auto judged = [&](auto result) {
    judge(reader, record, result);
    return result.warnings.value_or(std::vector<studies::Warning>());
  };
  if (document.contains("warnings")) return report::warnings_in(document);
  if (record.kind == "diagnosis") return judged(report::diagnosis_from_json(document));
  return judged(report::calibration_from_json(document));
}

studies::Recommendation RecommendedModel::recommendation() const {
  return studies::recommend(
      calibration, diagnosis ? &*diagnosis : nullptr, validation ? &*validation : nullptr);
}

RecommendedModel recommended_model(db::Store& reader, const db::ResultRecord& calibration) {
  RecommendedModel model{
      .calibration = report::calibration_from_json(Json::parse(calibration.json)),
      .calibration_number = calibration.id.value};
  judge(reader, calibration, model.calibration);
  const auto diagnosis = companion_of(reader, calibration, "diagnosis");
  if (diagnosis) {
    model.diagnosis = report::diagnosis_from_json(Json::parse(diagnosis->json));
    judge(reader, *diagnosis, *model.diagnosis);
    model.diagnosis_number = diagnosis->id.value;
  }
  std::vector<db::ResultRecord> validations =
      reader.load_results(calibration.session, "validation");
  for (auto each = validations.rbegin(); each != validations.rend(); ++each) {
    studies::ValidationResult result = report::validation_from_json(Json::parse(each->json));
    const auto commanded = result.inputs.calibration_result;
    if (!commanded || !commands_as(
                          reader, *commanded, calibration,
                          {"parameters", "result_method", "anfis", "residual_model"})) {
      continue;
    }
    const auto by = result.inputs.diagnosis_result;
    if (!diagnosis || !by || !commands_as(reader, *by, *diagnosis, {"extended_model"})) {
      std::erase_if(result.methods, [](const studies::ValidatedWay& way) {
        return studies::is_extended(way.by);
      });
    }
    model.validation = std::move(result);
    model.validation_number = each->id.value;
    break;
  }
  return model;
}

}  // namespace sixdial::service
