// sixdial plan grid|random: a plan file for a rig file, without a service.
#include <fmt/format.h>

#include "service/cli/cli.h"
#include "session/csv.h"
#include "session/plan.h"
#include "session/rig_file.h"

namespace sixdial::service::cli {
namespace {

struct PlanCommand {
  std::string rig_file, output, approach, mode;
  int nx = 10, ny = 10, count = 50;
  std::vector<double> rectangle_mm;
  bool serpentine = false;
  session::PlanOptions options;
};

void add_common(CLI::App& command, PlanCommand& plan) {
  command.add_option("--rig", plan.rig_file, "rig.toml")->required();
  command.add_option("-o,--output", plan.output, "the plan file; default: stdout");
  command.add_option("--set", plan.options.set, "G1, G2 or another name")
      ->capture_default_str();
  command.add_option("--repeats", plan.options.repeats, "readings of each point")
      ->check(CLI::Range(1, 1000))
      ->capture_default_str();
  command.add_option("--seed", plan.options.seed, "of order and places")->capture_default_str();
  command.add_option("--margin", plan.options.margin_mm, "mm kept free inside the edge")
      ->check(CLI::NonNegativeNumber);
  command.add_option("--first-point", plan.options.first_point, "number of the first point");
  command
      .add_option("--rectangle", plan.rectangle_mm, "x0 y0 x1 y1 in mm; default 16 30 40 66")
      ->expected(4);
  command.add_option("--approach", plan.approach, "from which side points are reached")
      ->check(CLI::IsMember({"as-it-comes", "alternate", "both-sides"}));
  command.add_option("--mode", plan.mode, "working mode; default: the rig's")
      ->check(CLI::IsMember({"++", "+-", "-+", "--"}));
}

session::PlanOptions finished(const PlanCommand& plan) {
  session::PlanOptions options = plan.options;
  if (plan.rectangle_mm.size() == 4) {
    options.rectangle.min_mm = {plan.rectangle_mm[0], plan.rectangle_mm[1]};
    options.rectangle.max_mm = {plan.rectangle_mm[2], plan.rectangle_mm[3]};
  }
  if (!plan.approach.empty()) options.approach = *session::approach_rule_from(plan.approach);
  if (!plan.mode.empty()) options.working_mode = geometry::working_mode_from(plan.mode);
  options.shuffle = !plan.serpentine;
  return options;
}

ExitCode write(
    Cli& cli, const PlanCommand& command,
    const tl::expected<session::Plan, session::PlanRefusal>& plan) {
  if (!plan) {
    throw Error(
        ErrorCode::kBadData, "the plan is refused: " + session::describe(plan.error()),
        {{"point", plan.error().point}}, plan.error().advice);
  }
  const std::string text = session::plan_csv(*plan);
  if (!command.output.empty()) session::write_file(command.output, text);
  if (cli.console.json) {
    Json answer{{"points", plan->points.size()}};
    if (command.output.empty()) {
      answer["plan_csv"] = text;
    } else {
      answer["file"] = command.output;
    }
    cli.console.print_json("plan", answer);
  } else if (command.output.empty()) {
    cli.console.out << text;
  } else {
    cli.console.note(fmt::format("{} points in {}", plan->points.size(), command.output));
  }
  return ExitCode::kOk;
}

}  // namespace

void add_plan_commands(CLI::App& app, Cli& cli) {
  CLI::App* group =
      app.add_subcommand("plan", "What to measure, as a CSV file people can edit.");
  group->require_subcommand(1);
  const auto plan = std::make_shared<PlanCommand>();

  CLI::App* grid = group->add_subcommand("grid", "A grid of targets that the rig can measure.");
  add_common(*grid, *plan);
  grid->add_option("--nx", plan->nx, "points along x")
      ->check(CLI::Range(1, 1000))
      ->capture_default_str();
  grid->add_option("--ny", plan->ny, "points along y")
      ->check(CLI::Range(1, 1000))
      ->capture_default_str();
  grid->add_flag("--serpentine", plan->serpentine, "in the grid's order instead of shuffled");
  grid->callback([&cli, plan] {
    cli.action = [&cli, plan] {
      const auto rig = session::read_rig_file(plan->rig_file);
      return write(cli, *plan, session::plan_grid(rig, plan->nx, plan->ny, finished(*plan)));
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
      return write(cli, *plan, session::plan_random(rig, plan->count, finished(*plan)));
    };
  });
}

}  // namespace sixdial::service::cli
