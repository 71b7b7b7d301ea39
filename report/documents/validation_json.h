// The document "sixdial.validation": doc/schemas/validation.json.
#pragma once

#include <vector>

#include "report/documents/json.h"
#include "studies/validate.h"

namespace sixdial::report {

[[nodiscard]] Json to_json(const studies::ValidationResult& result);
/// Throws studies::StudyError bad_data: another schema or version, or it names the key which is
/// missing or of the wrong kind.
[[nodiscard]] studies::ValidationResult validation_from_json(const Json& json);

/// "troubles" of the validation and of a collection's status.
[[nodiscard]] std::vector<studies::NotMeasured> not_measured_from_json(const Json& json);

}  // namespace sixdial::report
