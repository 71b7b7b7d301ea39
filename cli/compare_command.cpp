// sixdial compare SESSION|BUNDLE: every method on the same samples, as a job of the service, or
// here on a bundle; the same code.
#include <fmt/format.h>

#include "cli/cli.h"
#include "cli/local_run.h"
#include "session/csv.h"
#include "studies/assessment.h"
#include "studies/compare.h"

namespace sixdial::cli {
namespace {

struct CompareOptions {
  std::string subject, output;
  studies::CompareRequest request;
  bool skip_bad_rows = false;
};

Json params_of(const CompareOptions& options) {
  const studies::CompareRequest& request = options.request;
  Json params{
      {"session", options.subject},
      {"space", request.space},
      {"loss", request.loss},
      {"profile", request.profile},
      {"keep_gross_errors", request.keep_gross_errors},
      {"seed", request.seed}};
  const auto add_list = [&](const char* name, const std::vector<std::string>& values) {
    if (!values.empty()) params[name] = values;
  };
  add_list("methods", request.methods);
  add_list("fix", request.fix);
  add_list("free", request.free);
  const auto add_count = [&](const char* name, int count) {
    if (count > 0) params[name] = count;
  };
  add_count("threads", request.threads);
  add_count("particles", request.particles);
  add_count("qpso1_iterations", request.qpso1_iterations);
  add_count("qpso2_iterations", request.qpso2_iterations);
  add_count("anfis_epochs", request.anfis_epochs);
  add_count("bpnn_epochs", request.bpnn_epochs);
  return params;
}

void print_comparison(Cli& cli, const Json& document, const std::string& output) {
  if (!output.empty()) session::write_file(output, document.dump(1) + "\n");
  if (cli.console.json) {
    cli.console.print_json("comparison", document);
    return;
  }
  cli.console.out << studies::comparison_text(document) << '\n';
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
      "{}; seed {}, {:.1f} s", document["before_is"].get<std::string>(),
      document["inputs"]["seed"].get<std::uint64_t>(), document["seconds"].get<double>()));
}

service::ExitCode compare_bundle(Cli& cli, const CompareOptions& options) {
  const session::Session session =
      read_bundle_with_warnings(cli, options.subject, options.skip_bad_rows);
  const Json document =
      run_here(cli.console, "the comparison", [&](const auto& progress, std::stop_token stop) {
        return studies::compare(session, options.request, progress, std::move(stop));
      });
  print_comparison(cli, document, options.output);
  return service::ExitCode::kOk;
}

service::ExitCode compare_session(Cli& cli, const CompareOptions& options) {
  const Json job = cli.call("compare.start", params_of(options));
  const Json ended = follow_job(cli, job["job"].get<std::int64_t>());
  print_comparison(cli, fetch_result(cli, ended["result"].get<std::int64_t>()), options.output);
  if (!cli.console.json) {
    cli.console.note(fmt::format(
        "result {} in the store; the next report of {} shows it",
        ended["result"].get<std::int64_t>(), options.subject));
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
  command.add_option("--fix", request.fix, "parameters that stay nominal, such as d,alpha")
      ->delimiter(',');
  command.add_option("--free", request.free, "only these are fitted")->delimiter(',');
  command.add_option("--loss", request.loss, "of lm: huber and cauchy forgive gross errors")
      ->check(CLI::IsMember({"square", "huber", "cauchy"}))
      ->capture_default_str();
  command.add_flag(
      "--keep-gross-errors", request.keep_gross_errors,
      "list readings that stand out, but fit them too");
}

}  // namespace

void add_compare_command(CLI::App& app, Cli& cli) {
  CLI::App* command = app.add_subcommand(
      "compare",
      "Runs every method on the same samples: Table 6 for G1 and G2 with times, what the data "
      "can tell, which readings stand out.");
  const auto options = std::make_shared<CompareOptions>();
  studies::CompareRequest& request = options->request;
  command->add_option("SESSION|BUNDLE", options->subject, "name, or folder with session.csv")
      ->required();
  add_compare_options(*command, request);
  command->add_option("--profile", request.profile, "paper: its literal filter and search")
      ->check(CLI::IsMember({"default", "paper"}))
      ->capture_default_str();
  command->add_option("--seed", request.seed, "of searches and networks")
      ->capture_default_str();
  command->add_option("--threads", request.threads, "0: as many as there are; same result")
      ->check(CLI::Range(0, 256));
  command->add_option("--particles", request.particles, "instead of 50")
      ->check(CLI::Range(4, 10000));
  const auto count = [&](const char* name, int& value, const char* words) {
    command->add_option(name, value, words)->check(CLI::Range(1, 1000000));
  };
  count("--qpso1-iterations", request.qpso1_iterations, "instead of 100");
  count("--qpso2-iterations", request.qpso2_iterations, "instead of 400");
  count("--anfis-epochs", request.anfis_epochs, "instead of 500");
  count("--bpnn-epochs", request.bpnn_epochs, "instead of 40000");
  command->add_option("-o,--output", options->output, "the whole result as a JSON file");
  command->add_flag("--skip-bad-rows", options->skip_bad_rows, "of a bundle");
  command->callback([&cli, options] {
    cli.action = [&cli, options] {
      studies::check_methods(options->request.methods);
      return is_bundle(options->subject) ? compare_bundle(cli, *options)
                                         : compare_session(cli, *options);
    };
  });
}

}  // namespace sixdial::cli
