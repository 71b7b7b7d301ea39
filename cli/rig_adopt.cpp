// sixdial rig adopt: the geometry that a calibration found goes back into a rig file, each
// figure with its uncertainty. Comments and everything else stay as they are.
#include "session/rig_adopt.h"

#include <fmt/format.h>

#include <memory>

#include "cli/cli.h"
#include "cli/shared_options.h"
#include "geometry/units.h"
#include "report/documents/calibration_json.h"
#include "session/csv.h"
#include "session/rig_file.h"

namespace sixdial::cli {
namespace {

struct AdoptOptions {
  std::string subject, rig_file, output;
  std::vector<std::string> only;
};

struct Found {
  studies::CalibrationResult result;
  std::string from;  // "session monday, result 3"
};

Found found_result(Cli& cli, const std::string& subject) {
  std::error_code ignored;
  if (std::filesystem::is_regular_file(subject, ignored)) {
    Found found{report::calibration_from_json(read_document(subject)), ""};
    found.from = fmt::format("session {}", found.result.inputs.session);
    return found;
  }
  const auto number =
      cli.call("result.get", {{"session", subject}})["result"].get<std::int64_t>();
  return {
      report::calibration_from_json(fetch_result(cli, number)),
      fmt::format("session {}, result {}", subject, number)};
}

std::vector<session::AdoptedFigure> figures_of(
    const Found& found, const geometry::Rig& rig, const std::vector<std::string>& only) {
  std::vector<session::AdoptedFigure> figures;
  for (const studies::ParameterRow& row : found.result.parameters) {
    if (!only.empty() && std::ranges::find(only, row.name) == only.end()) continue;
    const auto info = std::ranges::find_if(
        rig.robot.model->parameters, [&](const auto& each) { return each.name == row.name; });
    if (info == rig.robot.model->parameters.end() || info->rig_key.empty()) continue;
    if (!(row.sd > 0.0)) continue;  // held: nothing was found
    const double per = info->shown_unit == "deg" ? geometry::kDegPerRad : 1.0;
    figures.push_back(
        {.key = info->rig_key, .value = row.identified * per, .sd = row.sd * per});
  }
  for (const std::string& name : only) {
    if (std::ranges::find(found.result.parameters, name, &studies::ParameterRow::name) !=
        found.result.parameters.end()) {
      continue;
    }
    throw service::Error(
        service::ErrorCode::kInvalidParams,
        fmt::format("the calibration has no parameter {}", name), {{"param", "--only"}},
        "sixdial report shows their names.");
  }
  return figures;
}

service::ExitCode adopt(Cli& cli, const AdoptOptions& options) {
  const std::string text = session::read_file(options.rig_file);
  const geometry::Rig rig = session::parse_rig(text, options.rig_file);
  const Found found = found_result(cli, options.subject);
  const std::vector<session::AdoptedFigure> figures = figures_of(found, rig, options.only);
  const std::string adopted = session::with_adopted(
      text, options.rig_file, figures,
      fmt::format("{}, {}", found.from, found.result.created_utc.substr(0, 10)));
  session::write_file(options.output, adopted);
  Json rows = Json::array();
  std::string said;
  for (const session::AdoptedFigure& figure : figures) {
    rows.push_back(
        {{"key", figure.key}, {"value", figure.value}, {"expanded_k2", 2.0 * figure.sd}});
    said += fmt::format(
        "{} = {:.6f}, expanded uncertainty {:.6f} (k = 2)\n", figure.key, figure.value,
        2.0 * figure.sd);
  }
  cli.console.print("rig.adopt", {{"path", options.output}, {"figures", rows}}, said);
  cli.console.note(fmt::format(
      "{} figures in {}; sessions made with it begin from there. Sessions that exist keep "
      "theirs.",
      figures.size(), options.output));
  return service::ExitCode::kOk;
}

}  // namespace

void add_rig_adopt(CLI::App& group, Cli& cli) {
  CLI::App* command = group.add_subcommand(
      "adopt",
      "Writes a new rig file with the geometry that a calibration found, each figure with its "
      "uncertainty.");
  const auto options = std::make_shared<AdoptOptions>();
  command
      ->add_option(
          "SESSION|RESULT", options->subject,
          "a calibrated session of the service, or a file of sixdial calibrate -o")
      ->required();
  command->add_option("--rig", options->rig_file, "the rig file to begin with")
      ->required()
      ->check(existing_file());
  command->add_option("-o,--output", options->output, "the new rig file")->required();
  command
      ->add_option(
          "--only", options->only, "parameters to take, such as d,alpha; default: all found")
      ->delimiter(',');
  command->callback(
      [&cli, options] { cli.action = [&cli, options] { return adopt(cli, *options); }; });
}

}  // namespace sixdial::cli
