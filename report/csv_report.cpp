#include "report/csv_report.h"

#include <fmt/format.h>

#include "report/figures.h"
#include "report/tables.h"
#include "report/text.h"

namespace sixdial::report {
namespace {

std::string field(const Cell& cell) {
  if (const auto* text = std::get_if<std::string>(&cell)) return csv_field(*text);
  if (const auto* n = std::get_if<Number>(&cell)) return exact(n->value);
  return {};
}

const Table* table_in(const Block& block) {
  if (const auto* t = std::get_if<Table>(&block)) return t;
  if (const auto* f = std::get_if<Figure>(&block)) return &f->table;
  return nullptr;
}

}  // namespace

std::string to_csv(const Table& table) {
  std::string out;
  for (std::size_t c = 0; c < table.columns.size(); ++c) {
    if (c > 0) out += ',';
    out += csv_field(table.columns[c].key);
  }
  out += '\n';
  for (const std::vector<Cell>& row : table.rows) {
    for (std::size_t c = 0; c < table.columns.size(); ++c) {
      if (c > 0) out += ',';
      if (c < row.size()) out += field(row[c]);
    }
    out += '\n';
  }
  return out;
}

std::vector<CsvFile> csv_report(const ReportData& data) {
  std::vector<CsvFile> out;
  out.push_back(
      {"schema.csv", fmt::format(
                         "schema,schema_version,session,software_version,data_hash,rig_hash\n"
                         "sixdial.report.csv,{},{},{},{},{}\n",
                         kCsvSchemaVersion, csv_field(data.head.session_name),
                         csv_field(data.head.software_version), csv_field(data.head.data_hash),
                         csv_field(data.head.rig_hash))});
  for (const Table& table :
       {parameter_table(data, true), accuracy_table(data, true), points_table(data),
        convergence_table(data, false), trace_table(data, false)}) {
    out.push_back({table.id + ".csv", to_csv(table)});
  }
  if (data.facts.fits.size() > 1) out.push_back({"fits.csv", to_csv(fits_table(data))});
  if (const auto by = residual_by(data)) out.push_back({"residual_by.csv", to_csv(by->table)});
  if (const Table dials = dial_table(data); !dials.rows.empty()) {
    out.push_back({"residual_by_dial.csv", to_csv(dials)});
  }
  for (const Section& section : data.sections) {
    for (const Block& block : section.blocks) {
      if (const Table* table = table_in(block)) {
        out.push_back(
            {fmt::format("{}_{}.csv", key_of(section.id), key_of(table->id)), to_csv(*table)});
      }
    }
  }
  return out;
}

}  // namespace sixdial::report
