// What went wrong with the database: where, what, and what to do.
#pragma once

#include <stdexcept>
#include <string>
#include <utility>

namespace sixdial::db {

enum class StoreTrouble {
  kCannotOpen,    // no such file, no rights
  kNotOurs,       // not a Sixdial database, or not a database
  kTooNew,        // made by a newer program
  kTooOld,        // a reader cannot migrate
  kLocked,        // another process writes it
  kNotFound,      // no such session, job, result
  kNameTaken,     // a session of that name exists
  kAlreadyThere,  // this set, point and repeat is measured
  kRefused,       // the data breaks a rule of the store
  kReadOnly,      // opened for reading
  kDiskFull,      // nothing was written; more space helps
  kDiskFailed,    // a write or sync failed: the store takes no more until opened again
  kCorrupt,       // the file is damaged
  kOther,
};

/// what(): "path: problem; hint".
class StoreError : public std::runtime_error {
 public:
  StoreError(
      StoreTrouble trouble_of, std::string path_of, std::string problem_of, std::string hint_of,
      int code = 0)
      : std::runtime_error(
            path_of + ": " + problem_of + (hint_of.empty() ? std::string() : "; " + hint_of)),
        trouble(trouble_of),
        path(std::move(path_of)),
        problem(std::move(problem_of)),
        hint(std::move(hint_of)),
        sqlite_code(code) {}

  StoreTrouble trouble;
  std::string path;
  std::string problem;
  std::string hint;
  int sqlite_code;        // extended result code; 0: not from SQLite
  std::string missing{};  // of kNotFound: "session", "job", "result", "sample"
};

}  // namespace sixdial::db
