// sixdial calibrate SESSION|BUNDLE: as a job of the service, or here on a bundle; the same
// code.
#include <fmt/format.h>

#include "cli/cli.h"
#include "cli/local_run.h"
#include "cli/printable.h"
#include "cli/shared_options.h"
#include "report/documents/calibration_json.h"
#include "report/documents/summary.h"
#include "report/headline.h"
#include "report/words/calibration_words.h"
#include "service/study_params.h"
#include "session/csv.h"
#include "studies/calibrate.h"
#include "studies/method_name.h"

namespace sixdial::cli {
namespace {

struct CalibrateOptions {
  std::string subject, output;
  studies::CalibrationRequest request;
  bool skip_bad_rows = false;
};

/// The exit code that goes with what it found.
service::ExitCode print_calibration(Cli& cli, const Json& document, const std::string& output) {
  if (!output.empty()) session::write_file(output, document.dump(1) + "\n");
  const studies::CalibrationResult result = report::calibration_from_json(document);
  const bool usable = report::may_be_used(report::verdict_of(result).state);
  const auto code = usable ? service::ExitCode::kOk : service::ExitCode::kDataQuality;
  if (cli.console.json) {
    cli.console.print_json("calibration", report::document_summary(document));
    return code;
  }
  cli.console.out << for_terminal(report::headline_text(result))
                  << for_terminal(report::table_6_text(result));
  for (const std::string& line : report::turn_lines(result)) {
    cli.console.out << for_terminal(line) << "\n";
  }
  if (result.gross_errors) {
    for (const std::string& line : report::gross_error_lines(*result.gross_errors)) {
      cli.console.warn(line);
    }
  }
  if (result.assessment) {
    for (const std::string& line : report::assessment_lines(*result.assessment)) {
      cli.console.out << for_terminal(line) << '\n';
    }
  }
  if (result.precision) {
    cli.console.out << report::precision_line(*result.precision) << '\n';
  }
  if (const auto line = report::training_line(result)) cli.console.note(*line);
  cli.console.note(report::effort_line(result));
  return code;
}

service::ExitCode calibrate_bundle(Cli& cli, const CalibrateOptions& options) {
  const session::Session session =
      read_bundle_with_warnings(cli, options.subject, options.skip_bad_rows);
  const studies::CalibrationResult result = run_on(
      cli.console, session, "the calibration", [&](const auto& progress, std::stop_token stop) {
        return studies::calibrate(session, options.request, progress, std::move(stop));
      });
  return print_calibration(cli, report::to_json(result), options.output);
}

service::ExitCode calibrate_session(Cli& cli, const CalibrateOptions& options) {
  Json params = service::params_of(options.request);
  params["session"] = options.subject;
  const StoredResult stored = run_job(cli, "calibrate.start", params);
  const service::ExitCode code = print_calibration(cli, stored.document, options.output);
  if (!cli.console.json) {
    cli.console.note(fmt::format(
        "result {} in the store: sixdial report {}", stored.number, options.subject));
  }
  return code;
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
      "Identifies the robot: EKF, two QPSO searches, ANFIS, or any other method. A session of "
      "the service, or a bundle without one.");
  const auto options = std::make_shared<CalibrateOptions>();
  studies::CalibrationRequest& request = options->request;
  add_subject(*command, options->subject);
  command
      ->add_option(
          "--method", request.method,
          "how: an identifier (lm), or one with a residual model (lm+gp)")
      ->capture_default_str();
  add_profile(*command, request.profile);
  add_seed(
      *command, request.seed, "of the random numbers; the same seed gives the same result");
  add_threads(*command, request.threads);
  add_search_sizes(*command, request);
  add_fixed_parameters(*command, request.fix, request.free);
  add_tolerance(*command, request.tolerance_mm);
  add_keep_gross_errors(*command, request.keep_gross_errors);
  add_result_file(*command, options->output);
  add_skip_bad_rows(*command, options->skip_bad_rows);
  command->callback([&cli, options] {
    cli.action = [&cli, options] {
      static_cast<void>(studies::chosen_method(options->request.method, "method"));
      return is_bundle(options->subject) ? calibrate_bundle(cli, *options)
                                         : calibrate_session(cli, *options);
    };
  });
}

}  // namespace sixdial::cli
