// sixdial plan sockets: poses that calibrate an arm by a ball in sockets, without a service; on
// request the folder of a session that they are written down in.
#include <fmt/format.h>

#include <filesystem>
#include <memory>
#include <tuple>
#include <utility>

#include "cli/cli.h"
#include "cli/plan_output.h"
#include "cli/shared_options.h"
#include "report/documents/plan_json.h"
#include "report/words/plan_words.h"
#include "session/csv.h"
#include "session/plan_sheet.h"
#include "session/rig_file.h"
#include "session/rig_write.h"
#include "session/traceability.h"
#include "studies/socket_plan.h"

namespace sixdial::cli {
namespace {

struct SocketsCommand {
  std::string rig_file, output, bundle, criterion = "D";
  std::vector<std::tuple<double, double, double>> at_mm;
  std::vector<double> axis, stem;
  double cone_deg = 45.0;
  studies::SocketPlanRequest request;
};

Eigen::Vector3d triple(const std::vector<double>& of) { return {of[0], of[1], of[2]}; }

studies::SocketPlanRequest finished(const SocketsCommand& command) {
  studies::SocketPlanRequest request = command.request;
  for (const auto& [x, y, z] : command.at_mm) request.at_mm.emplace_back(x, y, z);
  if (!command.axis.empty()) request.seat.axis = triple(command.axis);
  if (!command.stem.empty()) request.seat.stem = triple(command.stem);
  request.seat.cone_rad = command.cone_deg * geometry::kRadPerDeg;
  request.criterion = *calibration::criterion_from(command.criterion);
  return request;
}

/// The rig file with the sockets: as it was written and the tables below it, where it had none.
std::string rig_with_sockets(const std::string& rig_file, const geometry::Rig& rig) {
  const std::string text = session::read_file(rig_file);
  if (!rig.robot.model->from_other_file) {
    std::string whole = text;
    if (!whole.empty() && whole.back() != '\n') whole += '\n';
    whole += session::instrument_text(rig);
    try {
      static_cast<void>(session::parse_rig(whole, rig_file));
      return whole;
    } catch (const session::DataError&) {
      // It has an [instrument] already, which these tables stand for.
    }
  }
  return session::write_rig(rig, session::traceability_of(text));
}

/// rig.toml, plan.csv, poses.csv to print, and session.csv to be filled in.
void start_bundle(const SocketsCommand& command, const studies::SocketPlan& made) {
  const std::filesystem::path folder(command.bundle);
  const auto file = [&](const char* name) { return (folder / name).string(); };
  std::error_code trouble;
  if (std::filesystem::exists(file("session.csv"), trouble)) {
    throw service::Error(
        service::ErrorCode::kInvalidParams,
        fmt::format("{} is there already: nothing is written over it", file("session.csv")),
        {{"param", "bundle"}}, "Give a new folder.");
  }
  std::filesystem::create_directories(folder, trouble);
  session::write_file(file("rig.toml"), rig_with_sockets(command.rig_file, made.rig));
  session::write_file(file("plan.csv"), session::plan_csv(made.plan, made.rig));
  session::write_file(file("poses.csv"), session::pose_sheet(made.plan, made.rig));
  session::write_file(file("session.csv"), session::empty_session(made.plan, made.rig));
}

service::ExitCode plan_sockets(Cli& cli, const SocketsCommand& command) {
  const geometry::Rig arm = session::read_rig_file(command.rig_file);
  const studies::SocketPlan made = studies::socket_plan(arm, finished(command));
  Json answer = report::plan_answer(made);
  const auto plan_csv = answer["plan_csv"].get<std::string>();
  auto notes = answer["notes"].get<std::vector<std::string>>();
  answer.erase("plan_csv");
  std::string output = command.output;
  if (!command.bundle.empty()) {
    start_bundle(command, made);
    if (output.empty()) output = (std::filesystem::path(command.bundle) / "plan.csv").string();
    notes.push_back(fmt::format(
        "{0}/poses.csv says in degrees where to go; write the joint values that you read into "
        "{0}/session.csv, then sixdial calibrate {0}",
        command.bundle));
  }
  if (!cli.console.json) {
    cli.console.note(report::socket_plan_text(made.figures));
    if (command.bundle.empty()) {
      cli.console.note("For rig.toml:" + answer["rig_toml"].get<std::string>());
    }
  }
  return write_plan(cli, output, plan_csv, made.plan.points.size(), notes, std::move(answer));
}

void add_places(CLI::App& command, SocketsCommand& options) {
  command
      .add_option(
          "--at", options.at_mm,
          "X Y Z: where the ball's centre will be in a socket, mm in the frame of rig.toml, to "
          "a "
          "few centimetres; once for each socket")
      ->required();
  command
      .add_option(
          "--distance", options.request.distance_mm,
          "mm: known distance of the first and second socket, of the third and fourth, and so "
          "on; default: distance_mm of [[socket]]")
      ->check(CLI::PositiveNumber);
  command
      .add_option("--distance-sd", options.request.distance_sd_mm, "mm: how well that is known")
      ->check(CLI::PositiveNumber)
      ->capture_default_str();
  command
      .add_option(
          "--seat-sd", options.request.seat_sd_mm,
          "mm: how closely the ball comes back to where it sat, joint readings included; "
          "default: sd_mm of [instrument], else 0.1")
      ->check(CLI::PositiveNumber);
  command
      .add_option(
          "--cone", options.cone_deg,
          "degrees that the ball's stem may lean from the socket's axis")
      ->check(CLI::Range(1.0, 90.0))
      ->capture_default_str();
  command
      .add_option(
          "--axis", options.axis,
          "X Y Z: out of the sockets, in the frame of rig.toml; default: 0 0 1, up")
      ->expected(3);
  command
      .add_option(
          "--stem", options.stem,
          "X Y Z: from the flange towards the ball, in the tool's frame; default: 0 0 1")
      ->expected(3);
}

}  // namespace

void add_sockets_command(CLI::App& group, Cli& cli) {
  CLI::App* command = group.add_subcommand(
      "sockets",
      "Poses that calibrate an arm by a ball on its tool and two or more sockets, without an "
      "instrument, and what they would tell.");
  const auto options = std::make_shared<SocketsCommand>();
  studies::SocketPlanRequest& request = options->request;
  command->add_option("--rig", options->rig_file, "rig.toml")->required();
  add_places(*command, *options);
  command->add_option("--count", request.count, "poses of each socket that are fitted, set G1")
      ->check(CLI::Range(1, 1000))
      ->capture_default_str();
  command
      ->add_option(
          "--g2", request.to_judge,
          "poses of each socket more that are not, set G2: they judge the fit")
      ->check(CLI::Range(0, 1000))
      ->capture_default_str();
  command
      ->add_option(
          "--criterion", options->criterion,
          "D: poses that tell most of all parameters, I: of the tool's position in the joints' "
          "ranges")
      ->check(CLI::IsMember({"I", "D"}))
      ->capture_default_str();
  add_seed(*command, request.seed, "of the drawn poses; the same seed gives the same plan");
  command->add_option("-o,--output", options->output, "the plan file; default: stdout");
  command->add_option(
      "--bundle", options->bundle,
      "a new folder for the session: rig.toml with the sockets, plan.csv, poses.csv in "
      "degrees, "
      "and session.csv to be filled in");
  command->callback([&cli, options] {
    cli.action = [&cli, options] { return plan_sockets(cli, *options); };
  });
}

}  // namespace sixdial::cli
