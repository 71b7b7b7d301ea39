// The report as one HTML file that needs nothing else: no network, no font, no script to be
// read.
#pragma once

#include <string>

#include "report/report_data.h"

namespace sixdial::report {

struct HtmlOptions {
  bool charts = true;  // carry the chart libraries, if this build has them
};

/// A whole HTML5 document. Charts are drawn by the libraries it carries; where no script runs,
/// or without the libraries, each figure shows its table.
[[nodiscard]] std::string html_report(const ReportData& data, const HtmlOptions& options = {});

/// True if this build carries the chart libraries.
[[nodiscard]] bool has_chart_libraries();

}  // namespace sixdial::report
