// The command line `sixdial`: a client of the service, and the same work on a bundle without
// one.
#pragma once

#include <CLI/CLI.hpp>
#include <filesystem>
#include <functional>
#include <memory>
#include <optional>
#include <ostream>
#include <string>
#include <vector>

#include "cli/console.h"
#include "service/job.h"
#include "service/socket/client.h"
#include "session/session.h"

namespace sixdial::cli {

/// What all commands share. A command's callback sets `action`; `run` carries it out.
struct Cli {
  Cli(std::ostream& out, std::ostream& err) : console{.out = out, .err = err} {}
  Console console;
  std::string socket_path{};
  std::function<service::ExitCode()> action{};

  /// Connected at the first use. Throws Error unreachable.
  [[nodiscard]] service::Client& client();
  /// One call for commands that only ask.
  Json call(std::string_view method, const Json& params = Json::object()) {
    return client().call(method, params);
  }

 private:
  std::unique_ptr<service::Client> client_;
};

/// The whole program; `argv` as in main.
[[nodiscard]] int run(int argc, const char* const* argv, std::ostream& out, std::ostream& err);

/// What the parser says to a command line (without the program's name), by the name of its kind
/// of error; empty: it is understood. Nothing is carried out.
struct ParseTrouble {
  std::string kind;  // "RequiredError", "ExtrasError"
  std::string message;
};
[[nodiscard]] std::optional<ParseTrouble> parse_trouble(const std::vector<std::string>& words);

void add_service_commands(CLI::App& app, Cli& cli);    // hello, protocol, shutdown
void add_session_commands(CLI::App& app, Cli& cli);    // session ...
void add_plan_commands(CLI::App& app, Cli& cli);       // plan ...
void add_collect_command(CLI::App& app, Cli& cli);     // collect
void add_calibrate_command(CLI::App& app, Cli& cli);   // calibrate
void add_compare_command(CLI::App& app, Cli& cli);     // compare
void add_diagnose_command(CLI::App& app, Cli& cli);    // diagnose
void add_report_command(CLI::App& app, Cli& cli);      // report
void add_rig_commands(CLI::App& app, Cli& cli);        // rig ...
void add_rig_adopt(CLI::App& group, Cli& cli);         // rig adopt
void add_job_commands(CLI::App& app, Cli& cli);        // job ...
void add_import_command(CLI::App& app, Cli& cli);      // import
void add_compensate_command(CLI::App& app, Cli& cli);  // compensate
void add_validate_command(CLI::App& app, Cli& cli);    // validate
void add_export_command(CLI::App& app, Cli& cli);      // export-model
void add_recommend_command(CLI::App& app, Cli& cli);   // recommend
void add_doctor_commands(CLI::App& app, Cli& cli);     // doctor, rig scan
void add_dials_command(CLI::App& app, Cli& cli);       // dials
void add_robot_commands(CLI::App& app, Cli& cli);      // robot stop

/// The method table's words for a command's help.
[[nodiscard]] std::string summary_of(std::string_view method);
/// A path that names a bundle: a folder with session.csv, or a session.csv.
[[nodiscard]] bool is_bundle(const std::string& argument);
/// A bundle; rows that were left out are warned of by line.
[[nodiscard]] session::Session read_bundle_with_warnings(
    Cli& cli, const std::string& path, bool skip_bad_rows);
/// A call with the text of a file, which its errors call `alias`: they name the file.
Json call_about(
    Cli& cli, std::string_view method, const Json& params, const std::string& alias,
    const std::string& file);
/// A result that a command wrote by -o. Throws Error bad_data where it is no JSON.
[[nodiscard]] Json read_document(const std::string& path);
/// As the service must get it: it runs in another directory.
[[nodiscard]] std::string absolute(const std::string& path);
/// Follows a job with a progress line until it has ended; prints nothing else. Throws the
/// job's error.
service::Job follow_job(Cli& cli, std::int64_t job);
/// Starts a job by its method and follows it. Throws the job's error.
service::Job start_and_follow(Cli& cli, std::string_view method, const Json& params);

struct StoredResult {
  std::int64_t number = 0;
  Json document;
};
/// Starts a job by its method, follows it and fetches its result. Throws the job's error.
[[nodiscard]] StoredResult run_job(Cli& cli, std::string_view method, const Json& params);
/// A method that has the service write files into `params.path`. A service of another user may
/// not write there: then it writes into a folder of its own, from where they are copied.
[[nodiscard]] Json call_for_files(Cli& cli, std::string_view method, Json params);
/// A stored result's whole document, page by page.
[[nodiscard]] Json fetch_result(Cli& cli, std::int64_t result);

}  // namespace sixdial::cli
