// sixdial collect PLAN --session NAME: starts a collection and shows it live until it ends; and
// sixdial collection ... to command one that runs.
#include <fmt/format.h>

#include <filesystem>

#include "cli/cli.h"
#include "cli/collect_screen.h"
#include "cli/keys.h"
#include "cli/printable.h"
#include "cli/shared_options.h"
#include "geometry/units.h"
#include "report/documents/estimate_json.h"
#include "report/words/estimate_words.h"
#include "report/words/rig_words.h"
#include "service/collection.h"
#include "session/csv.h"
#include "session/sha256.h"

namespace sixdial::cli {
namespace {

struct CollectOptions {
  std::string plan_file, session, rig_file, on_dial_fault, on_mode_change;
  double stop_below_mm = 0.0;
  double settle_spread_mm = 0.0;
  std::int64_t settle_timeout_ms = 0;
  std::string on_lost_contact;
  int speed_percent = 0;
  bool first_pass = false;
};

bool has_ended(const Json& status) {
  return !service::is_active(service::collect_state_of(status));
}

/// The map is only drawn on a terminal.
void load_plan(Cli& cli, Screen& screen, const std::string& session) {
  if (!cli.console.terminal || cli.console.json || cli.console.quiet || session.empty()) return;
  std::int64_t offset = 0, total = 1;
  while (offset < total) {
    const Json page = cli.call("session.plan", {{"session", session}, {"offset", offset}});
    total = page["total"].get<std::int64_t>();
    if (page["points"].empty()) break;
    offset += std::ssize(page["points"]);
    screen.show_plan(page["points"]);
  }
}

/// Until the collection has ended; returns its last status.
Json follow(Cli& cli, Screen& screen) {
  constexpr auto kLookForKeys = std::chrono::milliseconds(200);
  const Keys keys;
  CollectKeys commands;
  Json status = cli.call("collect.status");
  load_plan(cli, screen, status["session"].get<std::string>());
  bool quitting = false;
  const auto take_event = [&](const Json& event) {
    const Json& params = event["params"];
    if (event["method"] == "events.gap") {
      status = cli.call("collect.status");
    } else if (params["topic"] == "sample") {
      screen.show_sample(params["data"]);
    } else if (params["topic"] == "live") {
      screen.show_dials(params["data"]);
    } else if (params["topic"] == "collect") {
      status = params["data"];
      screen.show_state(status);
    }
  };
  while (!has_ended(status)) {
    try {
      const std::optional<Json> event = cli.client().next_event(kLookForKeys);
      if (event) take_event(*event);
      const CollectKeys::Answer key = commands.press(keys.pressed());
      if (!key.question.empty()) screen.note(key.question);
      if (key.refused) screen.note("no: it goes on");
      if (key.method != nullptr) {
        cli.call(key.method);
        screen.note(std::string(key.said));
      }
    } catch (const service::Interrupted&) {
      if (quitting) throw;
      quitting = true;
      screen.note("stopping; what is stored stays, and collect goes on at the next point");
      service::end_soon(
          "\nthe service is still stopping the robot: sixdial collection status tells\n");
      cli.call("collect.stop");
    } catch (const service::RemoteError& error) {
      screen.note(error.what());  // a key at the wrong moment
    }
  }
  screen.end();
  if (quitting) throw service::Interrupted();
  return status;
}

service::ExitCode conclude(Cli& cli, const Json& status) {
  for (const Json& point : status["troubles"]) {
    cli.console.warn(fmt::format(
        "{} {}.{} not measured: {}", point["set"].get<std::string>(), point["point"].get<int>(),
        point["repeat"].get<int>(), point["why"].get<std::string>()));
  }
  cli.console.print(
      "collect", status,
      fmt::format(
          "session {}: {} of {} points, {} stored now, {} skipped, {} not measurable{}\n",
          status["session"].get<std::string>(), status["done"].get<std::int64_t>(),
          status["total"].get<std::int64_t>(), status["stored_in_this_run"].get<std::int64_t>(),
          status["skipped"].get<std::int64_t>(), status["failed"].get<std::int64_t>(),
          status["left_out"].get<std::int64_t>() > 0
              ? fmt::format(", {} left out", status["left_out"].get<std::int64_t>())
              : std::string()));
  if (!cli.console.json && status.contains("estimate") && status["estimate"].is_object()) {
    const studies::EstimateSummary estimate = report::estimate_from_json(status["estimate"]);
    for (const std::string& line : report::estimate_parameters(estimate)) {
      cli.console.out << for_terminal(line) << '\n';
    }
    cli.console.out << report::estimate_summary(estimate) << '\n';
    const std::string rig = estimate.rig ? report::rig_in_words(*estimate.rig) : "";
    if (!rig.empty()) cli.console.out << for_terminal(rig) << '\n';
  }
  if (status["ended_because"].is_string()) {
    cli.console.note("ended: " + status["ended_because"].get<std::string>());
  }
  if (status["error"].is_object()) throw service::RemoteError(status["error"]);
  if (service::collect_state_of(status) == service::CollectState::kStopped)
    return service::ExitCode::kCancelled;
  return status["failed"].get<std::int64_t>() > 0 ? service::ExitCode::kDataQuality
                                                  : service::ExitCode::kOk;
}

/// A session keeps the rig file that it was made with.
void tell_other_rig(Cli& cli, const CollectOptions& options) {
  const Json info = cli.call("session.show", {{"session", options.session}});
  const auto kept = info["rig_hash"].get<std::string>();
  const std::string given = session::sha256(session::read_file(options.rig_file));
  if (kept.find(given) != std::string::npos) return;
  cli.console.warn(fmt::format(
      "session {0} keeps the rig file that it was made with; {1} is another one and is not "
      "used. For a rig that has changed make another session: --session {0}-2 --rig {1}",
      options.session, options.rig_file));
}

/// A new session where --rig says so and there is none of this name.
void make_session(Cli& cli, const CollectOptions& options) {
  if (options.rig_file.empty()) return;
  try {
    call_about(
        cli, "session.create",
        {{"name", options.session}, {"rig_toml", session::read_file(options.rig_file)}},
        "rig.toml", options.rig_file);
    cli.console.note(fmt::format("new session {}", options.session));
  } catch (const service::RemoteError& error) {
    if (error.error()["data"]["code"] !=
        service::error_kind(service::ErrorCode::kAlreadyExists).code)
      throw;
    tell_other_rig(cli, options);
  }
}

service::ExitCode collect(Cli& cli, const CollectOptions& options) {
  make_session(cli, options);
  Json params{{"session", options.session}};
  if (!options.plan_file.empty()) params["plan_csv"] = session::read_file(options.plan_file);
  if (!options.on_dial_fault.empty()) params["on_dial_fault"] = options.on_dial_fault;
  if (!options.on_mode_change.empty()) params["on_mode_change"] = options.on_mode_change;
  if (!options.on_lost_contact.empty()) params["on_lost_contact"] = options.on_lost_contact;
  if (options.speed_percent > 0) params["speed_percent"] = options.speed_percent;
  if (options.first_pass) params["first_pass"] = true;
  if (options.stop_below_mm > 0.0) params["stop_below_mm"] = options.stop_below_mm;
  if (options.settle_spread_mm > 0.0) params["settle_spread_mm"] = options.settle_spread_mm;
  if (options.settle_timeout_ms > 0) params["settle_timeout_ms"] = options.settle_timeout_ms;
  cli.call("events.subscribe", {{"topics", screen_topics(cli.console)}});
  call_about(cli, "collect.start", params, "plan", options.plan_file);
  Screen screen(cli.console);
  return conclude(cli, follow(cli, screen));
}

service::ExitCode print_status(Cli& cli, const Json& status) {
  cli.console.print(
      "collect", status,
      fmt::format(
          "{}: session {}, {} of {} points\n", status["state"].get<std::string>(),
          status["session"].get<std::string>(), status["done"].get<std::int64_t>(),
          status["total"].get<std::int64_t>()));
  return service::ExitCode::kOk;
}

struct MovedOptions {
  std::vector<double> at;
  std::optional<double> temperature_c;
  bool radians = false, cannot = false, confirm = false;
};

/// What the encoders show, by the columns that the service knows the joints by.
Json joints_told(const Json& asked, const MovedOptions& options) {
  if (asked.size() != options.at.size()) {
    throw service::Error(
        service::ErrorCode::kInvalidParams,
        fmt::format(
            "--at has {} values, the robot has {} joints", options.at.size(), asked.size()),
        {{"param", "--at"}}, "Give one value for each joint, such as --at 73.9,120.4.");
  }
  Json joints = Json::object();
  for (std::size_t i = 0; i < asked.size(); ++i) {
    const auto unit = asked[i]["unit"].get<std::string>();
    const bool converted = unit == "rad" && !options.radians;
    joints[asked[i]["joint"].get<std::string>() + '_' + unit] =
        converted ? options.at[i] * geometry::kRadPerDeg : options.at[i];
  }
  return joints;
}

service::ExitCode moved(Cli& cli, const MovedOptions& options) {
  Json params{{"reached", !options.cannot}};
  if (!options.at.empty()) {
    const Json asked = cli.call("collect.status")["move_to"];
    if (asked.is_array()) params["joints"] = joints_told(asked, options);
  }
  if (options.confirm) params["confirm"] = true;
  if (options.temperature_c) params["temperature_c"] = *options.temperature_c;
  return print_status(cli, cli.call("collect.moved", params));
}

void add_moved_command(CLI::App& group, Cli& cli) {
  CLI::App* command = group.add_subcommand("moved", summary_of("collect.moved"));
  const auto options = std::make_shared<MovedOptions>();
  CLI::Option* at = command
                        ->add_option(
                            "--at", options->at,
                            "what the encoders show, joint by joint, in degrees (mm for a "
                            "joint that slides); default: the values asked for")
                        ->delimiter(',');
  command->add_flag("--rad", options->radians, "--at is in radians")->needs(at);
  command->add_flag("--confirm", options->confirm, "the robot really stands that far away")
      ->needs(at);
  command->add_flag("--cannot", options->cannot, "the robot cannot go there: leave it out")
      ->excludes(at);
  command->add_option("--temperature", options->temperature_c, "at the robot, in degC");
  command->callback(
      [&cli, options] { cli.action = [&cli, options] { return moved(cli, *options); }; });
}

void add_collection_commands(CLI::App& app, Cli& cli) {
  CLI::App* group = app.add_subcommand("collection", "Commands to a collection that runs.");
  group->require_subcommand(1);
  for (const char* verb : {"status", "pause", "resume", "skip", "retake", "accept", "stop"}) {
    const std::string method = std::string("collect.") + verb;
    group->add_subcommand(verb, summary_of(method))->callback([&cli, method] {
      cli.action = [&cli, method] { return print_status(cli, cli.call(method)); };
    });
  }
  add_moved_command(*group, cli);
  group->add_subcommand("watch", "Shows a collection that runs until it ends.")
      ->callback([&cli] {
        cli.action = [&cli] {
          cli.call("events.subscribe", {{"topics", screen_topics(cli.console)}});
          Screen screen(cli.console);
          return conclude(cli, follow(cli, screen));
        };
      });
}

}  // namespace

void add_collect_command(CLI::App& app, Cli& cli) {
  CLI::App* command = app.add_subcommand("collect", summary_of("collect.start"));
  const auto options = std::make_shared<CollectOptions>();
  command->add_option("PLAN", options->plan_file, "plan file; default: the session's plan")
      ->check(existing_file());
  command->add_option("--session", options->session, "name of the session")->required();
  command->add_option(
      "--rig", options->rig_file,
      "make the session with this rig.toml if there "
      "is none");
  command
      ->add_option(
          "--on-dial-fault", options->on_dial_fault,
          "when a dial does not answer: store without it, or pause")
      ->check(CLI::IsMember({"store", "pause"}));
  command
      ->add_option(
          "--on-mode-change", options->on_mode_change,
          "before a point in another working mode pause until the legs are brought over (the "
          "default), or go: only a rig that does it by itself")
      ->check(CLI::IsMember({"pause", "go"}));
  command
      ->add_option(
          "--on-lost-contact", options->on_lost_contact,
          "where two dials lose the cuboid on the way: halt the robot and pause (the default), "
          "or go")
      ->check(CLI::IsMember({"halt", "go"}));
  command->add_flag(
      "--first-pass", options->first_pass,
      "only to the outermost points, slowly, looking whether the dials show what they should; "
      "asks before the first move, stores nothing");
  command
      ->add_option(
          "--speed", options->speed_percent,
          "percent of the controller's full speed; of a first pass 10")
      ->check(CLI::Range(1, 100));
  command
      ->add_option(
          "--stop-below", options->stop_below_mm,
          "mm: leave out the rest of G1 once the uncertainty of a position (standard "
          "deviation, "
          "k = 1) is below this at the worst place of the workspace")
      ->check(CLI::Range(1e-6, 100.0));
  command
      ->add_option(
          "--settle-spread", options->settle_spread_mm,
          "mm: readings that stay within this are "
          "settled")
      ->check(CLI::PositiveNumber);
  command
      ->add_option(
          "--settle-timeout", options->settle_timeout_ms,
          "ms of the rig's time to wait until readings settle")
      ->check(CLI::PositiveNumber);
  command->callback(
      [&cli, options] { cli.action = [&cli, options] { return collect(cli, *options); }; });
  add_collection_commands(app, cli);
}

}  // namespace sixdial::cli
