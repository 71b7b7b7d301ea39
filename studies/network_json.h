// A trained ANFIS as JSON: saved with a calibration's result, loaded to compensate, shown in
// the report. What is loaded gives the same output as what was saved, bit for bit.
#pragma once

#include <vector>

#include "calibration/anfis_learning.h"
#include "studies/error.h"
#include "studies/json.h"

namespace sixdial::studies {

[[nodiscard]] Json network_json(const calibration::AnfisReport& report);

/// Throws Error bad_data where the document is not a whole network: what is missing or does not
/// fit.
[[nodiscard]] calibration::AnfisModel network_from(const Json& json);

}  // namespace sixdial::studies
