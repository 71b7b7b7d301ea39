#include "cli/cli.h"

#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstdlib>
#include <exception>
#include <iostream>
#include <sstream>
#include <string_view>
#include <system_error>
#include <vector>

#include "cli/usage.h"
#include "service/methods/method.h"
#include "service/socket/server.h"
#include "session/bundle.h"
#include "session/csv.h"

namespace sixdial::cli {
namespace {

constexpr const char* kAbout =
    "Six dial indicators to a calibrated five-bar robot.\n"
    "Data go to stdout, everything else to stderr. Exit codes: 0 ok, 1 failed, 2 usage, 3 "
    "service "
    "unreachable,\n4 device, 5 data quality, 6 cancelled, 130 interrupted.";

bool colour_wanted() {
  const char* no_colour = std::getenv("NO_COLOR");
  return no_colour == nullptr || *no_colour == '\0';
}

int code(service::ExitCode exit_code) { return static_cast<int>(exit_code); }

}  // namespace

service::Client& Cli::client() {
  if (!client_) {
    client_ = std::make_unique<service::Client>(
        socket_path.empty() ? service::default_socket_path()
                            : std::filesystem::path(socket_path));
  }
  return *client_;
}

namespace {

/// What was printed is out, or the command has failed: a full disk, a closed pipe.
service::ExitCode after_output(Cli& cli, service::ExitCode so_far) {
  errno = 0;
  cli.console.out.flush();
  if (cli.console.out) return so_far;
  cli.console.json = false;  // nobody reads it
  const std::string why = errno == 0 ? "" : ": " + std::generic_category().message(errno);
  cli.console.error(service::to_error_object(std::make_exception_ptr(service::Error(
      service::ErrorCode::kFile, "the output could not be written whole" + why, {},
      "Make room, or send it elsewhere."))));
  return so_far == service::ExitCode::kOk ? service::ExitCode::kFailed : so_far;
}

/// All commands and their options.
void add_commands(CLI::App& app, Cli& cli) {
  app.require_subcommand(1);
  app.fallthrough();
  app.set_version_flag("--version", SIXDIAL_VERSION);
  app.add_option("--socket", cli.socket_path, "the service's socket")
      ->envname("SIXDIAL_SOCKET");
  app.add_flag("--json", cli.console.json, "one line of JSON with a schema version on stdout");
  app.add_flag("-q,--quiet", cli.console.quiet, "no progress on stderr");
  add_session_commands(app, cli);
  add_plan_commands(app, cli);
  add_collect_command(app, cli);
  add_dials_command(app, cli);
  add_robot_commands(app, cli);
  add_calibrate_command(app, cli);
  add_compare_command(app, cli);
  add_diagnose_command(app, cli);
  add_report_command(app, cli);
  add_rig_commands(app, cli);
  add_recommend_command(app, cli);
  add_import_command(app, cli);
  add_compensate_command(app, cli);
  add_validate_command(app, cli);
  add_export_command(app, cli);
  add_job_commands(app, cli);
  add_doctor_commands(app, cli);
  add_service_commands(app, cli);
}

}  // namespace

std::optional<ParseTrouble> parse_trouble(const std::vector<std::string>& words) {
  std::ostringstream nowhere;
  Cli cli(nowhere, nowhere);
  CLI::App app{kAbout, "sixdial"};
  add_commands(app, cli);
  std::vector<std::string> reversed(words.rbegin(), words.rend());  // as CLI11 takes them
  try {
    app.parse(reversed);
  } catch (const CLI::ParseError& error) {
    if (error.get_exit_code() == 0) return std::nullopt;
    return ParseTrouble{error.get_name(), error.what()};
  }
  return std::nullopt;
}

int run(int argc, const char* const* argv, std::ostream& out, std::ostream& err) {
  Cli cli(out, err);
  CLI::App app{kAbout, "sixdial"};
  add_commands(app, cli);
  cli.console.terminal = &err == &std::cerr && ::isatty(STDERR_FILENO) != 0;
  cli.console.colour = cli.console.terminal && colour_wanted();
  cli.console.out_terminal = &out == &std::cout && ::isatty(STDOUT_FILENO) != 0;
  // "sixdial help plan" as "sixdial plan --help".
  std::vector<const char*> words(argv, argv + argc);
  if (words.size() > 1 && std::string_view(words[1]) == "help") {
    words.erase(words.begin() + 1);
    words.push_back("--help");
  }
  try {
    app.parse(static_cast<int>(words.size()), words.data());
  } catch (const CLI::ParseError& error) {
    if (error.get_exit_code() == 0) {  // help, version
      app.exit(error, out, err);
      return code(after_output(cli, service::ExitCode::kOk));
    }
    const auto last = argv + argc;
    cli.console.json = std::any_of(
        argv, last, [](const char* word) { return std::string_view(word) == "--json"; });
    cli.console.error(usage_error(app, error));
    return code(service::ExitCode::kUsage);
  }
  try {
    return code(after_output(cli, cli.action()));
  } catch (const service::Interrupted&) {
    cli.console.note("interrupted");
    return code(service::ExitCode::kInterrupted);
  } catch (...) {
    const Json error = in_commands(service::to_error_object(std::current_exception()));
    cli.console.error(error);
    return code(service::exit_code_of(error));
  }
}

std::string summary_of(std::string_view method) {
  return std::string(service::find_method(method).summary);
}

bool is_bundle(const std::string& argument) {
  const std::filesystem::path path(argument);
  std::error_code ignored;
  // What looks like a path is meant as one, also where nothing is there: reading it says so.
  return argument.find('/') != std::string::npos || path.extension() == ".csv" ||
         std::filesystem::is_directory(path, ignored);
}

session::Session read_bundle_with_warnings(
    Cli& cli, const std::string& path, bool skip_bad_rows) {
  session::ReadOptions options;
  options.skip_bad_rows = skip_bad_rows;
  session::Session session = session::read_bundle(path, options);
  for (const session::RejectedRow& row : session.rejected) {
    cli.console.warn(fmt::format("line {} left out: {}", row.line, row.reason));
  }
  return session;
}

Json call_for_files(Cli& cli, std::string_view method, Json params) {
  try {
    return cli.call(method, params);
  } catch (const service::RemoteError& error) {
    if (error.error()["data"]["code"] != service::error_kind(service::ErrorCode::kFile).code)
      throw;
    const std::filesystem::path wanted = params["path"].get<std::string>();
    const std::filesystem::path out = cli.call("hello").value("out_folder", std::string());
    // Could this user have written there either?
    std::error_code refused;
    std::filesystem::create_directories(wanted, refused);
    if (out.empty() || refused || ::access(wanted.c_str(), W_OK) != 0) throw;
    params["path"] = (out / wanted.filename()).string();
    Json answer = cli.call(method, params);
    std::filesystem::copy(
        out / wanted.filename(), wanted,
        std::filesystem::copy_options::recursive |
            std::filesystem::copy_options::overwrite_existing);
    answer["path"] = wanted.string();
    return answer;
  }
}

Json call_about(
    Cli& cli, std::string_view method, const Json& params, const std::string& alias,
    const std::string& file) {
  try {
    return cli.call(method, params);
  } catch (const service::RemoteError& remote) {
    Json error = remote.error();
    if (!error.contains("data") || error["data"]["at"].value("file", "") != alias) throw;
    error["data"]["at"]["file"] = file;
    std::string message = "\n" + error["message"].get<std::string>();
    const std::string said = "\n" + alias + ":";
    for (std::size_t at = message.find(said); at != std::string::npos;
         at = message.find(said, at + 1)) {
      message.replace(at + 1, alias.size(), file);
    }
    error["message"] = message.substr(1);
    throw service::RemoteError(error);
  }
}

Json read_document(const std::string& path) {
  try {
    return Json::parse(session::read_file(path));
  } catch (const Json::parse_error& trouble) {
    throw service::Error(
        service::ErrorCode::kBadData, fmt::format("{} is no JSON document", path),
        {{"file", path}},
        "The -o of sixdial calibrate and sixdial diagnose writes such a file.");
  }
}

std::string absolute(const std::string& path) {
  return std::filesystem::absolute(path).lexically_normal().string();
}

}  // namespace sixdial::cli
