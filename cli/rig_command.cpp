// sixdial rig draw: the picture of a rig file; rig adopt stands in rig_adopt.cpp.
#include <fmt/format.h>

#include <memory>

#include "cli/cli.h"
#include "cli/shared_options.h"
#include "report/rig_picture.h"
#include "session/csv.h"
#include "session/rig_file.h"

namespace sixdial::cli {

void add_rig_commands(CLI::App& app, Cli& cli) {
  CLI::App* group = app.add_subcommand("rig", "The rig file and its devices.");
  group->require_subcommand(1);
  add_rig_adopt(*group, cli);
  CLI::App* draw = group->add_subcommand(
      "draw", "Draws robot, cuboid, dials and frames of a rig file as SVG.");
  const auto rig_file = std::make_shared<std::string>();
  const auto output = std::make_shared<std::string>();
  draw->add_option("RIG", *rig_file, "rig.toml")->required()->check(existing_file());
  draw->add_option("-o,--output", *output, "the SVG file; default: stdout");
  draw->callback([&cli, rig_file, output] {
    cli.action = [&cli, rig_file, output] {
      const std::string svg = report::rig_svg(session::read_rig_file(*rig_file));
      if (output->empty()) {
        cli.console.print("rig_picture", {{"svg", svg}}, svg);
        return service::ExitCode::kOk;
      }
      session::write_file(*output, svg);
      cli.console.print("rig_picture", {{"path", *output}}, *output + "\n");
      return service::ExitCode::kOk;
    };
  });
}

}  // namespace sixdial::cli
