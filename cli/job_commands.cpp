// sixdial job list|status|wait|cancel, and how a job is followed on the terminal.
#include <fmt/format.h>

#include "cli/cli.h"

namespace sixdial::cli {
namespace {

std::string job_text(const service::Job& job) {
  std::string text = fmt::format(
      "job {}: {} of session {}, {}", job.id, job.kind, job.session, to_string(job.state));
  if (job.state == service::JobState::kRunning) {
    text +=
        fmt::format(", {} {}/{}", job.progress.stage, job.progress.done, job.progress.total);
  }
  if (job.result_id) text += fmt::format(", result {}", *job.result_id);
  if (job.error.is_object()) {
    text += fmt::format(": {}", job.error.at("message").get<std::string>());
  }
  return text + "\n";
}

/// job.status of a job that has ended, whichever way.
Json ended_status(Cli& cli, std::int64_t id) {
  constexpr auto kLookAgain = std::chrono::milliseconds(2000);
  ProgressLine line(cli.console);
  static_cast<void>(cli.call("events.subscribe", {{"topics", {"job"}}}));
  Json status = cli.call("job.status", {{"job", id}});
  for (service::Job job = service::job_from_json(status); !is_final(job.state);
       job = service::job_from_json(status)) {
    if (job.progress.total != 0) line.show(job.progress);
    std::optional<Json> event;
    try {
      event = cli.client().next_event(kLookAgain);
    } catch (const service::Interrupted&) {
      line.clear();
      cli.console.note(fmt::format(
          "job {0} goes on in the service and keeps its result: sixdial job wait {0} shows it, "
          "sixdial job cancel {0} ends it",
          id));
      throw;
    }
    if (!event || (*event)["method"] != "events.event") {
      status = cli.call("job.status", {{"job", id}});
    } else if ((*event)["params"]["data"].value("job", std::int64_t{0}) == id) {
      status = (*event)["params"]["data"];
    }
  }
  return status;
}

/// Throws the job's error where it ended without a result.
service::Job done_job(const Json& status) {
  service::Job job = service::job_from_json(status);
  if (job.state == service::JobState::kDone) return job;
  if (job.error.is_object()) throw service::RemoteError(job.error);
  throw service::Error(
      service::ErrorCode::kJobFailed,
      fmt::format("job {} was {}", job.id, to_string(job.state)), {{"job", job.id}});
}

void add_one_job_command(
    CLI::App& group, Cli& cli, const std::string& name, std::int64_t& job,
    const std::function<Json()>& ask) {
  CLI::App* command = group.add_subcommand(name, summary_of("job." + name));
  command->add_option("JOB", job, "number of the job")->required();
  command->callback([&cli, name, ask] {
    cli.action = [&cli, name, ask] {
      const Json answer = ask();
      cli.console.print("job", answer, job_text(service::job_from_json(answer)));
      return service::ExitCode::kOk;
    };
  });
}

}  // namespace

service::Job follow_job(Cli& cli, std::int64_t job) { return done_job(ended_status(cli, job)); }

service::Job start_and_follow(Cli& cli, std::string_view method, const Json& params) {
  return follow_job(cli, service::job_from_json(cli.call(method, params)).id);
}

StoredResult run_job(Cli& cli, std::string_view method, const Json& params) {
  const std::int64_t number = start_and_follow(cli, method, params).result_id.value();
  return {.number = number, .document = fetch_result(cli, number)};
}

void add_job_commands(CLI::App& app, Cli& cli) {
  CLI::App* group = app.add_subcommand("job", "Long work in the service.");
  group->require_subcommand(1);
  CLI::App* list = group->add_subcommand("list", summary_of("job.list"));
  list->callback([&cli] {
    cli.action = [&cli] {
      const Json answer = cli.call("job.list");
      std::vector<std::vector<std::string>> rows;
      for (const Json& each : answer["jobs"]) {
        const service::Job job = service::job_from_json(each);
        rows.push_back(
            {fmt::format("{}", job.id), job.kind, job.session, to_string(job.state),
             job.result_id ? fmt::format("{}", *job.result_id) : "-", job.created_utc,
             job.caller.operator_name});
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
  add_one_job_command(*group, cli, "wait", *job, [&cli, job] {
    Json status = ended_status(cli, *job);
    static_cast<void>(done_job(status));
    return status;
  });
}

}  // namespace sixdial::cli
