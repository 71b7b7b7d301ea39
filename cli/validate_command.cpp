// sixdial validate: commands what a calibration or a diagnosis says on the robot and tells the
// error that is really reached.
#include <fmt/format.h>

#include "cli/cli.h"
#include "cli/shared_options.h"
#include "report/documents/summary.h"
#include "report/documents/validation_json.h"
#include "report/words/validation_words.h"
#include "session/csv.h"

namespace sixdial::cli {
namespace {

struct ValidateOptions {
  std::string session, set = "G2", rig_file, name, output;
  std::vector<std::string> by;
  std::int64_t result = 0, diagnosis = 0;
  bool from_other_session = false;
};

service::ExitCode validate(Cli& cli, const ValidateOptions& options) {
  Json params{{"session", options.session}, {"set", options.set}};
  if (options.result > 0) params["result"] = options.result;
  if (options.diagnosis > 0) params["diagnosis"] = options.diagnosis;
  if (options.from_other_session) params["from_other_session"] = true;
  if (!options.by.empty()) params["by"] = options.by;
  if (!options.name.empty()) params["name"] = options.name;
  if (!options.rig_file.empty()) params["rig_toml"] = session::read_file(options.rig_file);
  const StoredResult stored = run_job(cli, "validate.start", params);
  if (!options.output.empty()) {
    session::write_file(options.output, stored.document.dump(1) + "\n");
  }
  const studies::ValidationResult result = report::validation_from_json(stored.document);
  cli.console.print(
      "validation", report::document_summary(stored.document), report::validation_text(result));
  for (const studies::NotMeasured& point : result.troubles) {
    cli.console.warn(fmt::format("{} {} not measured: {}", point.set, point.point, point.why));
  }
  if (!cli.console.json) {
    cli.console.note(fmt::format(
        "samples in session {}, result {}", result.inputs.validation_session, stored.number));
  }
  return result.troubles.empty() ? service::ExitCode::kOk : service::ExitCode::kDataQuality;
}

}  // namespace

void add_validate_command(CLI::App& app, Cli& cli) {
  CLI::App* command = app.add_subcommand("validate", summary_of("validate.start"));
  const auto options = std::make_shared<ValidateOptions>();
  command->add_option("SESSION", options->session, "a calibrated session of the service")
      ->required();
  command->add_option("--set", options->set, "whose targets are commanded")
      ->capture_default_str();
  command
      ->add_option(
          "--method,--model", options->by,
          "one or more of before, kinematics, full, and by the session's diagnosis extended "
          "and "
          "extended_full; default: all of them, the last two where causes are named")
      ->check(compensation_words())
      ->delimiter(',');
  command->add_option(
      "--diagnosis", options->diagnosis, "of extended: by number; default: the newest");
  command->add_option("--rig", options->rig_file, "rig.toml with today's connections")
      ->check(existing_file());
  command->add_option("--name", options->name, "of the new session");
  add_stored_result(*command, options->result);
  add_from_other_session(*command, options->from_other_session);
  add_result_file(*command, options->output);
  command->callback(
      [&cli, options] { cli.action = [&cli, options] { return validate(cli, *options); }; });
}

}  // namespace sixdial::cli
