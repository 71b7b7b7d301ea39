// sixdial diagnose SESSION|BUNDLE: what the simulation gets wrong and why, as a job of the
// service, or here on a bundle; the same code.
#include <fmt/format.h>
#include <unistd.h>

#include "cli/cli.h"
#include "cli/local_run.h"
#include "cli/printable.h"
#include "cli/shared_options.h"
#include "report/documents/diagnosis_json.h"
#include "report/sections/sections_of_studies.h"
#include "report/words/diagnosis_text.h"
#include "service/socket/server.h"
#include "service/study_params.h"
#include "session/csv.h"
#include "studies/diagnose.h"

namespace sixdial::cli {
namespace {

struct DiagnoseOptions {
  std::string subject, output, report;
  studies::DiagnosisRequest request;
  bool no_gain = false;
  bool skip_bad_rows = false;
};

/// `document`: of the same result.
void print_diagnosis(
    Cli& cli, const studies::DiagnosisResult& result, const Json& document,
    const DiagnoseOptions& options) {
  if (!options.output.empty()) session::write_file(options.output, document.dump(1) + "\n");
  if (cli.console.json) {
    cli.console.print_json("diagnosis", document);
    return;
  }
  cli.console.out << for_terminal(report::diagnosis_text(result));
  if (!options.report.empty()) {
    cli.console.note(fmt::format("report in {}", options.report));
  }
  cli.console.note(fmt::format("seed {}, {:.1f} s", result.inputs.seed, result.seconds));
}

service::ExitCode diagnose_bundle(Cli& cli, const DiagnoseOptions& options) {
  const session::Session session =
      read_bundle_with_warnings(cli, options.subject, options.skip_bad_rows);
  const studies::DiagnosisResult result = run_on(
      cli.console, session, "the diagnosis", [&](const auto& progress, std::stop_token stop) {
        return studies::diagnose(session, options.request, progress, std::move(stop));
      });
  if (!options.report.empty()) {
    session::write_file(
        options.report,
        report::diagnosis_page(result, session, service::operator_of(::getuid())));
  }
  print_diagnosis(cli, result, report::to_json(result), options);
  return service::ExitCode::kOk;
}

service::ExitCode diagnose_session(Cli& cli, const DiagnoseOptions& options) {
  Json params = service::params_of(options.request);
  params["session"] = options.subject;
  const StoredResult stored = run_job(cli, "diagnose.start", params);
  if (!options.report.empty()) {
    static_cast<void>(cli.call(
        "diagnose.report", {{"result", stored.number}, {"path", absolute(options.report)}}));
  }
  print_diagnosis(cli, report::diagnosis_from_json(stored.document), stored.document, options);
  if (!cli.console.json) {
    cli.console.note(fmt::format(
        "result {} in the store; the next report of {} shows it", stored.number,
        options.subject));
  }
  return service::ExitCode::kOk;
}

}  // namespace

void add_diagnose_command(CLI::App& app, Cli& cli) {
  CLI::App* command = app.add_subcommand(
      "diagnose",
      "What the simulation gets wrong on a session, which physical cause explains it and "
      "where, "
      "how sure that is, what naming it gains on G2, what could not be tested.");
  const auto options = std::make_shared<DiagnoseOptions>();
  studies::DiagnosisRequest& request = options->request;
  add_subject(*command, options->subject);
  add_seed(
      *command, request.seed, "of the random numbers; the same seed gives the same result");
  command
      ->add_option(
          "--bootstrap", request.bootstrap,
          "simulated sessions of noise behind the false alarm probability; 0: by formula")
      ->check(CLI::Range(0, 100000))
      ->capture_default_str();
  command
      ->add_option(
          "--samples", request.most_samples,
          "of a session with more samples so many are drawn and used; 0: all")
      ->check(CLI::Range(0, 10000000))
      ->capture_default_str();
  add_threads(*command, request.threads);
  command->add_flag(
      "--no-gain", options->no_gain, "do not judge by G2 what naming the causes gains: faster");
  command->add_option(
      "--report", options->report, "write the diagnosis as an HTML page to this file");
  add_result_file(*command, options->output);
  add_skip_bad_rows(*command, options->skip_bad_rows);
  command->callback([&cli, options] {
    cli.action = [&cli, options] {
      options->request.with_gain = !options->no_gain;
      return is_bundle(options->subject) ? diagnose_bundle(cli, *options)
                                         : diagnose_session(cli, *options);
    };
  });
}

}  // namespace sixdial::cli
