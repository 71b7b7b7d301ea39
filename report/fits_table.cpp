// One place for a parameter's value by every fit that a report speaks of.
#include <algorithm>

#include "report/expanded.h"
#include "report/tables.h"
#include "report/text.h"

namespace sixdial::report {

Table fits_table(const ReportData& data) {
  Table t{.id = "fits", .caption = "The robot's parameters by each fit"};
  t.columns = {column("parameter", "parameter"), column("unit", "unit")};
  int decimals = 3;
  for (const Fit& fit : data.facts.fits) {
    t.columns.push_back(column(fit.key, "value", "", fit.name));
    t.columns.push_back(expanded_column(fit.key + "_sd", "", fit.name));
    for (const auto& sd : fit.sd) {
      if (sd) decimals = std::max(decimals, decimals_for(geometry::kCoverage * *sd));
    }
  }
  for (std::size_t i = 0; i < data.parameters.size(); ++i) {
    std::vector<Cell> row{symbol(data.parameters[i].name), data.parameters[i].unit};
    for (const Fit& fit : data.facts.fits) {
      row.push_back(i < fit.value.size() ? number(fit.value[i], decimals) : Cell{});
      row.push_back(i < fit.sd.size() ? expanded(fit.sd[i], decimals) : Cell{});
    }
    t.rows.push_back(std::move(row));
  }
  t.notes.emplace_back(
      "\"Identified\" is the result of this report. The fits of the diagnosis take the raw "
      "readings of all dials; without the causes they bend the parameters to make up for them. "
      "Fits of other data, or with other causes, agree within their U only where nothing is "
      "left "
      "that the model lacks.");
  return t;
}

}  // namespace sixdial::report
