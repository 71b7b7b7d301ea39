// sixdial export-model SESSION|BUNDLE --as FORMAT: the calibrated robot, or the one extended by
// named causes, as a file that other programs run.
#include <fmt/format.h>

#include "cli/cli.h"
#include "cli/local_run.h"
#include "cli/shared_options.h"
#include "report/documents/calibration_json.h"
#include "report/documents/diagnosis_json.h"
#include "report/documents/warnings_document.h"
#include "report/export/exported_json.h"
#include "report/words/warning_words.h"
#include "session/csv.h"
#include "studies/calibrate.h"
#include "studies/diagnose.h"
#include "studies/exported_model.h"
#include "studies/stored_warnings.h"

namespace sixdial::cli {
namespace {

struct ExportModelOptions {
  std::string calibration_method{studies::kPaperMethod};
  std::string subject, as, by, output, result_file, diagnosis_file, urdf_file;
  std::vector<double> endstops_mm;
  std::int64_t result = 0, diagnosis = 0;
  std::uint64_t seed = 1;
  bool skip_bad_rows = false;
  bool from_other_session = false;
};

constexpr std::string_view kOtherData =
    "Use one of this session, or say --from-other-session where the robot is the same.";

bool exports_extended(const ExportModelOptions& options) {
  const bool given = !options.diagnosis_file.empty() || options.diagnosis > 0;
  return options.by.empty() ? given : options.by == "extended";
}

/// `answer`: the document, as the service gave it or made here; with warnings of the session.
void print_exported(
    Cli& cli, const ExportModelOptions& options, Json answer, const std::string& text) {
  const report::Exported exported = report::exported_from_json(answer);
  if (!options.output.empty()) session::write_file(options.output, text);
  if (cli.console.json) {
    for (const char* const key : {"bytes", "next_offset", "result"}) answer.erase(key);
    answer["text"] = options.output.empty() ? Json(text) : Json(nullptr);
    answer["file"] = options.output.empty() ? Json(nullptr) : Json(options.output);
    cli.console.print_json("export", answer);
    return;
  }
  for (const std::string& line : report::warning_lines(report::warnings_in(answer))) {
    cli.console.warn(line);
  }
  const auto lines = report::left_out_lines(exported.left_out, exported.miss);
  for (const std::string& line : lines) {
    if (exported.left_out.empty()) {
      cli.console.note(line);
    } else {
      cli.console.warn(line);
    }
  }
  for (const std::string& note : exported.notes) cli.console.note(note);
  if (options.output.empty()) {
    cli.console.print_data(text);
  } else {
    cli.console.note(fmt::format("the {} model in {}", exported.model, options.output));
  }
}

studies::DiagnosisResult exported_diagnosis(
    Cli& cli, const ExportModelOptions& options, const session::Session& session) {
  if (options.diagnosis_file.empty()) {
    studies::DiagnosisRequest request;
    request.seed = options.seed;
    request.bootstrap = 0;
    request.with_gain = false;
    return made_first(
        cli.console, "the diagnosis", "--diagnosis-file",
        [&](const auto& progress, std::stop_token stop) {
          return studies::diagnose(session, request, progress, std::move(stop));
        });
  }
  auto stored = report::diagnosis_from_json(read_document(options.diagnosis_file));
  if (!options.from_other_session) {
    studies::check_same_data(stored.inputs, session, "diagnosis", kOtherData);
  }
  studies::judge_stored(stored, session);
  return stored;
}

studies::CalibrationResult exported_calibration(
    Cli& cli, const ExportModelOptions& options, const session::Session& session) {
  if (options.result_file.empty()) {
    studies::CalibrationRequest request;
    request.seed = options.seed;
    request.method = options.calibration_method;
    return made_first(
        cli.console, "the calibration", "--calibration",
        [&](const auto& progress, std::stop_token stop) {
          return studies::calibrate(session, request, progress, std::move(stop));
        });
  }
  auto stored = report::calibration_from_json(read_document(options.result_file));
  if (!options.from_other_session) {
    studies::check_same_data(stored.inputs, session, "calibration", kOtherData);
  }
  studies::judge_stored(stored, session);
  return stored;
}

service::ExitCode export_bundle(Cli& cli, const ExportModelOptions& options) {
  const session::Session session =
      read_bundle_with_warnings(cli, options.subject, options.skip_bad_rows);
  const auto exported = [&](const auto& result) {
    const auto warnings = result.warnings.value_or(std::vector<studies::Warning>());
    report::check_may_command(warnings);
    const report::Exported found = report::export_model(
        studies::exported_model(result, session), options.as,
        {.endstops_mm = options.endstops_mm,
         .urdf_text = options.urdf_file.empty() ? "" : session::read_file(options.urdf_file)});
    Json answer = report::to_json(found);
    answer["warnings"] = report::warnings_json(warnings);
    print_exported(cli, options, std::move(answer), found.text);
  };
  if (exports_extended(options)) {
    exported(exported_diagnosis(cli, options, session));
  } else {
    exported(exported_calibration(cli, options, session));
  }
  return service::ExitCode::kOk;
}

service::ExitCode export_session(Cli& cli, const ExportModelOptions& options) {
  Json params{{"session", options.subject}, {"as", options.as}};
  params["by"] = exports_extended(options) ? "extended" : "kinematics";
  if (options.result > 0) params["result"] = options.result;
  if (options.diagnosis > 0) params["diagnosis"] = options.diagnosis;
  if (options.from_other_session) params["from_other_session"] = true;
  if (!options.urdf_file.empty()) params["urdf_text"] = session::read_file(options.urdf_file);
  constexpr std::array kEndstops{"endstop_a_mm", "endstop_b_mm", "endstop_c_mm"};
  for (std::size_t i = 0; i < options.endstops_mm.size(); ++i) {
    params[kEndstops.at(i)] = options.endstops_mm[i];
  }
  std::string text;
  Json answer;
  do {
    params["offset"] = text.size();
    answer = cli.call("model.export", params);
    text += answer["text"].get<std::string>();
  } while (!answer["next_offset"].is_null());
  print_exported(cli, options, std::move(answer), text);
  return service::ExitCode::kOk;
}

CLI::IsMember format_names() {
  std::vector<std::string> names;
  for (const report::ExportFormat* each : report::export_formats()) {
    names.emplace_back(each->name);
  }
  return CLI::IsMember(names);
}

std::string format_list() {
  std::string list;
  for (const report::ExportFormat* each : report::export_formats()) {
    list += fmt::format("{}{}: {}", list.empty() ? "" : "; ", each->name, each->about);
  }
  return list;
}

}  // namespace

void add_export_command(CLI::App& app, Cli& cli) {
  CLI::App* command = app.add_subcommand("export-model", summary_of("model.export"));
  const auto options = std::make_shared<ExportModelOptions>();
  add_subject(*command, options->subject);
  command->add_option("--as", options->as, format_list())->required()->check(format_names());
  command->add_option("-o,--output", options->output, "the file to write; default: stdout");
  command
      ->add_option(
          "--model", options->by,
          "kinematics: the calibrated robot; extended: robot and named causes of a diagnosis; "
          "default: extended where a diagnosis is given")
      ->check(CLI::IsMember({"kinematics", "extended"}));
  add_stored_result(*command, options->result);
  add_from_other_session(*command, options->from_other_session);
  command
      ->add_option(
          "--calibration", options->result_file,
          "of a bundle: result file of `calibrate -o` instead of calibrating now")
      ->check(existing_file());
  command
      ->add_option(
          "--calibration-method", options->calibration_method,
          "of a bundle that is calibrated now, such as lm")
      ->capture_default_str();
  command->add_option(
      "--diagnosis", options->diagnosis,
      "of extended: a stored diagnosis by number; default: the newest");
  command
      ->add_option(
          "--diagnosis-file", options->diagnosis_file,
          "of a bundle and extended: result file of `diagnose -o` instead of diagnosing now")
      ->check(existing_file());
  command
      ->add_option(
          "--endstops", options->endstops_mm,
          "of klipper: position_endstop of stepper_a, b and c as printer.cfg has them now [mm]")
      ->delimiter(',')
      ->expected(3);
  command
      ->add_option(
          "--urdf", options->urdf_file,
          "of urdf: the file that the arm came from; its origins are set right, its shapes and "
          "masses stay")
      ->check(existing_file());
  add_seed(*command, options->seed, "of a bundle's calibration or diagnosis");
  add_skip_bad_rows(*command, options->skip_bad_rows);
  command->callback([&cli, options] {
    cli.action = [&cli, options] {
      return is_bundle(options->subject) ? export_bundle(cli, *options)
                                         : export_session(cli, *options);
    };
  });
}

}  // namespace sixdial::cli
