// The order of a report's page: which tables and figures stand under which heading.
#pragma once

#include <vector>

#include "report/report_data.h"

namespace sixdial::report {

/// Everything under the state of the robot, in reading order; `data.sections` come before the
/// annex.
[[nodiscard]] std::vector<Section> sections_of(const ReportData& data);

}  // namespace sixdial::report
