// The report as JSON, for programs. Units are in the keys; numbers in full; unknown is null.
#pragma once

#include <string>

#include "report/report_data.h"

namespace sixdial::report {

inline constexpr int kJsonSchemaVersion = 1;

/// One object: schema "sixdial.report", schema_version, head, state, table2, table6,
/// residual_by, residual_by_dial, points, convergence, parameters_by_iteration, identification,
/// data_quality, sections.
[[nodiscard]] std::string json_report(const ReportData& data);

}  // namespace sixdial::report
