// The numbered steps from an empty file to today's schema, embedded from db/migrations/*.sql.
#pragma once

#include <vector>

namespace sixdial::db {

class Database;

struct Migration {
  int number;  // 1, 2, ...; the schema's version after it
  const char* name;
  const char* sql;
};

[[nodiscard]] const std::vector<Migration>& migrations();
[[nodiscard]] int newest_schema();

/// Brings the schema from its version up to `target` in one transaction: where a step fails,
/// the file stays as it was. Returns the version before. Throws StoreError for a newer schema
/// than this program's.
int migrate(Database& database, int target = newest_schema());

/// "SXDL" in the file's header says that it is Sixdial's.
inline constexpr int kApplicationId = 0x5358444C;

}  // namespace sixdial::db
