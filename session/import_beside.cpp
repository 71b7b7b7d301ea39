// Several tables as one: their columns beside each other.
#include <fmt/format.h>

#include <algorithm>
#include <iterator>

#include "session/data_error.h"
#include "session/import_table.h"

namespace sixdial::session {
namespace {

/// Units and decimal marks of columns that the table has not got yet are filled in.
void fill_by_column(ImportTable& all, const ImportTable& next) {
  const std::size_t before = all.names.size();
  const std::size_t now = before + next.names.size();
  if (!all.units.empty() || !next.units.empty()) {
    all.units.resize(before);
    std::ranges::copy(next.units, std::back_inserter(all.units));
    all.units.resize(now);
  }
  if (!all.decimals.empty() || next.decimal != all.decimal) {
    all.decimals.resize(before, all.decimal);
    all.decimals.resize(now, next.decimal);
  }
}

}  // namespace

ImportTable beside(std::vector<ImportTable> tables) {
  ImportTable all = std::move(tables.front());
  for (std::size_t t = 1; t < tables.size(); ++t) {
    ImportTable& next = tables[t];
    if (next.rows.size() != all.rows.size()) {
      throw DataError(
          next.file,
          Mistake{
              0, 0, "",
              fmt::format(
                  "has {} rows, {} has {}", next.rows.size(), all.file, all.rows.size()),
              "files side by side need the same rows"});
    }
    fill_by_column(all, next);
    for (const std::string& name : next.names) {
      const bool taken = std::ranges::find(all.names, name) != all.names.end();
      all.names.push_back(taken ? fmt::format("{}:{}", t + 1, name) : name);
    }
    for (std::size_t i = 0; i < all.rows.size(); ++i) {
      std::ranges::move(next.rows[i], std::back_inserter(all.rows[i]));
    }
    for (const std::string& note : next.notes) all.notes.push_back(next.file + ": " + note);
  }
  return all;
}

}  // namespace sixdial::session
