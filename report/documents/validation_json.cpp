#include "report/documents/validation_json.h"

#include "report/documents/fields.h"
#include "report/documents/gain_json.h"
#include "report/documents/set_errors_json.h"
#include "report/words/validation_words.h"

namespace sixdial::report {
namespace {

constexpr const char* kSchema = "sixdial.validation";

template <class Fields, class By>
void way_key(Fields& at, const char* key, By& by) {
  at.named(
      key, by, [](studies::CompensateBy each) { return studies::to_string(each); },
      studies::compensate_by_from);
}

}  // namespace

template <class Fields>
void describe_keys(Fields& at, Of<Fields, studies::ReachedErrors>& errors) {
  at("mean_mm", errors.mean_mm);
  at("std_mm", errors.std_mm);
  at("max_mm", errors.max_mm);
  at("rmse_mm", errors.rmse_mm);
  at("points", errors.points);
}

template <class Fields>
void describe_keys(Fields& at, Of<Fields, studies::ValidatedWay>& way) {
  way_key(at, "id", way.by);
  at("set", way.set);
  at("errors", way.errors);
  if (studies::is_extended(way.by)) {
    at("predicted", way.predicted_gain);
  } else {
    at("predicted", way.predicted);
  }
  at("without_position", way.without_position);
}

template <class Fields>
void describe_keys(Fields& at, Of<Fields, studies::ValidatedPoint>& point) {
  way_key(at, "method", point.by);
  at("point", point.point);
  at("target_mm", point.target_mm);
  at("theta_rad", point.theta_rad);
  at("error_mm", point.error_mm);
}

template <class Fields>
void describe_keys(Fields& at, Of<Fields, studies::NotMeasured>& point) {
  at("set", point.set);
  at("point", point.point);
  at("repeat", point.repeat);
  at("why", point.why);
}

template <class Fields>
void describe_keys(Fields& at, Of<Fields, studies::ValidationInputs>& inputs) {
  at("session", inputs.session);
  at("set", inputs.set);
  at("calibration_data_hash", inputs.calibration_data_hash);
  at.maybe("calibration_method", inputs.calibration_method);
  at("calibration_result", inputs.calibration_result);
  at("diagnosis_result", inputs.diagnosis_result);
  at("validation_session", inputs.validation_session);
  at.maybe("positions_by", inputs.positions_by);
  at("rig_hash", inputs.rig_hash);
  at("data_hash", inputs.data_hash);
  at("version", inputs.version);
}

template <class Fields>
void describe_keys(Fields& at, Of<Fields, studies::ValidationResult>& result) {
  at.constant("schema", kSchema);
  if constexpr (!Fields::kReads) at("schema_version", studies::kValidationSchemaVersion);
  at("created_utc", result.created_utc);
  at("inputs", result.inputs);
  at("methods", result.methods);
  at("points", result.points);
  at("troubles", result.troubles);
}

Json to_json(const studies::ValidationResult& result) {
  Json json = write(result);
  for (std::size_t i = 0; i < result.methods.size(); ++i) {
    json["methods"][i]["name"] =
        compensation_name(result.methods[i].by, result.inputs.calibration_method);
  }
  return json;
}

studies::ValidationResult validation_from_json(const Json& json) {
  expect_schema(
      json, kSchema, studies::kValidationSchemaVersion, studies::kValidationSchemaVersion,
      "Validate again: sixdial validate.");
  return read<studies::ValidationResult>(json, kSchema);
}

std::vector<studies::NotMeasured> not_measured_from_json(const Json& json) {
  return read<std::vector<studies::NotMeasured>>(json, "troubles");
}

}  // namespace sixdial::report
