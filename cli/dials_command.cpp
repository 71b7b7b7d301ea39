// sixdial dials: the dials live while nothing is collected, and "push each with a finger". Of a
// session through the service; of a rig file by this program itself, as `rig scan` reads.
#include <fmt/format.h>

#include <thread>

#include "acquisition/dial_bank.h"
#include "acquisition/push_check.h"
#include "cli/cli.h"
#include "cli/collect_screen.h"
#include "cli/keys.h"
#include "cli/printable.h"
#include "cli/shared_options.h"
#include "service/dial_watch.h"
#include "session/rig_file.h"

namespace sixdial::cli {
namespace {

constexpr auto kEvery = std::chrono::milliseconds(200);

struct DialsOptions {
  std::string session, rig_file;
  bool check = false;
};

/// Where the readings come from.
class Source {
 public:
  virtual ~Source() = default;
  /// The data of a live event; empty: none just now. Throws Interrupted.
  virtual std::optional<Json> next() = 0;
  /// "start", "again" or "skip", as the service's dials.check has it.
  virtual void check(std::string_view step) = 0;
};

/// The dials of a rig file, read by this process.
class RigFile final : public Source {
 public:
  explicit RigFile(const std::string& file)
      : rig_(session::read_rig_file(file)), shown_(rig_), bank_(opened(rig_, clock_, file)) {}

  std::optional<Json> next() override {
    std::this_thread::sleep_for(kEvery);
    if (service::take_interruption()) throw service::Interrupted();
    const std::vector<acquisition::Reading> readings = bank_->latest();
    if (check_) check_->take(readings);
    Json live = shown_.watched(readings);
    live["check"] = check_ ? service::check_json(*check_, rig_) : Json(nullptr);
    return live;
  }
  void check(std::string_view step) override {
    if (step == "start") check_.emplace(rig_);
    if (step == "again") check_->again();
    if (step == "skip") check_->skip();
  }

 private:
  static std::unique_ptr<acquisition::DialBank> opened(
      const geometry::Rig& rig, acquisition::Clock& clock, const std::string& file) {
    auto bank = acquisition::DialBank::open(rig, clock);
    if (bank && !rig.dials.empty()) return *std::move(bank);
    throw service::Error(
        service::ErrorCode::kBadData, bank ? "the rig file names no dial" : bank.error(),
        {{"file", file}}, "Each [[dial]] needs a connection: sixdial rig scan finds them.");
  }

  geometry::Rig rig_;
  acquisition::SystemClock clock_;
  service::LiveDials shown_;
  std::unique_ptr<acquisition::DialBank> bank_;
  std::optional<acquisition::PushCheck> check_;
};

/// Those of a session, which the service reads.
class OfSession final : public Source {
 public:
  OfSession(Cli& cli, std::string session) : cli_(cli), session_(std::move(session)) {
    ask();
    cli_.call("events.subscribe", {{"topics", {"live"}}});
  }
  ~OfSession() override {
    try {
      cli_.call("dials.stop");
    } catch (const std::exception&) {
      // It lets go by itself when nobody asks for them any more.
    }
  }
  OfSession(const OfSession&) = delete;
  OfSession& operator=(const OfSession&) = delete;

  std::optional<Json> next() override {
    if (std::chrono::steady_clock::now() - asked_ > kAskAgain) ask();
    const std::optional<Json> event = cli_.client().next_event(kEvery);
    if (!event || (*event)["method"] != "events.event") return std::nullopt;
    Json data = (*event)["params"]["data"];
    if (data.value("session", "") != session_ || data.value("stage", "") != "watching") {
      return std::nullopt;
    }
    return data;
  }
  void check(std::string_view step) override { cli_.call("dials.check", {{"do", step}}); }

 private:
  static constexpr auto kAskAgain = std::chrono::seconds(10);
  void ask() {
    cli_.call("dials.watch", {{"session", session_}, {"for_s", 30}});
    asked_ = std::chrono::steady_clock::now();
  }

