// The report as one HTML file that needs nothing else: no network, no font, no script to be
// read.
#pragma once

#include <string>

#include "report/report_data.h"

namespace sixdial::report {

/// A whole HTML5 document. Charts are drawn by the libraries it carries; without JavaScript, or
/// if the program was built without the libraries, each figure shows its table.
[[nodiscard]] std::string html_report(const ReportData& data);

/// True if this build carries the chart libraries.
[[nodiscard]] bool has_chart_libraries();

}  // namespace sixdial::report
