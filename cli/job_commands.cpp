// sixdial job list|status|wait|cancel, and how a job is followed on the terminal.
#include <fmt/format.h>

#include "cli/cli.h"

namespace sixdial::cli {
namespace {

std::string text_of(const Json& json, const char* key) {
  const Json& value = json.at(key);
  return value.is_string() ? value.get<std::string>() : value.is_null() ? "-" : value.dump();
}

std::string job_text(const Json& job) {
  const Json& progress = job["progress"];
  std::string text = fmt::format(
      "job {}: {} of session {}, {}", job["job"].get<std::int64_t>(), text_of(job, "kind"),
      text_of(job, "session"), text_of(job, "state"));
  if (job["state"] == "running") {
    text += fmt::format(
        ", {} {}/{}", text_of(progress, "stage"), progress["done"].get<std::int64_t>(),
        progress["total"].get<std::int64_t>());
  }
  if (job["result"].is_number()) text += fmt::format(", result {}", job["result"].dump());
  if (job["error"].is_object()) text += fmt::format(": {}", text_of(job["error"], "message"));
  return text + "\n";
}

void show_progress(ProgressLine& line, const Json& job) {
  const Json& progress = job["progress"];
  if (progress["total"].get<std::int64_t>() == 0) return;
  const Json& best = progress["best_mm"];
  line.show(
      progress["stage"].get<std::string>(), progress["done"].get<std::int64_t>(),
      progress["total"].get<std::int64_t>(),
      progress["eta_s"].is_null() ? std::nullopt
                                  : std::optional(progress["eta_s"].get<double>()),
      best.is_null() ? "" : fmt::format("best {:.6f} mm", best.get<double>()));
}

bool has_ended(const Json& job) {
  const std::string state = job["state"];
  return state != "queued" && state != "running";
}

void add_one_job_command(
    CLI::App& group, Cli& cli, const std::string& name, std::int64_t& job,
    const std::function<Json()>& ask) {
  CLI::App* command = group.add_subcommand(name, summary_of("job." + name));
  command->add_option("JOB", job, "number of the job")->required();
  command->callback([&cli, name, ask] {
    cli.action = [&cli, name, ask] {
      const Json answer = ask();
      cli.console.print("job", answer, job_text(answer));
      return service::ExitCode::kOk;
    };
  });
}

}  // namespace

Json follow_job(Cli& cli, std::int64_t job) {
  constexpr auto kLookAgain = std::chrono::milliseconds(2000);
  ProgressLine line(cli.console);
  static_cast<void>(cli.call("events.subscribe", {{"topics", {"job"}}}));
  Json status = cli.call("job.status", {{"job", job}});
  while (!has_ended(status)) {
    show_progress(line, status);
    std::optional<Json> event;
    try {
      event = cli.client().next_event(kLookAgain);
    } catch (const service::Interrupted&) {
      line.clear();
      cli.console.note(fmt::format(
          "job {0} goes on in the service and keeps its result: sixdial job wait {0} shows it, "
          "sixdial job cancel {0} ends it",
          job));
      throw;
    }
    if (!event || (*event)["method"] != "events.event") {
      status = cli.call("job.status", {{"job", job}});
    } else if ((*event)["params"]["data"].value("job", std::int64_t{0}) == job) {
      status = (*event)["params"]["data"];
    }
  }
  line.clear();
  if (status["state"] != "done") {
    if (status["error"].is_object()) throw service::RemoteError(status["error"]);
    throw service::Error(
        service::ErrorCode::kJobFailed,
        fmt::format("job {} was {}", job, text_of(status, "state")), {{"job", job}});
  }
  return status;
}

void add_job_commands(CLI::App& app, Cli& cli) {
  CLI::App* group = app.add_subcommand("job", "Long work in the service.");
  group->require_subcommand(1);
  CLI::App* list = group->add_subcommand("list", summary_of("job.list"));
  list->callback([&cli] {
    cli.action = [&cli] {
      const Json answer = cli.call("job.list");
      std::vector<std::vector<std::string>> rows;
      for (const Json& job : answer["jobs"]) {
        rows.push_back(
            {job["job"].dump(), text_of(job, "kind"), text_of(job, "session"),
             text_of(job, "state"), text_of(job, "result"), text_of(job, "created_utc"),
             text_of(job, "operator")});
      }
      cli.console.print(
          "job.list", answer,
          text_table({"job", "kind", "session", "state", "result", "asked for", "by"}, rows));
      return service::ExitCode::kOk;
    };
  });
  const auto job = std::make_shared<std::int64_t>(0);
  add_one_job_command(*group, cli, "status", *job, [&cli, job] {
    return cli.call("job.status", {{"job", *job}});
  });
  add_one_job_command(*group, cli, "cancel", *job, [&cli, job] {
    return cli.call("job.cancel", {{"job", *job}});
  });
  add_one_job_command(*group, cli, "wait", *job, [&cli, job] { return follow_job(cli, *job); });
}

}  // namespace sixdial::cli
