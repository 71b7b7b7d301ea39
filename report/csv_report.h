// The tables of a report as CSV texts (RFC 4180, '\n' line ends, UTF-8, one header line with
// units in the names, numbers in full).
#pragma once

#include <string>
#include <vector>

#include "report/report_data.h"

namespace sixdial::report {

inline constexpr int kCsvSchemaVersion = 1;

struct CsvFile {
  std::string name{};  // "table6.csv"
  std::string text{};
};

/// schema.csv, table2.csv, table6.csv, points.csv, convergence.csv,
/// parameters_by_iteration.csv, and one file for each table of `data.sections`, named
/// <section>_<table>.csv.
[[nodiscard]] std::vector<CsvFile> csv_report(const ReportData& data);

[[nodiscard]] std::string to_csv(const Table& table);

}  // namespace sixdial::report
