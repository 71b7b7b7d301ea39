// sixdial calibrate SESSION|BUNDLE: as a job of the service, or here on a bundle; the same
// code.
#include <fmt/format.h>

#include <fstream>

#include "cli/cli.h"
#include "cli/local_run.h"
#include "session/bundle.h"
#include "session/csv.h"
#include "studies/assessment.h"
#include "studies/calibrate.h"

namespace sixdial::cli {
namespace {

struct CalibrateOptions {
  std::string subject, output, profile = "default";
  std::uint64_t seed = 1;
  int threads = 0;
  int particles = 0, qpso1 = 0, qpso2 = 0, epochs = 0;
  bool skip_bad_rows = false;
  std::vector<std::string> fix, free;
  bool keep_gross_errors = false;
};

studies::CalibrationRequest request_of(const CalibrateOptions& options) {
  studies::CalibrationRequest request;
  request.profile = *calibration::profile_from(options.profile);
  request.seed = options.seed;
  request.threads = options.threads;
  if (options.particles > 0) request.particles = options.particles;
  if (options.qpso1 > 0) request.qpso1_iterations = options.qpso1;
  if (options.qpso2 > 0) request.qpso2_iterations = options.qpso2;
  if (options.epochs > 0) request.anfis_epochs = options.epochs;
  request.fix = options.fix;
  request.free = options.free;
  request.keep_gross_errors = options.keep_gross_errors;
  return request;
}

Json params_of(const CalibrateOptions& options) {
  Json params{
      {"session", options.subject}, {"profile", options.profile}, {"seed", options.seed}};
  if (options.threads > 0) params["threads"] = options.threads;
  if (options.particles > 0) params["particles"] = options.particles;
  if (options.qpso1 > 0) params["qpso1_iterations"] = options.qpso1;
  if (options.qpso2 > 0) params["qpso2_iterations"] = options.qpso2;
  if (options.epochs > 0) params["anfis_epochs"] = options.epochs;
  if (!options.fix.empty()) params["fix"] = options.fix;
  if (!options.free.empty()) params["free"] = options.free;
  if (options.keep_gross_errors) params["keep_gross_errors"] = true;
  return params;
}

void print_calibration(Cli& cli, const Json& document, const std::string& output) {
  if (!output.empty()) session::write_file(output, document.dump(1) + "\n");
  if (cli.console.json) {
    cli.console.print_json("calibration", studies::result_summary(document));
    return;
  }
  cli.console.out << studies::table_6_text(document);
  for (const std::string& line : studies::gross_error_lines(document["gross_errors"])) {
    cli.console.warn(line);
  }
  for (const std::string& line : studies::assessment_lines(document["assessment"])) {
    cli.console.out << line << '\n';
  }
  if (document["precision"].is_object()) {
    cli.console.out << studies::precision_line(document["precision"]) << '\n';
  }
  cli.console.note(fmt::format(
      "DQPSO is {:.2e} mm above the least-squares minimum; seed {}, {:.1f} s",
      document["above_minimum_mm"].get<double>(),
      document["inputs"]["seed"].get<std::uint64_t>(), document["seconds"].get<double>()));
}

service::ExitCode calibrate_bundle(Cli& cli, const CalibrateOptions& options) {
  const session::Session session =
      read_bundle_with_warnings(cli, options.subject, options.skip_bad_rows);
  const Json document =
      run_here(cli.console, "the calibration", [&](const auto& progress, std::stop_token stop) {
        return studies::calibrate(session, request_of(options), progress, std::move(stop));
      });
  print_calibration(cli, document, options.output);
  return service::ExitCode::kOk;
}

service::ExitCode calibrate_session(Cli& cli, const CalibrateOptions& options) {
  const Json job = cli.call("calibrate.start", params_of(options));
  const Json ended = follow_job(cli, job["job"].get<std::int64_t>());
  const Json document = fetch_result(cli, ended["result"].get<std::int64_t>());
  print_calibration(cli, document, options.output);
  if (!cli.console.json) {
    cli.console.note(fmt::format(
        "result {} in the store: sixdial report {}", ended["result"].get<std::int64_t>(),
        options.subject));
  }
  return service::ExitCode::kOk;
}

}  // namespace

Json fetch_result(Cli& cli, std::int64_t result) {
  std::string text;
  for (;;) {
    const Json page = cli.call("result.get", {{"result", result}, {"offset", text.size()}});
    text += page["text"].get<std::string>();
    if (page["next_offset"].is_null()) return Json::parse(text);
  }
}

void add_calibrate_command(CLI::App& app, Cli& cli) {
  CLI::App* command = app.add_subcommand(
      "calibrate",
      "Identifies the robot: EKF, two QPSO searches, ANFIS. A session of the service, "
      "or a bundle without one.");
  const auto options = std::make_shared<CalibrateOptions>();
  command->add_option("SESSION|BUNDLE", options->subject, "name, or folder with session.csv")
      ->required();
  command->add_option("--profile", options->profile, "paper: its literal choices")
      ->check(CLI::IsMember({"default", "paper"}))
      ->capture_default_str();
  command->add_option("--seed", options->seed, "of the searches")->capture_default_str();
  command->add_option("--threads", options->threads, "0: as many as there are; same result")
      ->check(CLI::Range(0, 256));
  command->add_option("--particles", options->particles, "instead of 50")
      ->check(CLI::Range(4, 10000));
  command->add_option("--qpso1-iterations", options->qpso1, "instead of 100")
      ->check(CLI::Range(1, 100000));
  command->add_option("--qpso2-iterations", options->qpso2, "instead of 400")
      ->check(CLI::Range(1, 100000));
  command->add_option("--anfis-epochs", options->epochs, "instead of 500")
      ->check(CLI::Range(1, 100000));
  command->add_option("--fix", options->fix, "parameters that stay nominal, such as d,alpha")
      ->delimiter(',');
  command->add_option("--free", options->free, "only these are fitted")->delimiter(',');
  command->add_flag(
      "--keep-gross-errors", options->keep_gross_errors,
      "list readings that stand out, but fit them too");
  command->add_option("-o,--output", options->output, "the whole result as a JSON file");
  command->add_flag("--skip-bad-rows", options->skip_bad_rows, "of a bundle");
  command->callback([&cli, options] {
    cli.action = [&cli, options] {
      return is_bundle(options->subject) ? calibrate_bundle(cli, *options)
                                         : calibrate_session(cli, *options);
    };
  });
}

}  // namespace sixdial::cli
