// SQLite with owners: a connection, a statement, a transaction; every failure is a StoreError.
// One thread at a time.
#pragma once

#include <sqlite3.h>

#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <string_view>

#include "db/store_error.h"

namespace sixdial::db {

class Database {
 public:
  enum class Mode { kReadWrite, kReadOnly };

  /// Opens, or with kReadWrite creates. `vfs`: SQLite's name of a file system; empty: the
  /// usual.
  Database(const std::string& path, Mode mode, const std::string& vfs = "");

  void execute(const std::string& sql);
  /// First column of the first row of a query, as a number or text.
  [[nodiscard]] std::int64_t number(const std::string& sql);
  [[nodiscard]] std::string text(const std::string& sql);

  [[nodiscard]] std::int64_t last_row_id() const;
  [[nodiscard]] int changed_rows() const;
  [[nodiscard]] bool in_transaction() const;
  [[nodiscard]] const std::string& path() const { return path_; }
  [[nodiscard]] sqlite3* handle() { return handle_.get(); }

  /// Throws the connection's last error in words.
  [[noreturn]] void fail(int code, const std::string& doing) const;

 private:
  struct Close {
    void operator()(sqlite3* handle) const { sqlite3_close_v2(handle); }
  };
  std::string path_;
  std::unique_ptr<sqlite3, Close> handle_;
};

/// A prepared statement. Parameters count from 1, columns from 0. Must not outlive its
/// database.
class Statement {
 public:
  Statement(Database& database, std::string_view sql);

  template <typename... Values>
  Statement& bind(const Values&... values) {
    int place = 0;
    (bind_one(++place, values), ...);
    return *this;
  }

  /// True: there is a row to read.
  bool step();
  /// Steps to the end and makes the statement ready for the next values.
  void run();
  void reset();

  [[nodiscard]] bool is_null(int column) const;
  [[nodiscard]] std::int64_t number(int column) const;
  [[nodiscard]] int integer(int column) const;
  [[nodiscard]] double real(int column) const;
  [[nodiscard]] std::string text(int column) const;
  [[nodiscard]] std::optional<int> integer_or_none(int column) const;
  [[nodiscard]] std::optional<double> real_or_none(int column) const;
  [[nodiscard]] std::optional<std::string> text_or_none(int column) const;

 private:
  void bind_one(int place, std::int64_t value);
  void bind_one(int place, int value);
  void bind_one(int place, double value);
  void bind_one(int place, const std::string& value);
  void bind_one(int place, std::string_view value);
  void bind_one(int place, const char* value);
  void bind_one(int place, std::nullptr_t);
  template <typename T>
  void bind_one(int place, const std::optional<T>& value) {
    value ? bind_one(place, *value) : bind_one(place, nullptr);
  }
  void check(int code, const char* doing);

  struct Finalize {
    void operator()(sqlite3_stmt* statement) const { sqlite3_finalize(statement); }
  };
  Database& database_;
  std::unique_ptr<sqlite3_stmt, Finalize> handle_;
};

/// BEGIN IMMEDIATE ... COMMIT; rolls back unless committed.
class Transaction {
 public:
  explicit Transaction(Database& database);
  ~Transaction();
  Transaction(const Transaction&) = delete;
  Transaction& operator=(const Transaction&) = delete;
  /// Returns when the data is on the disk.
  void commit();

 private:
  Database& database_;
  bool open_ = true;
};

}  // namespace sixdial::db