  Cli& cli_;
  std::string session_;
  std::chrono::steady_clock::time_point asked_;
};

bool all_answered(const Json& live) {
  for (const auto& [id, dial] : live["dials"].items()) {
    if (dial["reason"] == "never read") return false;
  }
  return true;
}

std::string readings_text(const Json& live) {
  std::vector<std::vector<std::string>> rows;
  for (const auto& [id, dial] : live["dials"].items()) {
    const auto words = dial["words"].get<std::string>();
    rows.push_back(
        {id,
         dial["value_mm"].is_number() ? fmt::format("{:.3f}", dial["value_mm"].get<double>())
                                      : "-",
         dial["state"].get<std::string>(), dial.value("detail", words)});
  }
  return text_table({"dial", "mm", "state", "what it says"}, rows);
}

/// The block of the dials, drawn anew with these lines below it.
std::string redrawn(
    ScreenBlock& block, const Json& live, const std::vector<std::string>& below) {
  const std::string before = block.erased();
  std::vector<std::string> lines = dial_lines(live, terminal_width());
  for (const std::string& text : below) {
    for (std::string& each : wrapped(text, terminal_width())) lines.push_back(std::move(each));
  }
  block.set(std::move(lines));
  return before + block.drawn();
}

/// On a terminal until Ctrl-C; else the readings once.
service::ExitCode show(Cli& cli, Source& source) {
  const bool live = cli.console.terminal && !cli.console.json && !cli.console.quiet;
  ScreenBlock block(cli.console);
  for (;;) {
    const std::optional<Json> data = source.next();
    if (!data || (!live && !all_answered(*data))) continue;
    if (live) {
      cli.console.send(redrawn(block, *data, {"Ctrl-C ends."}));
      continue;
    }
    cli.console.print("dials", {{"dials", (*data)["dials"]}}, readings_text(*data));
    return service::ExitCode::kOk;
  }
}

/// What the pushes have shown so far, a line each.
std::vector<std::string> verdicts(const Json& check) {
  std::vector<std::string> lines;
  for (const Json& dial : check["dials"]) {
    if (dial["verdict"] != "open") lines.push_back(dial["words"].get<std::string>());
  }
  return lines;
}

/// Carries the check on until its last dial; returns its end.
Json carried_on(Cli& cli, Source& source) {
  const Keys keys;
  ScreenBlock block(cli.console);
  std::vector<std::string> said;
  std::string asked;
  for (;;) {
    switch (keys.pressed()) {
      case 's':
        source.check("skip");
        break;
      case 'a':
        source.check("again");
        break;
      default:
        break;
    }
    const std::optional<Json> data = source.next();
    if (!data || !(*data)["check"].is_object()) continue;
    const Json& check = (*data)["check"];
    std::string bytes = block.erased();
    for (const std::string& line : verdicts(check)) {
      if (std::ranges::find(said, line) != said.end()) continue;
      said.push_back(line);
      bytes += for_terminal(line) + '\n';
    }
    const auto instruction = check["instruction"].get<std::string>();
    if (!cli.console.terminal && !instruction.empty() && instruction != asked) {
      bytes += for_terminal(instruction) + '\n';
    }
    asked = instruction;
    cli.console.send(bytes);
    if (check["done"] == true) return check;
    if (cli.console.terminal) {
      cli.console.send(redrawn(
          block, *data,
          {instruction, "s leaves it out, a asks for the one before, Ctrl-C ends."}));
    }
  }
}

service::ExitCode check(Cli& cli, Source& source) {
  cli.console.note(
      "Move the cuboid away from the dials, so that every plunger hangs free. Nothing moves by "
      "itself in this check.");
  source.check("start");
  const Json end = carried_on(cli, source);
  std::string text;
  for (const std::string& line : verdicts(end)) text += line + '\n';
  cli.console.print("dials", {{"check", end}}, text);
  if (end["good"] == true) return service::ExitCode::kOk;
  cli.console.note(
      "Mend what is said above and check again: one exchanged pair spoils a session.");
  return service::ExitCode::kDevice;
}

}  // namespace

void add_dials_command(CLI::App& app, Cli& cli) {
  CLI::App* command = app.add_subcommand(
      "dials",
      "Shows the dials live while nothing is collected; --check asks for a push at each and "
      "tells wiring, sign and unit.");
  const auto options = std::make_shared<DialsOptions>();
  CLI::Option* session = command->add_option(
      "SESSION", options->session, "a session of the service, whose rig it is");
  command->add_option("--rig", options->rig_file, "rig.toml, read by this program: no service")
      ->check(existing_file())
      ->excludes(session);
  command->add_flag("--check", options->check, "push each dial with a finger: A, B, ...");
  command->callback([&cli, options] {
    if (options->session.empty() && options->rig_file.empty()) {
      throw CLI::RequiredError("SESSION or --rig");
    }
    cli.action = [&cli, options] {
      std::unique_ptr<Source> source;
      if (options->rig_file.empty()) {
        source = std::make_unique<OfSession>(cli, options->session);
      } else {
        source = std::make_unique<RigFile>(options->rig_file);
      }
      return options->check ? check(cli, *source) : show(cli, *source);
    };
  });
}

void add_robot_commands(CLI::App& app, Cli& cli) {
  CLI::App* group = app.add_subcommand("robot", "The robot's controller.");
  group->require_subcommand(1);
  CLI::App* stop = group->add_subcommand("stop", summary_of("robot.stop"));
  const auto session = std::make_shared<std::string>();
  stop->add_option(
      "SESSION", *session, "whose robot it is; not needed while a session is collected");
  stop->callback([&cli, session] {
    cli.action = [&cli, session] {
      Json params = Json::object();
      if (!session->empty()) params["session"] = *session;
      const Json answer = cli.call("robot.stop", params);
      cli.console.print("robot.stop", answer, answer["words"].get<std::string>() + "\n");
      return service::ExitCode::kOk;
    };
  });
}

}  // namespace sixdial::cli
