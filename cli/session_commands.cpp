// sixdial session create|list|show|import|export|undo.
#include <fmt/format.h>

#include "cli/cli.h"
#include "report/documents/warnings_document.h"
#include "report/words/warning_words.h"
#include "session/csv.h"

namespace sixdial::cli {
namespace {

std::string sets_text(const Json& info) {
  std::string text;
  for (const auto& [set, count] : info["samples_by_set"].items()) {
    text += fmt::format("{}{} {}", text.empty() ? "" : ", ", set, count.get<std::int64_t>());
  }
  return text.empty() ? "none" : text;
}

std::string info_text(const Json& info) {
  std::string text = fmt::format(
      "session {}: {} samples ({}), plan of {} points\n  rig {}, {}\n  since {} by {}\n",
      info["name"].get<std::string>(), info["samples"].get<std::int64_t>(), sets_text(info),
      info["plan_points"].get<std::int64_t>(), info["rig_name"].get<std::string>(),
      info["rig_hash"].get<std::string>().substr(0, 12), info["created_utc"].get<std::string>(),
      info["operator"].get<std::string>());
  text += report::warnings_text(report::warnings_in(info));
  for (const Json& each : info.value("collections", Json::array())) {
    text += fmt::format(
        "  collecting ended {}: {}\n", each["time_utc"].get<std::string>(),
        each["ended_because"].get<std::string>());
  }
  for (const Json& each : info.value("clock_steps", Json::array())) {
    text += fmt::format(
        "  {} {}\n", each["time_utc"].get<std::string>(), each["what"].get<std::string>());
  }
  if (const auto within = info.find("readings_within_ms");
      within != info.end() && within->is_object()) {
    text += fmt::format(
        "  the dials of a sample were read within {:.0f} ms (median), {:.0f} ms at most\n",
        (*within)["median"].get<double>(), (*within)["max"].get<double>());
  }
  return text;
}

struct SessionOptions {
  std::string name, rig_file, path;
  bool skip_bad_rows = false;
  int limit = 0, offset = 0;
};

void add_create(CLI::App& group, Cli& cli, const std::shared_ptr<SessionOptions>& options) {
  CLI::App* command = group.add_subcommand("create", summary_of("session.create"));
  command->add_option("NAME", options->name, "of the new session")->required();
  command->add_option("--rig", options->rig_file, "rig.toml")->required();
  command->callback([&cli, options] {
    cli.action = [&cli, options] {
      const Json info = call_about(
          cli, "session.create",
          {{"name", options->name}, {"rig_toml", session::read_file(options->rig_file)}},
          "rig.toml", options->rig_file);
      cli.console.print("session", info, info_text(info));
      return service::ExitCode::kOk;
    };
  });
}

void add_list(CLI::App& group, Cli& cli) {
  group.add_subcommand("list", summary_of("session.list"))->callback([&cli] {
    cli.action = [&cli] {
      constexpr int kPage = 50;
      Json sessions = Json::array();
      for (;;) {
        const Json page =
            cli.call("session.list", {{"offset", sessions.size()}, {"limit", kPage}});
        for (const Json& info : page["sessions"]) sessions.push_back(info);
        if (page["sessions"].empty() || sessions.size() >= page["total"]) break;
      }
      std::vector<std::vector<std::string>> rows;
      for (const Json& info : sessions) {
        rows.push_back(
            {info["name"].get<std::string>(), info["samples"].dump(), sets_text(info),
             info["plan_points"].dump(), info["created_utc"].get<std::string>(),
             info["operator"].get<std::string>()});
      }
      cli.console.print(
          "session.list", {{"sessions", sessions}},
          text_table({"session", "samples", "sets", "plan", "since", "by"}, rows));
      return service::ExitCode::kOk;
    };
  });
}

void add_show(CLI::App& group, Cli& cli, const std::shared_ptr<SessionOptions>& options) {
  CLI::App* command = group.add_subcommand("show", summary_of("session.show"));
  command->add_option("NAME", options->name)->required();
  command->add_option("--limit", options->limit, "so many samples")->check(CLI::Range(0, 50));
  command->add_option("--offset", options->offset, "from this sample on");
  command->callback([&cli, options] {
    cli.action = [&cli, options] {
      const Json info = cli.call(
          "session.show",
          {{"session", options->name}, {"limit", options->limit}, {"offset", options->offset}});
      std::string text = info_text(info);
      for (const Json& sample : info.value("page", Json::array())) {
        text += fmt::format(
            "  {} {}.{}  {}\n", sample["set"].get<std::string>(), sample["point"].get<int>(),
            sample["repeat"].get<int>(), sample["position_mm"].dump());
      }
      cli.console.print("session", info, text);
      return service::ExitCode::kOk;
    };
  });
}

void add_import(CLI::App& group, Cli& cli, const std::shared_ptr<SessionOptions>& options) {
  CLI::App* command = group.add_subcommand("import", summary_of("session.import"));
  command->add_option("BUNDLE", options->path, "folder with session.csv and rig.toml")
      ->required();
  command->add_option("--name", options->name, "of the session; default: the folder's");
  command->add_flag(
      "--skip-bad-rows", options->skip_bad_rows, "leave bad rows out, count and list them");
  command->callback([&cli, options] {
    cli.action = [&cli, options] {
      Json params{{"path", absolute(options->path)}, {"skip_bad_rows", options->skip_bad_rows}};
      if (!options->name.empty()) params["name"] = options->name;
      const Json info = cli.call("session.import", params);
      for (const Json& row : info["rejected"]) {
        cli.console.warn(fmt::format(
            "line {} left out: {}", row["line"].get<int>(), row["reason"].get<std::string>()));
      }
      cli.console.print("session", info, info_text(info));
      return service::ExitCode::kOk;
    };
  });
}

void add_export(CLI::App& group, Cli& cli, const std::shared_ptr<SessionOptions>& options) {
  CLI::App* command = group.add_subcommand("export", summary_of("session.export"));
  command->add_option("NAME", options->name)->required();
  command->add_option("FOLDER", options->path, "is made if absent")->required();
  command->callback([&cli, options] {
    cli.action = [&cli, options] {
      const Json answer = call_for_files(
          cli, "session.export",
          {{"session", options->name}, {"path", absolute(options->path)}});
      cli.console.print(
          "session.export", answer,
          fmt::format(
              "{} samples to {}\n", answer["samples"].get<std::int64_t>(),
              answer["path"].get<std::string>()));
      return service::ExitCode::kOk;
    };
  });
}

void add_undo(CLI::App& group, Cli& cli, const std::shared_ptr<SessionOptions>& options) {
  CLI::App* command = group.add_subcommand("undo", summary_of("session.undo"));
  command->add_option("NAME", options->name)->required();
  command->callback([&cli, options] {
    cli.action = [&cli, options] {
      const Json info = cli.call("session.undo", {{"session", options->name}});
      cli.console.print("session", info, info_text(info));
      return service::ExitCode::kOk;
    };
  });
}

}  // namespace

void add_session_commands(CLI::App& app, Cli& cli) {
  CLI::App* group = app.add_subcommand("session", "Measured data in the service's store.");
  group->require_subcommand(1);
  const auto options = std::make_shared<SessionOptions>();
  add_create(*group, cli, options);
  add_list(*group, cli);
  add_show(*group, cli, options);
  add_import(*group, cli, options);
  add_export(*group, cli, options);
  add_undo(*group, cli, options);
}

}  // namespace sixdial::cli
