// sixdial compare SESSION|BUNDLE: every method on the same samples, as a job of the service, or
// here on a bundle; the same code.
#include <fmt/format.h>

#include "cli/cli.h"
#include "cli/local_run.h"
#include "cli/printable.h"
#include "cli/shared_options.h"
#include "report/documents/comparison_json.h"
#include "report/words/calibration_words.h"
#include "report/words/comparison_words.h"
#include "service/study_params.h"
#include "session/csv.h"

namespace sixdial::cli {
namespace {

struct CompareOptions {
  std::string subject, output;
  studies::CompareRequest request;
  bool skip_bad_rows = false;
};

void print_comparison(Cli& cli, const Json& document, const std::string& output) {
  if (!output.empty()) session::write_file(output, document.dump(1) + "\n");
  if (cli.console.json) {
    cli.console.print_json("comparison", document);
    return;
  }
  const studies::ComparisonResult result = report::comparison_from_json(document);
  if (const auto line = report::far_from_noise_line(result.assessment.noise)) {
    cli.console.out << for_terminal("Careful: " + *line + ".\n");
  }
  cli.console.out << for_terminal(report::comparison_text(result)) << '\n';
  for (const std::string& line : report::gross_error_lines(result.gross_errors)) {
    cli.console.warn(line);
  }
  for (const std::string& line : report::assessment_lines(result.assessment)) {
    cli.console.out << for_terminal(line) << '\n';
  }
  if (result.precision) {
    cli.console.out << report::precision_line(*result.precision, result.choices.space) << '\n';
  }
  cli.console.note(fmt::format(
      "{}; seed {}, {:.1f} s", report::before_in_words(result.before_uses_targets),
      result.inputs.seed, result.seconds));
}

service::ExitCode compare_bundle(Cli& cli, const CompareOptions& options) {
  const session::Session session =
      read_bundle_with_warnings(cli, options.subject, options.skip_bad_rows);
  const studies::ComparisonResult result = run_on(
      cli.console, session, "the comparison", [&](const auto& progress, std::stop_token stop) {
        return studies::compare(session, options.request, progress, std::move(stop));
      });
  print_comparison(cli, report::to_json(result), options.output);
  return service::ExitCode::kOk;
}

service::ExitCode compare_session(Cli& cli, const CompareOptions& options) {
  Json params = service::params_of(options.request);
  params["session"] = options.subject;
  const StoredResult stored = run_job(cli, "compare.start", params);
  print_comparison(cli, stored.document, options.output);
  if (!cli.console.json) {
    cli.console.note(fmt::format(
        "result {} in the store; the next report of {} shows it", stored.number,
        options.subject));
  }
  return service::ExitCode::kOk;
}

void add_compare_options(CLI::App& command, studies::CompareRequest& request) {
  command
      .add_option(
          "--methods", request.methods,
          "such as before,lm,ekf_dqpso+anfis: any identifier, alone or with any residual model")
      ->delimiter(',');
  command.add_option("--space", request.space, "what is fitted: positions, or raw readings")
      ->check(CLI::IsMember({"positions", "dials"}))
      ->capture_default_str();
  add_fixed_parameters(command, request.fix, request.free);
  command
      .add_option(
          "--loss", request.loss,
          "of the method lm; gross errors pull huber and cauchy less than squared")
      ->check(CLI::IsMember({"square", "huber", "cauchy"}))
      ->capture_default_str();
  add_keep_gross_errors(command, request.keep_gross_errors);
}

}  // namespace

void add_compare_command(CLI::App& app, Cli& cli) {
  CLI::App* command = app.add_subcommand(
      "compare",
      "Runs every method on the same samples: Table 6 for G1 and G2 with times, what the data "
      "can tell, which readings stand out.");
  const auto options = std::make_shared<CompareOptions>();
  studies::CompareRequest& request = options->request;
  add_subject(*command, options->subject);
  add_compare_options(*command, request);
  add_profile(*command, request.profile);
  add_seed(
      *command, request.seed, "of the random numbers; the same seed gives the same result");
  add_threads(*command, request.threads);
  add_search_sizes(*command, request);
  add_count(*command, "--bpnn-epochs", request.bpnn_epochs, "instead of 40000");
  add_result_file(*command, options->output);
  add_skip_bad_rows(*command, options->skip_bad_rows);
  command->callback([&cli, options] {
    cli.action = [&cli, options] {
      studies::check_methods(options->request.methods);
      return is_bundle(options->subject) ? compare_bundle(cli, *options)
                                         : compare_session(cli, *options);
    };
  });
}

}  // namespace sixdial::cli
