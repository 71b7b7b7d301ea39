// sixdial import FILE...: files that people have, by a map, as a bundle; --guess writes a first
// map.
#include <fmt/format.h>

#include <filesystem>
#include <optional>

#include "cli/cli.h"
#include "session/bundle.h"
#include "session/csv.h"
#include "session/import.h"
#include "session/live_channels.h"
#include "session/rig_file.h"
#include "session/sample_layout.h"

namespace sixdial::cli {
namespace {

struct ImportCommand {
  std::vector<std::string> files;
  std::string map, output, rig;
  bool guess = false;
};

/// The rig that the map will name: beside the map, as the import looks for it, else where the
/// command was given. Empty: there is none.
std::optional<session::SampleLayout> layout_of_rig(const ImportCommand& command) {
  const auto beside_map = std::filesystem::path(command.output).parent_path() / command.rig;
  for (const std::filesystem::path& path : {beside_map, std::filesystem::path(command.rig)}) {
    std::error_code none;
    if (command.rig.empty() || !std::filesystem::is_regular_file(path, none)) continue;
    return session::layout_of(session::as_instrument(session::read_rig_file(path.string())));
  }
  return std::nullopt;
}

service::ExitCode guess(Cli& cli, const ImportCommand& command) {
  const std::string& file = command.files.front();
  const auto layout = layout_of_rig(command);
  const session::FirstMap map = session::guessed_map(
      {file, session::read_file(file)}, command.rig, layout ? &*layout : nullptr);
  for (const std::string& open : map.open) cli.console.note("look: " + open);
  if (!layout) {
    cli.console.note(
        command.rig.empty()
            ? "look: without --rig nothing is known of the robot's joints and the instrument"
            : fmt::format("look: there is no rig file {} yet", command.rig));
  }
  if (command.output.empty()) {
    cli.console.print_data(map.text);
  } else {
    session::write_file(command.output, map.text);
    cli.console.note(fmt::format("a first map is in {}: look at every line", command.output));
  }
  return service::ExitCode::kOk;
}

service::ExitCode import(Cli& cli, const ImportCommand& command) {
  if (command.guess) return guess(cli, command);
  if (command.map.empty() || command.output.empty()) {
    throw service::Error(
        service::ErrorCode::kInvalidParams, "an import needs a map and a folder",
        {{"param", command.map.empty() ? "map" : "output"}},
        "sixdial import FILE... --map map.toml -o FOLDER; --guess writes a first map");
  }
  const session::ImportMap map = session::read_import_map(command.map);
  const session::Imported imported = session::import_files(command.files, map);
  // Read as the next command reads it: what cannot be used is told now.
  const session::Session session = session::parse_session(
      imported.session_csv, "session.csv", imported.rig_toml, "rig.toml");
  const std::filesystem::path folder(command.output);
  session::write_bundle(session, folder);
  session::write_file((folder / "imported.toml").string(), imported.record);
  for (const std::string& note : imported.notes) cli.console.note(note);
  if (cli.console.json) {
    Json answer;
    answer["folder"] = command.output;
    answer["rows"] = imported.rows;
    answer["left_out"] = imported.left_out;
    answer["notes"] = imported.notes;
    cli.console.print_json("import", answer);
  } else {
    cli.console.note(fmt::format("{} rows are in {}", imported.rows, command.output));
  }
  return service::ExitCode::kOk;
}

}  // namespace

void add_import_command(CLI::App& app, Cli& cli) {
  CLI::App* command =
      app.add_subcommand("import", "files that people have, by a map, as a bundle");
  const auto options = std::make_shared<ImportCommand>();
  command->add_option("FILE", options->files, "text tables or YAML")->required();
  command->add_option("--map", options->map, "map.toml: what the columns are");
  command->add_option(
      "-o,--output", options->output, "the bundle's folder; of --guess the map");
  command->add_flag(
      "--guess", options->guess, "write a first map, and say what it took for what");
  command->add_option("--rig", options->rig, "of --guess: the rig file that the map names");
  command->callback(
      [&cli, options] { cli.action = [&cli, options] { return import(cli, *options); }; });
}

}  // namespace sixdial::cli
