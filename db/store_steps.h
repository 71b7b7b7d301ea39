// The two ways a Store touches its file, shared by its sources.
#pragma once

#include <mutex>
#include <string>

#include "db/sqlite.h"
#include "db/store.h"
#include "session/session.h"

namespace sixdial::db {

template <typename Step>
auto Store::writing(Step step) {
  const std::lock_guard lock(*mutex_);
  if (read_only_) {
    throw StoreError(
        StoreTrouble::kReadOnly, path_, "the database was opened for reading only",
        "open it for writing");
  }
  if (!failed_.empty()) {
    throw StoreError(
        StoreTrouble::kDiskFailed, path_, "an earlier step failed (" + failed_ + ")",
        "what was acknowledged before is kept; check the disk, then start again");
  }
  try {
    Transaction transaction(*database_);
    if constexpr (std::is_void_v<decltype(step())>) {
      step();
      transaction.commit();
    } else {
      auto result = step();
      transaction.commit();
      return result;
    }
  } catch (const StoreError& error) {
    // After a failed sync nobody knows what the disk holds: stop, and say so from now on.
    const bool lost_trust =
        error.trouble == StoreTrouble::kDiskFailed || error.trouble == StoreTrouble::kCorrupt;
    if (lost_trust) failed_ = error.problem;
    throw;
  }
}

template <typename Step>
auto Store::reading(Step step) {
  const std::lock_guard lock(*mutex_);
  database_->execute("BEGIN");
  struct End {
    Database& database;
    ~End() { sqlite3_exec(database.handle(), "COMMIT", nullptr, nullptr, nullptr); }
  } end{*database_};
  return step();
}

/// One coordinate of a point; empty: there is no point, or it has fewer.
[[nodiscard]] std::optional<double> coordinate(
    const std::optional<session::Position>& point, int axis);
/// A position from a row's columns x, y and z, which stand at `x_column` and after it. Columns
/// at the end may be null; empty if x is null.
[[nodiscard]] std::optional<session::Position> point_from(const Statement& row, int x_column);

/// The clock as ISO 8601 UTC with milliseconds.
[[nodiscard]] std::string now_utc();

}  // namespace sixdial::db
