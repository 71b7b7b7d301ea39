#include "db/store.h"

#include <fmt/format.h>
#include <unistd.h>

#include <chrono>
#include <cstdio>
#include <utility>

#include "db/migrations.h"
#include "db/sqlite.h"
#include "db/store_steps.h"
#include "db/writer_lock.h"

namespace sixdial::db {
namespace {

constexpr const char* kInMemory = ":memory:";

/// Sets a pragma and insists on what reading it back gives.
void set_and_read_back(
    Database& database, const std::string& name, const std::string& value,
    const std::string& expected) {
  database.execute(fmt::format("PRAGMA {} = {}", name, value));
  const std::string got = database.text(fmt::format("PRAGMA {}", name));
  if (got == expected) return;
  throw StoreError(
      StoreTrouble::kOther, database.path(),
      fmt::format("{} is {} where {} is needed", name, got, expected),
      "a database needs a local file system with locks and shared memory");
}

void harden(Database& database) {
  sqlite3_db_config(database.handle(), SQLITE_DBCONFIG_DEFENSIVE, 1, nullptr);
  set_and_read_back(database, "foreign_keys", "ON", "1");
  set_and_read_back(database, "trusted_schema", "OFF", "0");
  // REPLACE must not slip past the triggers that keep raw rows.
  set_and_read_back(database, "recursive_triggers", "ON", "1");
}

}  // namespace

std::string now_utc() {
  return session::to_iso8601(
      std::chrono::floor<std::chrono::milliseconds>(std::chrono::system_clock::now()));
}

Store::Store(
    std::string path, std::unique_ptr<Database> database, std::unique_ptr<WriterLock> lock)
    : path_(std::move(path)),
      lock_(std::move(lock)),
      database_(std::move(database)),
      mutex_(std::make_unique<std::mutex>()) {}

Store::~Store() = default;
Store::Store(Store&&) noexcept = default;

Store& Store::operator=(Store&& other) noexcept {
  database_.reset();  // before its lock
  path_ = std::move(other.path_);
  lock_ = std::move(other.lock_);
  database_ = std::move(other.database_);
  mutex_ = std::move(other.mutex_);
  read_only_ = other.read_only_;
  failed_ = std::move(other.failed_);
  rigs_ = std::move(other.rigs_);
  return *this;
}

Store Store::open(const std::string& path, const std::string& vfs) {
  const bool in_memory = path == kInMemory;
  auto lock = in_memory ? nullptr : std::make_unique<WriterLock>(path);
  auto database = std::make_unique<Database>(path, Database::Mode::kReadWrite, vfs);
  // A foreign or newer file is refused before anything in it is touched.
  migrate(*database, 0);
  if (!in_memory) set_and_read_back(*database, "journal_mode", "WAL", "wal");
  set_and_read_back(*database, "synchronous", "FULL", "2");
  harden(*database);
  migrate(*database);
  return {path, std::move(database), std::move(lock)};
}

Store Store::open_read_only(const std::string& path) {
  auto database = std::make_unique<Database>(path, Database::Mode::kReadOnly);
  migrate(*database, 0);
  const auto schema = static_cast<int>(database->number("PRAGMA user_version"));
  if (schema < newest_schema()) {
    throw StoreError(
        StoreTrouble::kTooOld, path,
        fmt::format(
            "the database has schema {}, this program reads schema {}", schema,
            newest_schema()),
        "open it for writing once (start the service), which brings it up to date");
  }
  harden(*database);
  Store store(path, std::move(database), nullptr);
  store.read_only_ = true;
  return store;
}

void Store::not_found(
    std::string_view missing, const std::string& what, const std::string& hint) const {
  StoreError error(StoreTrouble::kNotFound, path_, what, hint);
  error.missing = missing;
  throw error;
}

int Store::schema_version() {
  return reading([&] { return static_cast<int>(database_->number("PRAGMA user_version")); });
}

void Store::checkpoint() {
  const std::lock_guard lock(*mutex_);
  database_->execute("PRAGMA wal_checkpoint(TRUNCATE)");
}

std::vector<std::string> Store::check() {
  return reading([&] {
    std::vector<std::string> found;
    Statement integrity(*database_, "PRAGMA integrity_check");
    while (integrity.step()) {
      if (integrity.text(0) != "ok") found.push_back(integrity.text(0));
    }
    Statement keys(*database_, "PRAGMA foreign_key_check");
    while (keys.step()) {
      found.push_back(fmt::format(
          "row {} of {} refers to no row of {}", keys.number(1), keys.text(0), keys.text(2)));
    }
    return found;
  });
}

void Store::backup(const std::string& path) {
  constexpr int kPagesAtATime = 256;  // 1 MB: a sample waits no longer than that
  if (::access(path.c_str(), F_OK) == 0) {
    throw StoreError(
        StoreTrouble::kRefused, path, "the file exists already",
        "choose another name for the copy");
  }
  const std::string beside = path + ".part";
  std::remove(beside.c_str());
  try {
    Database copy(beside, Database::Mode::kReadWrite);
    sqlite3_backup* running = nullptr;
    {
      const std::lock_guard lock(*mutex_);
      running = sqlite3_backup_init(copy.handle(), "main", database_->handle(), "main");
    }
    if (running == nullptr) copy.fail(sqlite3_errcode(copy.handle()), "the copy cannot begin");
    int code = SQLITE_OK;
    while (code == SQLITE_OK) {
      const std::lock_guard lock(*mutex_);
      code = sqlite3_backup_step(running, kPagesAtATime);
    }
    {
      const std::lock_guard lock(*mutex_);
      sqlite3_backup_finish(running);
    }
    if (code != SQLITE_DONE) copy.fail(code, "the copy stopped");
    copy.execute("PRAGMA journal_mode = DELETE");  // one file, no log beside it
  } catch (...) {
    std::remove(beside.c_str());
    throw;
  }
  if (std::rename(beside.c_str(), path.c_str()) != 0) {
    std::remove(beside.c_str());
    throw StoreError(
        StoreTrouble::kCannotOpen, path, "the copy cannot be given its name",
        "check the rights on the folder");
  }
}

void Store::record_action(
    const Operator& who, const std::string& action, std::optional<SessionId> session,
    const std::string& detail) {
  writing([&] {
    std::optional<std::int64_t> id;
    if (session) id = session->value;
    Statement(
        *database_,
        "INSERT INTO actions (time_utc, operator, operator_uid, operator_pid, action, "
        "session_id, detail) VALUES (?, ?, ?, ?, ?, ?, ?)")
        .bind(now_utc(), who.name, who.uid, who.pid, action, id, detail)
        .run();
  });
}

std::vector<ActionRecord> Store::list_actions(int most) {
  return reading([&] {
    std::vector<ActionRecord> actions;
    Statement query(
        *database_,
        "SELECT time_utc, operator, operator_uid, operator_pid, action, session_id, detail "
        "FROM (SELECT * FROM actions ORDER BY id DESC LIMIT ?) ORDER BY id");
    query.bind(most);
    while (query.step()) {
      ActionRecord action;
      action.time_utc = query.text(0);
      action.who = {query.text(1), query.integer_or_none(2), query.integer_or_none(3)};
      action.action = query.text(4);
      if (!query.is_null(5)) action.session = SessionId{query.number(5)};
      action.detail = query.text(6);
      actions.push_back(std::move(action));
    }
    return actions;
  });
}

}  // namespace sixdial::db
