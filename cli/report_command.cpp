// sixdial report SESSION|BUNDLE: the report files from a stored result, or from a bundle that
// is calibrated here.
#include <fmt/format.h>
#include <pwd.h>
#include <unistd.h>

#include <filesystem>

#include "cli/cli.h"
#include "cli/local_run.h"
#include "cli/shared_options.h"
#include "report/documents/calibration_json.h"
#include "report/documents/warnings_document.h"
#include "report/headline.h"
#include "report/report_run.h"
#include "report/sections/against_sections.h"
#include "report/words/warning_words.h"
#include "service/report_pdf.h"
#include "service/socket/server.h"
#include "session/bundle.h"
#include "session/csv.h"
#include "studies/calibrate.h"
#include "studies/compare.h"
#include "studies/diagnose.h"
#include "studies/stored_warnings.h"

namespace sixdial::cli {
namespace {

struct ReportOptions {
  std::string method{studies::kPaperMethod};
  std::string subject, output, result_file, pdf, against;
  std::int64_t result = 0;
  std::uint64_t seed = 1;
  std::optional<double> tolerance_mm{};
  bool skip_bad_rows = false;
  bool compare = false;
  bool diagnose = false;
};

/// The exit code that goes with the state of the robot.
service::ExitCode print_files(Cli& cli, const ReportOptions& options, Json answer) {
  for (const std::string& line : report::warning_lines(report::warnings_in(answer))) {
    cli.console.warn(line);
  }
  const std::string state = answer.value("state", "calibrated");
  std::string text = answer["path"].get<std::string>() + "/report.html\n";
  if (!options.pdf.empty()) {
    const std::filesystem::path folder = answer["path"].get<std::string>();
    service::print_pdf(folder / "report.html", options.pdf);
    answer["pdf"] = absolute(options.pdf);
    text += options.pdf + "\n";
  }
  cli.console.print("report", answer, text);
  return report::may_be_used(report::state_from(state)) ? service::ExitCode::kOk
                                                        : service::ExitCode::kDataQuality;
}

studies::CalibrationResult calibrate_here(
    Cli& cli, const session::Session& session, const ReportOptions& options) {
  return run_here(
      cli.console, fmt::format("the calibration of {}", session.name),
      [&](const auto& progress, std::stop_token stop) {
        studies::CalibrationRequest request;
        request.seed = options.seed;
        request.method = options.method;
        return studies::calibrate(session, request, progress, std::move(stop));
      });
}

service::ExitCode report_bundle(
    Cli& cli, const ReportOptions& options, const std::string& folder) {
  const session::Session session =
      read_bundle_with_warnings(cli, options.subject, options.skip_bad_rows);
  studies::CalibrationResult result =
      options.result_file.empty()
          ? calibrate_here(cli, session, options)
          : report::calibration_from_json(read_document(options.result_file));
  studies::judge_stored(result, session);
  std::optional<studies::ComparisonResult> comparison;
  if (options.compare) {
    studies::CompareRequest request;
    request.seed = options.seed;
    comparison = run_here(
        cli.console, "the comparison", [&](const auto& progress, std::stop_token stop) {
          return studies::compare(session, request, progress, std::move(stop));
        });
  }
  std::optional<studies::DiagnosisResult> diagnosis;
  if (options.diagnose) {
    studies::DiagnosisRequest request;
    request.seed = options.seed;
    diagnosis =
        run_here(cli.console, "the diagnosis", [&](const auto& progress, std::stop_token stop) {
          return studies::diagnose(session, request, progress, std::move(stop));
        });
  }
  std::vector<report::Section> more;
  if (!options.against.empty()) {
    const session::Session other =
        read_bundle_with_warnings(cli, options.against, options.skip_bad_rows);
    const studies::CalibrationResult other_result = calibrate_here(cli, other, options);
    more = report::against_sections({result, session}, {other_result, other});
  }
  const auto files = report::write_report(
      result, session, service::operator_of(::getuid()), folder,
      {.comparison = comparison ? &*comparison : nullptr,
       .diagnosis = diagnosis ? &*diagnosis : nullptr,
       .tolerance_mm = options.tolerance_mm},
      std::move(more));
  return print_files(
      cli, options,
      {{"path", folder},
       {"files", files},
       {"state", report::state_name(report::verdict_of(result).state)},
       {"warnings",
        report::warnings_json(result.warnings.value_or(std::vector<studies::Warning>()))}});
}

}  // namespace

void add_report_command(CLI::App& app, Cli& cli) {
  CLI::App* command =
      app.add_subcommand("report", "Writes a calibration report: HTML, JSON, CSV, the bundle.");
  const auto options = std::make_shared<ReportOptions>();
  add_subject(*command, options->subject);
  command->add_option("-o,--output", options->output, "folder; default: <session>-report");
  command->add_option(
      "--result", options->result, "number of a stored result; default: the newest");
  command->add_option(
      "--calibration", options->result_file,
      "of a bundle: result file of `calibrate -o` instead of calibrating now");
  command
      ->add_option(
          "--method", options->method, "of a bundle that is calibrated now, such as lm+gp")
      ->capture_default_str();
  command->add_flag(
      "--compare", options->compare,
      "compare all methods now and show them; a stored comparison is shown anyway");
  command->add_flag(
      "--diagnose", options->diagnose,
      "look for the physical cause of what is left now, and show it; a stored diagnosis is "
      "shown anyway");
  add_seed(*command, options->seed, "of a bundle's calibration, and of --compare");
  command->add_option(
      "--against", options->against,
      "another calibrated session (of a bundle: another bundle), shown beside: as found, as "
      "left");
  add_tolerance(*command, options->tolerance_mm);
  command->add_option("--pdf", options->pdf, "print it to this file too, A4, by Chromium");
  add_skip_bad_rows(*command, options->skip_bad_rows);
  command->callback([&cli, options] {
    cli.action = [&cli, options] {
      const std::filesystem::path subject(options->subject);
      const std::string name = subject.filename().empty()
                                   ? subject.parent_path().filename().string()
                                   : subject.stem().string();
      const std::string folder =
          absolute(options->output.empty() ? name + "-report" : options->output);
      if (is_bundle(options->subject)) return report_bundle(cli, *options, folder);
      if (options->compare) {
        start_and_follow(
            cli, "compare.start", {{"session", options->subject}, {"seed", options->seed}});
      }
      if (options->diagnose) {
        start_and_follow(
            cli, "diagnose.start", {{"session", options->subject}, {"seed", options->seed}});
      }
      Json params{{"session", options->subject}, {"path", folder}};
      if (options->result > 0) params["result"] = options->result;
      if (!options->against.empty()) params["against"] = options->against;
      if (options->tolerance_mm) params["tolerance_mm"] = *options->tolerance_mm;
      return print_files(cli, *options, call_for_files(cli, "report.write", params));
    };
  });
}

}  // namespace sixdial::cli
