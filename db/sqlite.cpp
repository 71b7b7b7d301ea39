#include "db/sqlite.h"

#include <utility>

namespace sixdial::db {
namespace {

constexpr int kBusyWait_ms = 5000;

struct Words {
  StoreTrouble trouble;
  const char* hint;
};

Words words_for(int code) {
  switch (code & 0xFF) {
    case SQLITE_FULL:
      return {StoreTrouble::kDiskFull, "nothing of this step was stored; make room, try again"};
    case SQLITE_IOERR:
      return {
          StoreTrouble::kDiskFailed,
          "what was acknowledged before is kept; check the disk, then start again"};
    case SQLITE_CORRUPT:
      return {
          StoreTrouble::kCorrupt,
          "keep the file as it is and go on with a copy made by backup"};
    case SQLITE_NOTADB:
      return {StoreTrouble::kNotOurs, "give the path of a Sixdial database or of a new file"};
    case SQLITE_BUSY:
    case SQLITE_LOCKED:
      return {StoreTrouble::kLocked, "another program has the database open; close it"};
    case SQLITE_READONLY:
      return {StoreTrouble::kReadOnly, "check the rights on the file and its folder"};
    case SQLITE_CANTOPEN:
    case SQLITE_PERM:
      return {StoreTrouble::kCannotOpen, "check the path and the rights on it"};
    case SQLITE_CONSTRAINT:
      return {StoreTrouble::kRefused, ""};
    default:
      return {StoreTrouble::kOther, ""};
  }
}

}  // namespace

Database::Database(const std::string& path, Mode mode, const std::string& vfs) : path_(path) {
  const int flags = (mode == Mode::kReadOnly ? SQLITE_OPEN_READONLY
                                             : SQLITE_OPEN_READWRITE | SQLITE_OPEN_CREATE) |
                    SQLITE_OPEN_NOMUTEX | SQLITE_OPEN_EXRESCODE;
  sqlite3* handle = nullptr;
  const int code =
      sqlite3_open_v2(path.c_str(), &handle, flags, vfs.empty() ? nullptr : vfs.c_str());
  handle_.reset(handle);
  if (code != SQLITE_OK) fail(code, "cannot be opened");
  sqlite3_busy_timeout(handle, kBusyWait_ms);
}

void Database::fail(int code, const std::string& doing) const {
  const Words words = words_for(code);
  const char* said = handle_ ? sqlite3_errmsg(handle_.get()) : sqlite3_errstr(code);
  throw StoreError(words.trouble, path_, doing + ": " + said, words.hint, code);
}

void Database::execute(const std::string& sql) {
  const int code = sqlite3_exec(handle_.get(), sql.c_str(), nullptr, nullptr, nullptr);
  if (code != SQLITE_OK) fail(code, "a step failed");
}

std::int64_t Database::number(const std::string& sql) {
  Statement statement(*this, sql);
  return statement.step() ? statement.number(0) : 0;
}

std::string Database::text(const std::string& sql) {
  Statement statement(*this, sql);
  return statement.step() ? statement.text(0) : "";
}

std::int64_t Database::last_row_id() const { return sqlite3_last_insert_rowid(handle_.get()); }
int Database::changed_rows() const { return sqlite3_changes(handle_.get()); }
bool Database::in_transaction() const { return sqlite3_get_autocommit(handle_.get()) == 0; }

Statement::Statement(Database& database, std::string_view sql) : database_(database) {
  sqlite3_stmt* handle = nullptr;
  const int code = sqlite3_prepare_v2(
      database.handle(), sql.data(), static_cast<int>(sql.size()), &handle, nullptr);
  handle_.reset(handle);
  check(code, "a query cannot be prepared");
}

void Statement::check(int code, const char* doing) {
  if (code != SQLITE_OK) database_.fail(code, doing);
}

bool Statement::step() {
  const int code = sqlite3_step(handle_.get());
  if (code == SQLITE_ROW) return true;
  if (code == SQLITE_DONE) return false;
  // The message must be read before the reset that lets the transaction end.
  try {
    database_.fail(code, "a step failed");
  } catch (...) {
    sqlite3_reset(handle_.get());
    throw;
  }
}

void Statement::run() {
  while (step()) {
  }
  reset();
}

void Statement::reset() {
  sqlite3_reset(handle_.get());
  sqlite3_clear_bindings(handle_.get());
}

bool Statement::is_null(int column) const {
  return sqlite3_column_type(handle_.get(), column) == SQLITE_NULL;
}
std::int64_t Statement::number(int column) const {
  return sqlite3_column_int64(handle_.get(), column);
}
int Statement::integer(int column) const { return sqlite3_column_int(handle_.get(), column); }
double Statement::real(int column) const {
  return sqlite3_column_double(handle_.get(), column);
}

std::string Statement::text(int column) const {
  const auto* bytes = static_cast<const char*>(sqlite3_column_blob(handle_.get(), column));
  const int size = sqlite3_column_bytes(handle_.get(), column);
  return bytes == nullptr ? std::string() : std::string(bytes, static_cast<std::size_t>(size));
}

std::optional<int> Statement::integer_or_none(int column) const {
  return is_null(column) ? std::nullopt : std::optional(integer(column));
}
std::optional<double> Statement::real_or_none(int column) const {
  return is_null(column) ? std::nullopt : std::optional(real(column));
}
std::optional<std::string> Statement::text_or_none(int column) const {
  return is_null(column) ? std::nullopt : std::optional(text(column));
}

void Statement::bind_one(int place, std::int64_t value) {
  check(sqlite3_bind_int64(handle_.get(), place, value), "a value cannot be bound");
}
void Statement::bind_one(int place, int value) { bind_one(place, std::int64_t{value}); }
void Statement::bind_one(int place, double value) {
  check(sqlite3_bind_double(handle_.get(), place, value), "a value cannot be bound");
}
void Statement::bind_one(int place, std::string_view value) {
  check(
      sqlite3_bind_text64(
          handle_.get(), place, value.data() == nullptr ? "" : value.data(), value.size(),
          SQLITE_TRANSIENT, SQLITE_UTF8),
      "a value cannot be bound");
}
void Statement::bind_one(int place, const std::string& value) {
  bind_one(place, std::string_view(value));
}
void Statement::bind_one(int place, const char* value) {
  bind_one(place, std::string_view(value));
}
void Statement::bind_one(int place, std::nullptr_t) {
  check(sqlite3_bind_null(handle_.get(), place), "a value cannot be bound");
}

Transaction::Transaction(Database& database) : database_(database) {
  database_.execute("BEGIN IMMEDIATE");
}

Transaction::~Transaction() {
  // SQLite has rolled back by itself after some errors.
  if (!open_ || !database_.in_transaction()) return;
  sqlite3_exec(database_.handle(), "ROLLBACK", nullptr, nullptr, nullptr);
}

void Transaction::commit() {
  database_.execute("COMMIT");
  open_ = false;
}

}  // namespace sixdial::db
