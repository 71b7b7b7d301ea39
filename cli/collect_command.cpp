// sixdial collect PLAN --session NAME: starts a collection and shows it live until it ends; and
// sixdial collection ... to command one that runs.
#include <fmt/format.h>
#include <poll.h>
#include <termios.h>
#include <unistd.h>

#include <filesystem>

#include "cli/cli.h"
#include "cli/collect_screen.h"
#include "cli/shared_options.h"
#include "report/documents/estimate_json.h"
#include "report/words/estimate_words.h"
#include "service/collection.h"
#include "session/csv.h"

namespace sixdial::cli {
namespace {

struct CollectOptions {
  std::string plan_file, session, rig_file, on_dial_fault, on_mode_change;
  double stop_below_mm = 0.0;
  double settle_spread_mm = 0.0;
  std::int64_t settle_timeout_ms = 0;
};

/// Single keys without Enter while it lives; nothing where stdin is no terminal.
class Keys {
 public:
  Keys() : active_(::isatty(STDIN_FILENO) != 0 && ::tcgetattr(STDIN_FILENO, &before_) == 0) {
    if (!active_) return;
    termios raw = before_;
    raw.c_lflag &= ~static_cast<tcflag_t>(ICANON | ECHO);
    ::tcsetattr(STDIN_FILENO, TCSANOW, &raw);
  }
  ~Keys() {
    if (active_) ::tcsetattr(STDIN_FILENO, TCSANOW, &before_);
  }
  Keys(const Keys&) = delete;
  Keys& operator=(const Keys&) = delete;

  [[nodiscard]] bool active() const { return active_; }
  /// 0: none was pressed.
  [[nodiscard]] char pressed() const {
    pollfd ready{.fd = STDIN_FILENO, .events = POLLIN, .revents = 0};
    char key = 0;
    if (!active_ || ::poll(&ready, 1, 0) <= 0 || ::read(STDIN_FILENO, &key, 1) != 1) return 0;
    return key;
  }

 private:
  termios before_{};
  bool active_;
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
      cli.console.out << line << '\n';
    }
    cli.console.out << report::estimate_summary(estimate) << '\n';
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
  }
}

service::ExitCode collect(Cli& cli, const CollectOptions& options) {
  make_session(cli, options);
  Json params{{"session", options.session}};
  if (!options.plan_file.empty()) params["plan_csv"] = session::read_file(options.plan_file);
  if (!options.on_dial_fault.empty()) params["on_dial_fault"] = options.on_dial_fault;
  if (!options.on_mode_change.empty()) params["on_mode_change"] = options.on_mode_change;
  if (options.stop_below_mm > 0.0) params["stop_below_mm"] = options.stop_below_mm;
  if (options.settle_spread_mm > 0.0) params["settle_spread_mm"] = options.settle_spread_mm;
  if (options.settle_timeout_ms > 0) params["settle_timeout_ms"] = options.settle_timeout_ms;
  cli.call("events.subscribe", {{"topics", screen_topics(cli.console)}});
  call_about(cli, "collect.start", params, "plan", options.plan_file);
  Screen screen(cli.console);
  return conclude(cli, follow(cli, screen));
}

void add_collection_commands(CLI::App& app, Cli& cli) {
  CLI::App* group = app.add_subcommand("collection", "Commands to a collection that runs.");
  group->require_subcommand(1);
  for (const char* verb :
       {"status", "pause", "resume", "skip", "retake", "accept", "moved", "stop"}) {
    const std::string method = std::string("collect.") + verb;
    group->add_subcommand(verb, summary_of(method))->callback([&cli, method] {
      cli.action = [&cli, method] {
        const Json status = cli.call(method);
        cli.console.print(
            "collect", status,
            fmt::format(
                "{}: session {}, {} of {} points\n", status["state"].get<std::string>(),
                status["session"].get<std::string>(), status["done"].get<std::int64_t>(),
                status["total"].get<std::int64_t>()));
        return service::ExitCode::kOk;
      };
    });
  }
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
          "--stop-below", options->stop_below_mm,
          "mm: leave out the rest of G1 once the uncertainty of a position (standard "
          "deviation, "
          "k = 1) is below this at the worst place of the workspace")
      ->check(CLI::Range(1e-6, 100.0));
  command->add_option(
      "--settle-spread", options->settle_spread_mm,
      "mm: readings that stay within this are "
      "settled");
  command->add_option(
      "--settle-timeout", options->settle_timeout_ms,
      "ms of the rig's time to wait until readings settle");
  command->callback(
      [&cli, options] { cli.action = [&cli, options] { return collect(cli, *options); }; });
  add_collection_commands(app, cli);
}

}  // namespace sixdial::cli
