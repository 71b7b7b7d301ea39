// The document "sixdial.calibration": doc/schemas/calibration.json.
//
// Results of the paper's method are documents of version 1, as they always were. Those of any
// other method lack "anfis" and "noise" and may have "residual_model": version 2, so that a
// reader of version 1 refuses them.
//
// Example:
//   const studies::CalibrationResult result = studies::calibrate(session, {.method = "lm"});
//   const Json document = to_json(result);  // "sixdial.calibration"
//   to_json(calibration_from_json(document));  // -> document
#pragma once

#include "report/documents/json.h"
#include "studies/calibration_result.h"

namespace sixdial::report {

inline constexpr int kCalibrationSchemaVersion = 1;
inline constexpr int kAnyMethodSchemaVersion = 2;

[[nodiscard]] Json to_json(const studies::CalibrationResult& result);

/// Throws studies::StudyError bad_data: another schema or version, or it names the key which is
/// missing or of the wrong kind.
[[nodiscard]] studies::CalibrationResult calibration_from_json(const Json& json);

/// "settings" of its "inputs".
[[nodiscard]] Json settings_json(const calibration::PipelineSettings& settings);

}  // namespace sixdial::report
