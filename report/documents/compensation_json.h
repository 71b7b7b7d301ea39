// The document "sixdial.compensation": doc/schemas/compensation.json.
#pragma once

#include "report/documents/json.h"
#include "studies/compensate.h"

namespace sixdial::report {

/// The document without schema and version; the caller adds these.
[[nodiscard]] Json to_json(const studies::CommandedTarget& commanded);
/// Throws studies::StudyError bad_data: it names the key which is missing or of the wrong kind.
[[nodiscard]] studies::CommandedTarget commanded_target_from_json(const Json& json);

}  // namespace sixdial::report
