// Warnings as JSON, for answers that carry nothing else of a result.
#pragma once

#include <optional>
#include <vector>

#include "report/documents/json.h"
#include "studies/plausibility.h"

namespace sixdial::report {

/// [{code, severity, message, where, place, parts}].
[[nodiscard]] Json warnings_json(const std::vector<studies::Warning>& warnings);
/// Those under "warnings" of an answer; none if it has no such key.
[[nodiscard]] std::vector<studies::Warning> warnings_in(const Json& answer);

/// Throws StudyError bad_data in words where a warning forbids to command the robot by a result
/// of this session.
void check_may_command(const std::vector<studies::Warning>& warnings);

}  // namespace sixdial::report
