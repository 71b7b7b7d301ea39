// sixdial rig adopt: the geometry that a calibration found goes back into a rig file, each
// figure with its uncertainty. Comments and everything else stay as they are.
#include "session/rig_adopt.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <memory>
#include <utility>

#include "cli/cli.h"
#include "cli/shared_options.h"
#include "geometry/units.h"
#include "report/documents/calibration_json.h"
#include "session/csv.h"
#include "session/rig_file.h"
#include "session/sha256.h"
#include "studies/seen_rig.h"

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

/// With --only: where the dials stand, and the side of the cuboid.
constexpr std::string_view kDials = "dials";

/// Places of dials that were found count from the file that the calibration read.
void refuse_another_file(
    const Found& found, const std::string& text, const std::string& rig_file) {
  const std::string& read = found.result.inputs.rig_hash;
  if (read.empty() || read == "sha256:" + session::sha256(text)) return;
  throw service::Error(
      service::ErrorCode::kInvalidParams,
      fmt::format(
          "{} is not the rig file that {} was calibrated with: the places of the dials that "
          "were found count from that one",
          rig_file, found.from),
      {{"param", "--rig"}},
      "Give the session's own rig file (\"sixdial session export SESSION FOLDER\" writes it), "
      "or take "
      "parameters of the robot alone, with --only.");
}

/// The standard deviation to write: what is common to dials stays common in the readings, but a
/// rig file knows each figure by itself. n figures of a kind, taken as independent with sqrt(n)
/// times their standard deviation, are never better known together than they are, and none is
/// less well known than was stated.
double sd_to_write(const diagnosis::RigSeen& row, const std::vector<diagnosis::RigSeen>& all) {
  const auto kind_of = [](const std::string& name) {
    const std::size_t at = name.find(" of dial ");
    if (at == std::string::npos) return name;
    const std::size_t end = name.find(' ', at + std::string_view(" of dial ").size());
    return name.substr(0, at) + (end == std::string::npos ? "" : name.substr(end));
  };
  const auto of_kind = std::ranges::count_if(
      all, [&](const auto& each) { return kind_of(each.name) == kind_of(row.name); });
  return std::min(row.known_sd, row.sd * std::sqrt(static_cast<double>(of_kind)));
}

/// Where the dials were found, as well as that is known now. The parameters hold for these
/// places: who takes the ones takes the others.
std::vector<session::AdoptedFigure> dials_of(
    const studies::CalibrationResult& result, const geometry::Rig& rig,
    const std::vector<std::string>& only) {
  std::vector<session::AdoptedFigure> figures;
  if (!result.rig || result.rig->empty()) return figures;
  if (!only.empty() && std::ranges::find(only, kDials) == only.end()) return figures;
  const geometry::Rig seen = studies::rig_as_seen(rig, result.rig);
  const auto sd_of = [&](const std::string& name) -> std::optional<double> {
    const auto row = std::ranges::find(*result.rig, name, &diagnosis::RigSeen::name);
    return row == result.rig->end() ? std::nullopt
                                    : std::optional(sd_to_write(*row, *result.rig));
  };
  const auto add = [&](const std::string& dial, const std::string& key,
                       std::vector<double> value) {
    session::AdoptedFigure figure{.key = key, .value = std::move(value), .dial = dial};
    if (dial.empty()) figure.table = "cuboid";
    figures.push_back(std::move(figure));
  };
  for (const geometry::Dial& dial : seen.dials) {
    const geometry::DialGeometry& at = dial.geometry;
    const auto along = sd_of(fmt::format("place of dial {} along its axis", dial.id));
    const auto across = sd_of(fmt::format("place of dial {} across its axis", dial.id));
    if (along || across) {
      add(dial.id, "position_mm", {at.position_mm.x(), at.position_mm.y()});
      add(dial.id, "position_sd_mm", {along.value_or(0.0), across.value_or(0.0)});
    }
    if (const auto sd = sd_of(fmt::format("axis of dial {}", dial.id))) {
      add(dial.id, "axis", {at.axis.x(), at.axis.y()});
      add(dial.id, "axis_sd_deg", {*sd * geometry::kDegPerRad});
    }
    if (const auto sd = sd_of(fmt::format("tip radius of dial {}", dial.id))) {
      add(dial.id, "tip_radius_mm", {at.tip_radius_mm});
      add(dial.id, "tip_radius_sd_mm", {*sd});
    }
  }
  if (const auto sd = sd_of("side of the cuboid")) {
    add("", "side_mm", {seen.cuboid.side_mm});
    add("", "side_sd_mm", {*sd});
  }
  return figures;
}

