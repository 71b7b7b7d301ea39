// sixdial recommend SESSION|BUNDLE: which model to command by, why, and the one set of
// parameters that belongs to it.
#include <fmt/format.h>

#include "cli/cli.h"
#include "cli/local_run.h"
#include "cli/shared_options.h"
#include "report/documents/calibration_json.h"
#include "report/documents/diagnosis_json.h"
#include "report/documents/recommendation_json.h"
#include "report/words/recommendation_words.h"
#include "session/csv.h"
#include "studies/calibrate.h"
#include "studies/recommendation.h"
#include "studies/stored_warnings.h"

namespace sixdial::cli {
namespace {

struct RecommendOptions {
  std::string method{studies::kPaperMethod};
  std::string subject, output, result_file, diagnosis_file;
  std::int64_t result = 0;
  std::uint64_t seed = 1;
  bool skip_bad_rows = false;
};

std::string cell(const Json& value) {
  return value.is_number() ? fmt::format("{:10.4f}", value.get<double>())
                           : fmt::format("{:>10}", "-");
}

/// `answer`: the document, as the service gave it or made here.
std::string recommendation_text(const Json& answer) {
  std::string text = answer["why"].get<std::string>() + "\n\n";
  text += fmt::format(
      "{:<42} {:>10} {:>10} {:>10}\n", "mean position error, mm", "G1, out", "G2", "reached");
  for (const Json& each : answer["candidates"]) {
    text += fmt::format(
        "{:<42} {} {} {}{}\n", each["name"].get<std::string>(), cell(each["held_out_mm"]),
        cell(each["g2_mm"]), cell(each["reached_mm"]),
        each["id"] == answer["by"]      ? "  recommended"
        : each["ruled_out"].get<bool>() ? "  ruled out"
                                        : "");
  }
  text += '\n';
  for (const Json& each : answer["parameters"]) {
    text += fmt::format(
        "{:<10} {:>14.6f} {:<3}  sd {}, 95 % {} to {}\n", each["name"].get<std::string>(),
        each["identified"].get<double>(), each["unit"].get<std::string>(), cell(each["sd"]),
        cell(each["low_95"]), cell(each["high_95"]));
  }
  return text;
}

void print_recommendation(Cli& cli, const Json& answer, const std::string& output) {
  if (!output.empty()) session::write_file(output, answer.dump(1) + "\n");
  cli.console.print("recommendation", answer, recommendation_text(answer));
}

service::ExitCode recommend_bundle(Cli& cli, const RecommendOptions& options) {
  const session::Session session =
      read_bundle_with_warnings(cli, options.subject, options.skip_bad_rows);
  studies::CalibrationResult calibration =
      !options.result_file.empty()
          ? report::calibration_from_json(read_document(options.result_file))
          : run_here(
                cli.console, "the calibration",
                [&](const auto& progress, std::stop_token stop) {
                  studies::CalibrationRequest request;
                  request.seed = options.seed;
                  request.method = options.method;
                  return studies::calibrate(session, request, progress, std::move(stop));
                });
  studies::judge_stored(calibration, session);
  std::optional<studies::DiagnosisResult> diagnosis;
  if (!options.diagnosis_file.empty()) {
    diagnosis = report::diagnosis_from_json(read_document(options.diagnosis_file));
  }
  print_recommendation(
      cli, report::to_json(studies::recommend(calibration, diagnosis ? &*diagnosis : nullptr)),
      options.output);
  return service::ExitCode::kOk;
}

service::ExitCode recommend_session(Cli& cli, const RecommendOptions& options) {
  Json params{{"session", options.subject}};
  if (options.result > 0) params["result"] = options.result;
  print_recommendation(cli, cli.call("result.recommend", params), options.output);
  return service::ExitCode::kOk;
}

}  // namespace

void add_recommend_command(CLI::App& app, Cli& cli) {
  CLI::App* command = app.add_subcommand("recommend", summary_of("result.recommend"));
  const auto options = std::make_shared<RecommendOptions>();
  add_subject(*command, options->subject);
  add_stored_result(*command, options->result);
  add_result_file(*command, options->output);
  command
      ->add_option(
          "--calibration", options->result_file,
          "of a bundle: result file of `calibrate -o` instead of calibrating now")
      ->check(existing_file());
  command
      ->add_option(
          "--method", options->method, "of a bundle that is calibrated now, such as lm+gp")
      ->capture_default_str();
  command
      ->add_option(
          "--diagnosis-file", options->diagnosis_file,
          "of a bundle: result file of `diagnose -o`, whose causes are a candidate too")
      ->check(existing_file());
  command->add_option("--seed", options->seed, "of a bundle's calibration")
      ->capture_default_str();
  add_skip_bad_rows(*command, options->skip_bad_rows);
  command->callback([&cli, options] {
    cli.action = [&cli, options] {
      return is_bundle(options->subject) ? recommend_bundle(cli, *options)
                                         : recommend_session(cli, *options);
    };
  });
}

}  // namespace sixdial::cli
