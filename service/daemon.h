// The program `sixdiald`: options, log, signals, and the exit codes of its life.
#pragma once

#include <filesystem>
#include <functional>
#include <ostream>
#include <string>

namespace CLI {
class App;
}

namespace sixdial::service {

/// $STATE_DIRECTORY (systemd), else $XDG_DATA_HOME/sixdial, else ~/.local/share/sixdial, else
/// /var/lib/sixdial; the file sixdial.db there.
[[nodiscard]] std::filesystem::path default_database_path();

/// Writes a program's man page from its options.
using ManualPage = std::function<std::string(const CLI::App& app)>;

/// Serves until SIGTERM, SIGINT or a client's shutdown. Returns the exit code.
[[nodiscard]] int run_daemon(
    int argc, const char* const* argv, std::ostream& out, std::ostream& err,
    const ManualPage& manual_page);

}  // namespace sixdial::service
