// sixdial plan grid|random|rig-check: a plan file for a rig file, without a service; plan next,
// plan separate: what to measure after what a session has told. plan sockets:
// plan_sockets_command.cpp.
#include <fmt/format.h>

#include "cli/cli.h"
#include "cli/plan_output.h"
#include "cli/shared_options.h"
#include "report/documents/plan_json.h"
#include "report/words/plan_words.h"
#include "session/plan.h"
#include "session/rig_file.h"
#include "session/usual_approach.h"

namespace sixdial::cli {
namespace {

struct PlanCommand {
  std::string rig_file, output, approach;
  std::vector<std::string> modes;
  int nx = 10, ny = 10, count = 50;
  std::vector<double> rectangle_mm, box_mm;
  bool serpentine = false;
  session::PlanOptions options;
};

void add_modes(CLI::App& command, std::vector<std::string>& modes, const std::string& help) {
  command.add_option("--mode", modes, help)
      ->delimiter(',')
      ->allow_extra_args(false)
      ->check(working_mode_words());
}

void add_common(CLI::App& command, PlanCommand& plan) {
  command.add_option("--rig", plan.rig_file, "rig.toml")->required();
  command.add_option("-o,--output", plan.output, "the plan file; default: stdout");
  command.add_option("--set", plan.options.set, "G1, G2 or another name")
      ->capture_default_str();
  command.add_option("--repeats", plan.options.repeats, "how often each point is measured")
      ->check(CLI::Range(1, 1000))
      ->capture_default_str();
  add_seed(
      command, plan.options.seed, "of the random numbers; the same seed gives the same plan");
  command
      .add_option(
          "--margin", plan.options.margin_mm,
          "mm to stay away from the edge of what can be measured")
      ->check(CLI::NonNegativeNumber);
  command.add_option("--first-point", plan.options.first_point, "number of the first point")
      ->check(CLI::NonNegativeNumber);
  command
      .add_option(
          "--rectangle", plan.rectangle_mm,
          "x0 y0 x1 y1 in mm, of a robot in the plane; default 16 30 40 66")
      ->expected(4);
  command
      .add_option(
          "--box", plan.box_mm,
          "x0 y0 z0 x1 y1 z1 in mm, of a robot in space; without it plan random draws joint "
          "values within the ranges of rig.toml")
      ->expected(6);
  command
      .add_option(
          "--approach", plan.approach,
          "from which side points are reached; default: as it comes, alternate where the robot "
          "is "
          "moved by hand")
      ->check(CLI::IsMember({"as-it-comes", "alternate", "both-sides"}));
  add_modes(
      command, plan.modes,
      "working modes, as in --mode=++,-+: elbow sides of leg 1 and leg 2, each mode with all "
      "the points; default: the rig's");
}

std::vector<geometry::WorkingMode> modes_of(const std::vector<std::string>& words) {
  std::vector<geometry::WorkingMode> modes;
  modes.reserve(words.size());
  for (const std::string& word : words) modes.push_back(*geometry::working_mode_from(word));
  return modes;
}

session::PlanOptions finished(const PlanCommand& plan, const geometry::Rig& rig) {
  session::PlanOptions options = plan.options;
  options.approach = session::usual_approach(rig);
  if (plan.rectangle_mm.size() == 4) {
    options.rectangle.min_mm = {plan.rectangle_mm[0], plan.rectangle_mm[1]};
    options.rectangle.max_mm = {plan.rectangle_mm[2], plan.rectangle_mm[3]};
  }
  if (!plan.rectangle_mm.empty() && rig.robot.model->axes == 3) {
    throw service::Error(
        service::ErrorCode::kInvalidParams, "this robot works in space, a rectangle is flat",
        {{"param", "rectangle"}}, "give --box x0 y0 z0 x1 y1 z1");
  }
  if (plan.box_mm.size() == 6) {
    const std::vector<double>& of = plan.box_mm;
    options.box = session::TargetBox{{of[0], of[1], of[2]}, {of[3], of[4], of[5]}};
  }
  if (!plan.approach.empty()) options.approach = *session::approach_rule_from(plan.approach);
  options.working_modes = modes_of(plan.modes);
  options.shuffle = !plan.serpentine;
  return options;
}

service::ExitCode write(
    Cli& cli, const PlanCommand& command, const geometry::Rig& rig,
    const tl::expected<session::Plan, session::PlanRefusal>& plan) {
  if (!plan) {
    throw service::Error(
        service::ErrorCode::kBadData, "the plan is refused: " + session::describe(plan.error()),
        {{"point", plan.error().point}}, plan.error().advice);
  }
  return write_plan(
      cli, command.output, session::plan_csv(*plan, rig), plan->points.size(),
      session::operator_notes(rig, *plan), Json::object());
}

struct NextCommand {
  std::string subject, output, criterion = "I";
  int points = 10;
  std::vector<std::string> modes;
};

/// `answer`: of plan.next or plan.separate, or the same made here.
service::ExitCode write(
    Cli& cli, const NextCommand& command, Json answer, int points, const std::string& words) {
  if (!cli.console.json) cli.console.note(words);
  const auto plan_csv = answer["plan_csv"].get<std::string>();
  const auto notes = answer["notes"].get<std::vector<std::string>>();
  answer.erase("plan_csv");
  return write_plan(
      cli, command.output, plan_csv, static_cast<std::size_t>(points), notes,
      std::move(answer));
}

service::ExitCode next(Cli& cli, const NextCommand& command) {
  Json answer;
  if (is_bundle(command.subject)) {
    const session::Session session = read_bundle_with_warnings(cli, command.subject, false);
    studies::NextPlanRequest request;
    request.points = command.points;
    request.criterion = *calibration::criterion_from(command.criterion);
    request.modes = modes_of(command.modes);
    answer = report::plan_answer(studies::next_plan(session, request), session.rig);
  } else {
    answer = cli.call(
        "plan.next", {{"session", command.subject},
                      {"points", command.points},
                      {"criterion", command.criterion},
                      {"modes", command.modes}});
  }
  const studies::NextPlanFigures figures = report::next_plan_from_json(answer);
  return write(
      cli, command, std::move(answer), figures.points, report::next_plan_text(figures));
}

service::ExitCode separate(Cli& cli, const NextCommand& command) {
  Json answer;
  if (is_bundle(command.subject)) {
    const session::Session session = read_bundle_with_warnings(cli, command.subject, false);
    studies::SeparationRequest request;
    request.points = command.points;
    request.modes = modes_of(command.modes);
    answer = report::plan_answer(studies::separation_plan(session, request), session.rig);
  } else {
    answer = cli.call(
        "plan.separate",
        {{"session", command.subject}, {"points", command.points}, {"modes", command.modes}});
  }
  const studies::SeparationFigures figures = report::separation_from_json(answer);
  return write(
      cli, command, std::move(answer), figures.points, report::separation_text(figures));
}

void add_separate_command(CLI::App& group, Cli& cli) {
  CLI::App* command = group.add_subcommand("separate", summary_of("plan.separate"));
  const auto options = std::make_shared<NextCommand>();
  options->points = studies::SeparationRequest{}.points;
  add_subject(*command, options->subject);
  add_point_count(*command, options->points);
  add_modes(
      *command, options->modes,
      "working modes to measure in, as in --mode=++,-+; default: all that can be measured");
  command->add_option("-o,--output", options->output, "the plan file; default: stdout");
  command->callback(
      [&cli, options] { cli.action = [&cli, options] { return separate(cli, *options); }; });
}

struct RigCheckCommand {
  std::string rig_file;
  NextCommand plan;  // its subject is the rig file
  std::vector<double> rectangle_mm;
};

service::ExitCode rig_check(Cli& cli, const RigCheckCommand& command) {
  const geometry::Rig rig = session::read_rig_file(command.rig_file);
  studies::RigCheckRequest request;
  request.points = command.plan.points;
  request.modes = modes_of(command.plan.modes);
  if (command.rectangle_mm.size() == 4) {
    request.rectangle.min_mm = {command.rectangle_mm[0], command.rectangle_mm[1]};
    request.rectangle.max_mm = {command.rectangle_mm[2], command.rectangle_mm[3]};
  }
  const studies::RigCheck made = studies::rig_check(rig, request);
  return write(
      cli, command.plan, report::plan_answer(made, rig), made.figures.points,
      report::rig_check_text(made.figures));
}

void add_rig_check_command(CLI::App& group, Cli& cli) {
  CLI::App* command = group.add_subcommand(
      "rig-check",
      "Poses that tell where the dials stand apart from the robot, and how many points buy how "
      "much.");
  const auto options = std::make_shared<RigCheckCommand>();
  options->plan.points = studies::RigCheckRequest{}.points;
  command->add_option("--rig", options->rig_file, "rig.toml")->required();
  add_point_count(*command, options->plan.points);
  add_modes(
      *command, options->plan.modes,
      "working modes to measure in, as in --mode=++,-+; default: the rig's");
  command
      ->add_option(
          "--rectangle", options->rectangle_mm, "x0 y0 x1 y1 in mm; default 16 30 40 66")
      ->expected(4);
  command->add_option("-o,--output", options->plan.output, "the plan file; default: stdout");
  command->callback(
      [&cli, options] { cli.action = [&cli, options] { return rig_check(cli, *options); }; });
}

void add_next_command(CLI::App& group, Cli& cli) {
  CLI::App* command = group.add_subcommand("next", summary_of("plan.next"));
  const auto options = std::make_shared<NextCommand>();
  add_subject(*command, options->subject);
  add_point_count(*command, options->points);
  command
      ->add_option(
          "--criterion", options->criterion,
          "I: the tool's position over the workspace, D: all parameters")
      ->check(CLI::IsMember({"I", "D"}))
      ->capture_default_str();
  add_modes(
      *command, options->modes,
      "working modes to measure in, as in --mode=++,-+; default: those of the session");
  command->add_option("-o,--output", options->output, "the plan file; default: stdout");
  command->callback(
      [&cli, options] { cli.action = [&cli, options] { return next(cli, *options); }; });
}

}  // namespace

void add_plan_commands(CLI::App& app, Cli& cli) {
  CLI::App* group =
      app.add_subcommand("plan", "What to measure, as a CSV file people can edit.");
  group->require_subcommand(1);
  add_next_command(*group, cli);
  add_separate_command(*group, cli);
  add_rig_check_command(*group, cli);
  add_sockets_command(*group, cli);
  const auto plan = std::make_shared<PlanCommand>();

  CLI::App* grid = group->add_subcommand("grid", "A grid of targets that the rig can measure.");
  add_common(*grid, *plan);
  grid->add_option("--nx", plan->nx, "points along x")
      ->check(CLI::Range(1, 1000))
      ->capture_default_str();
  grid->add_option("--ny", plan->ny, "points along y")
      ->check(CLI::Range(1, 1000))
      ->capture_default_str();
  grid->add_option("--nz", plan->options.nz, "layers of a box, from z0 to z1; 1: halfway")
      ->check(CLI::Range(1, 1000))
      ->capture_default_str();
  grid->add_flag("--serpentine", plan->serpentine, "in the grid's order instead of shuffled");
  grid->callback([&cli, plan] {
    cli.action = [&cli, plan] {
      const auto rig = session::read_rig_file(plan->rig_file);
      return write(
          cli, *plan, rig, session::plan_grid(rig, plan->nx, plan->ny, finished(*plan, rig)));
    };
  });

  CLI::App* random =
      group->add_subcommand("random", "Random targets that the rig can measure.");
  add_common(*random, *plan);
  random->add_option("--count", plan->count, "points")
      ->check(CLI::Range(1, 100000))
      ->capture_default_str();
  random->callback([&cli, plan] {
    cli.action = [&cli, plan] {
      const auto rig = session::read_rig_file(plan->rig_file);
      return write(
          cli, *plan, rig, session::plan_random(rig, plan->count, finished(*plan, rig)));
    };
  });
}

}  // namespace sixdial::cli
