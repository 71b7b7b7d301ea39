// The live estimate as it goes over the socket, in collect.status and its events.
#pragma once

#include "report/documents/json.h"
#include "studies/live_estimate.h"

namespace sixdial::report {

[[nodiscard]] Json to_json(const studies::EstimateSummary& estimate);
/// Throws studies::StudyError bad_data that names the key which is missing or of the wrong
/// kind.
[[nodiscard]] studies::EstimateSummary estimate_from_json(const Json& json);

}  // namespace sixdial::report
