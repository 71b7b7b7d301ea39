#include <fmt/format.h>

#include "db/migrations.h"
#include "db/sqlite.h"

namespace sixdial::db {

int newest_schema() { return migrations().back().number; }

int migrate(Database& database, int target) {
  const auto application = database.number("PRAGMA application_id");
  const auto before = static_cast<int>(database.number("PRAGMA user_version"));
  const auto tables = database.number("SELECT count(*) FROM sqlite_schema");
  const bool empty = application == 0 && before == 0 && tables == 0;
  if (!empty && application != kApplicationId) {
    throw StoreError(
        StoreTrouble::kNotOurs, database.path(), "this is not a Sixdial database",
        "give the path of a Sixdial database or of a new file");
  }
  if (before > newest_schema()) {
    throw StoreError(
        StoreTrouble::kTooNew, database.path(),
        fmt::format(
            "the database has schema {}, this program knows up to {}", before, newest_schema()),
        "use the newer program that made it");
  }
  if (before >= target) return before;
  // All steps or none: a file is never left between two versions.
  Transaction transaction(database);
  if (before == 0) {
    database.execute(fmt::format("PRAGMA application_id = {}", kApplicationId));
  }
  for (const Migration& step : migrations()) {
    if (step.number > before && step.number <= target) database.execute(step.sql);
  }
  database.execute(fmt::format("PRAGMA user_version = {}", target));
  transaction.commit();
  return before;
}

}  // namespace sixdial::db
