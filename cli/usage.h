// What a person typed wrong: said in words, with the nearest name and the next command to type.
#pragma once

#include <CLI/CLI.hpp>

#include "service/error.h"

namespace sixdial::cli {

/// An error object (code invalid_params) for what the parser of `app` refused.
[[nodiscard]] Json usage_error(const CLI::App& app, const CLI::ParseError& error);
/// The service's hints name its methods; here the commands that call them, with the session of
/// the error.
[[nodiscard]] Json in_commands(Json error_object);

}  // namespace sixdial::cli
