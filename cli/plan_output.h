// What the plan commands share: how a plan is given out, and the commands of files of their
// own.
#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include "cli/cli.h"

namespace sixdial::cli {

/// The plan to its file or to stdout, or in `answer` as JSON; `notes` to stderr.
service::ExitCode write_plan(
    Cli& cli, const std::string& output, const std::string& plan_csv, std::size_t points,
    const std::vector<std::string>& notes, Json answer);

/// sixdial plan sockets
void add_sockets_command(CLI::App& group, Cli& cli);

}  // namespace sixdial::cli
