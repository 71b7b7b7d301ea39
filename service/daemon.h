// The program `sixdiald`: options, log, signals, and the exit codes of its life.
#pragma once

#include <filesystem>
#include <ostream>

namespace sixdial::service {

/// $STATE_DIRECTORY (systemd), else $XDG_DATA_HOME/sixdial, else ~/.local/share/sixdial, else
/// /var/lib/sixdial; the file sixdial.db there.
[[nodiscard]] std::filesystem::path default_database_path();

/// Serves until SIGTERM, SIGINT or a client's shutdown. Returns the exit code.
[[nodiscard]] int run_daemon(
    int argc, const char* const* argv, std::ostream& out, std::ostream& err);

}  // namespace sixdial::service