std::vector<session::AdoptedFigure> figures_of(
    const Found& found, const geometry::Rig& rig, const std::vector<std::string>& only) {
  std::vector<session::AdoptedFigure> figures = dials_of(found.result, rig, only);
  for (const studies::ParameterRow& row : found.result.parameters) {
    if (!only.empty() && std::ranges::find(only, row.name) == only.end()) continue;
    const auto info = std::ranges::find_if(
        rig.robot.model->parameters, [&](const auto& each) { return each.name == row.name; });
    if (info == rig.robot.model->parameters.end() || info->rig_key.empty()) continue;
    if (!(row.sd > 0.0)) continue;  // held: nothing was found
    const double per = info->shown_unit == "deg" ? geometry::kDegPerRad : 1.0;
    figures.push_back(
        {.key = info->rig_key, .value = {row.identified * per}, .sd = row.sd * per});
  }
  for (const std::string& name : only) {
    if (name == kDials) continue;
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
  const bool of_dials = std::ranges::any_of(
      figures, [](const session::AdoptedFigure& each) { return !(each.sd > 0.0); });
  if (of_dials) refuse_another_file(found, text, options.rig_file);
  if (!of_dials && std::ranges::find(options.only, kDials) != options.only.end()) {
    throw service::Error(
        service::ErrorCode::kInvalidParams,
        fmt::format("{} found no places of dials", found.from), {{"param", "--only"}},
        "State in the rig file how well they are known (position_sd_mm), and calibrate again.");
  }
  if (!of_dials && found.result.rig && !found.result.rig->empty()) {
    cli.console.note(
        "The parameters hold for the places of the dials that were found with them: take "
        "\"dials\" too.");
  }
  const std::string adopted = session::with_adopted(
      text, options.rig_file, figures,
      fmt::format("{}, {}", found.from, found.result.created_utc.substr(0, 10)));
  session::write_file(options.output, adopted);
  Json rows = Json::array(), of_rig = Json::array();
  std::string said;
  for (const session::AdoptedFigure& figure : figures) {
    if (figure.sd > 0.0) {
      rows.push_back(
          {{"key", figure.key}, {"value", figure.value[0]}, {"expanded_k2", 2.0 * figure.sd}});
      said += fmt::format(
          "{} = {:.6f}, expanded uncertainty {:.6f} (k = 2)\n", figure.key, figure.value[0],
          2.0 * figure.sd);
    } else {
      const std::string part = figure.dial.empty() ? figure.table : "dial " + figure.dial;
      of_rig.push_back({{"part", part}, {"key", figure.key}, {"value", figure.value}});
      said += fmt::format("{} {} = {:.6f}\n", part, figure.key, fmt::join(figure.value, ", "));
    }
  }
  cli.console.print(
      "rig.adopt", {{"path", options.output}, {"figures", rows}, {"rig", of_rig}}, said);
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
          "--only", options->only,
          "parameters to take, such as d,alpha, or dials; default: all found")
      ->delimiter(',');
  command->callback(
      [&cli, options] { cli.action = [&cli, options] { return adopt(cli, *options); }; });
}

}  // namespace sixdial::cli
