// The document "sixdial.comparison": doc/schemas/comparison.json.
#pragma once

#include "report/documents/json.h"
#include "studies/compare.h"

namespace sixdial::report {

[[nodiscard]] Json to_json(const studies::ComparisonResult& result);
/// Throws studies::StudyError bad_data: another schema or version, or it names the key which is
/// missing or of the wrong kind.
[[nodiscard]] studies::ComparisonResult comparison_from_json(const Json& json);

}  // namespace sixdial::report
