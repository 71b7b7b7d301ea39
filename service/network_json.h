// A trained ANFIS as JSON: saved with a calibration's result, loaded to compensate, shown in
// the report. What is loaded gives the same output as what was saved, bit for bit.
#pragma once

#include <vector>

#include "calibration/anfis_learning.h"
#include "report/document.h"
#include "service/error.h"

namespace sixdial::service {

[[nodiscard]] Json network_json(const calibration::AnfisReport& report);

/// Throws Error bad_data where the document is not a whole network: what is missing or does not
/// fit.
[[nodiscard]] calibration::AnfisModel network_from(const Json& json);

/// The report's section: size, effective parameters, sizes that were offered, membership
/// functions. `anfis`: {"x": network, "y": network}.
[[nodiscard]] std::vector<report::Section> anfis_sections(const Json& anfis);

}  // namespace sixdial::service
