// The command line told by itself: a man page and a completion for bash, from the table of its
// commands.
#pragma once

#include <CLI/CLI.hpp>
#include <string>

namespace sixdial::cli {

/// roff of section 1 or 8. `talks_to_service`: socket and database are among its files.
[[nodiscard]] std::string manual_page(
    const CLI::App& app, int section, bool talks_to_service = true);
[[nodiscard]] std::string bash_completion(const CLI::App& app);

}  // namespace sixdial::cli
