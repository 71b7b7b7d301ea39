// What `sixdial doctor` looks at: one line for each thing that must be well, and what to do
// where it is not. Changes nothing; needs no service.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "service/error.h"

namespace sixdial::cli {

enum class Health { kOk, kWarning, kFailed };

struct Check {
  std::string name;  // "socket", "database", ...
  Health health = Health::kOk;
  std::string what;                                      // what was found
  std::string fix;                                       // empty if well
  service::ExitCode exit_code = service::ExitCode::kOk;  // of the command, where this one fails
};

/// Adapters and their rights.
[[nodiscard]] std::vector<Check> check_ports(const std::filesystem::path& by_id);
/// Whether a service answers, and why not.
[[nodiscard]] Check check_socket(const std::filesystem::path& socket_path);
/// Schema, integrity; or that one can be made there.
[[nodiscard]] Check check_database(const std::filesystem::path& path);
/// Room where the database is, and how long a synced write takes.
[[nodiscard]] Check check_disk(const std::filesystem::path& database);
/// A robot whose parameters are known, measured without error, is found again.
[[nodiscard]] Check check_known_answer();

}  // namespace sixdial::cli
