#include "cli/plan_output.h"

#include <fmt/format.h>

#include "session/csv.h"

namespace sixdial::cli {

service::ExitCode write_plan(
    Cli& cli, const std::string& output, const std::string& plan_csv, std::size_t points,
    const std::vector<std::string>& notes, Json answer) {
  if (!output.empty()) session::write_file(output, plan_csv);
  if (cli.console.json) {
    answer["points"] = points;
    answer["notes"] = notes;
    if (output.empty()) {
      answer["plan_csv"] = plan_csv;
    } else {
      answer["file"] = output;
    }
    cli.console.print_json("plan", answer);
    return service::ExitCode::kOk;
  }
  if (output.empty()) {
    cli.console.print_data(plan_csv);
  } else {
    cli.console.note(fmt::format("{} points in {}", points, output));
  }
  for (const std::string& note : notes) cli.console.note(note);
  return service::ExitCode::kOk;
}

}  // namespace sixdial::cli
