#include "service/daemon.h"

#include <fmt/format.h>
#include <spdlog/pattern_formatter.h>
#include <spdlog/sinks/stdout_sinks.h>
#include <spdlog/spdlog.h>

#include <CLI/CLI.hpp>
#include <chrono>
#include <cmath>
#include <condition_variable>
#include <csignal>
#include <cstdlib>
#include <mutex>
#include <thread>

#include "acquisition/dial_examples.h"
#include "acquisition/robot_driver.h"
#include "report/causes_doc.h"
#include "service/live/live_page.h"
#include "service/methods/method.h"
#include "service/service.h"
#include "service/socket/server.h"
#include "session/session.h"

namespace sixdial::service {
namespace {

std::filesystem::path directory_from(const char* variable) {
  const char* value = std::getenv(variable);
  return value == nullptr ? std::filesystem::path() : std::filesystem::path(value);
}

struct DaemonOptions {
  std::string socket = default_socket_path().string();
  std::string database = default_database_path().string();
  double clock_speed = 1.0;
  double longest_shut_down_s = 0.9;
  bool allow_exec = false;
  std::string clock_start;
  std::string log_level = "info";
  bool print_protocol = false;
  bool print_manual = false;
  bool print_causes = false;
  bool print_dials = false;
  bool print_robots = false;
  std::string print_rig;
  std::uint16_t live_port = kDefaultLivePort;
  const CLI::Option* live = nullptr;  // --live, given or not
};

/// A message without control characters: names and errors quote what files and clients say.
class PrintableText final : public spdlog::custom_flag_formatter {
 public:
  void format(
      const spdlog::details::log_msg& message, const std::tm&,
      spdlog::memory_buf_t& line) override {
    for (const char c : message.payload) {
      const auto code = static_cast<unsigned char>(c);
      if (code >= 0x20 && code != 0x7f) {
        line.push_back(c);
      } else {
        fmt::format_to(std::back_inserter(line), "\\x{:02x}", code);
      }
    }
  }
  [[nodiscard]] std::unique_ptr<custom_flag_formatter> clone() const override {
    return std::make_unique<PrintableText>();
  }
};

void start_log(const std::string& level) {
  // Synchronous: the asynchronous sink loses its last lines on a crash.
  const auto log = spdlog::stderr_logger_mt("sixdiald");
  auto lines = std::make_unique<spdlog::pattern_formatter>();
  lines->add_flag<PrintableText>('*').set_pattern("%Y-%m-%dT%H:%M:%S.%e %l %*");
  log->set_formatter(std::move(lines));
  log->set_level(spdlog::level::from_str(level));
  spdlog::set_default_logger(log);
}

ServiceOptions service_options(const DaemonOptions& options) {
  ServiceOptions wanted;
  wanted.database = options.database;
  wanted.clock_speed = options.clock_speed;
  wanted.allow_exec = options.allow_exec;
  if (!options.clock_start.empty()) {
    wanted.clock_start = session::from_iso8601(options.clock_start);
    if (!wanted.clock_start) {
      throw Error(
          ErrorCode::kInvalidParams,
          "--clock-start " + options.clock_start + " is no time in UTC", {},
          "Write it like 2026-03-02T08:30:00.000Z.");
    }
  }
  return wanted;
}

void add_options(CLI::App& app, DaemonOptions& options) {
  app.set_version_flag("--version", SIXDIAL_VERSION);
  app.add_option("--socket", options.socket, "where to listen")->capture_default_str();
  app.add_option("--db", options.database, "the database file")->capture_default_str();
  app.add_option(
         "--clock-speed", options.clock_speed,
         "the rig's clock runs so many times faster than the wall's (a mock rig)")
      ->check(CLI::Range(0.001, 1e6));
  app.add_option("--clock-start", options.clock_start, "what the rig's clock begins with, UTC");
  app.add_option(
         "--longest-shutdown", options.longest_shut_down_s,
         "seconds after a signal to end, at most: what still hangs then is left")
      ->check(CLI::Range(0.1, 3600.0))
      ->capture_default_str();
  app.add_flag(
      "--allow-exec", options.allow_exec,
      "a rig file may name a program that moves the robot (exec:): whoever reaches the socket "
      "runs it as this user");
  app.add_option("--log-level", options.log_level, "debug, info, warn, error")
      ->check(CLI::IsMember({"debug", "info", "warn", "error"}));
  options.live =
      app.add_option(
             "--live", options.live_port,
             "serve the live page on this port of the loopback, 0: any free one; prints its "
             "address with the token")
          ->expected(0, 1)
          ->default_str(std::to_string(kDefaultLivePort));
  app.add_flag("--print-protocol", options.print_protocol, "print doc/protocol.md and end");
  app.add_flag("--print-manual", options.print_manual, "print the man page and end");
  app.add_flag("--print-causes", options.print_causes, "print doc/manual/causes.md and end");
  app.add_flag(
      "--print-dials", options.print_dials,
      "print the table of dials of doc/devices.md and end");
  app.add_flag(
      "--print-robots", options.print_robots,
      "print the table of robot connections of doc/devices.md and end");
  app.add_option(
      "--print-rig", options.print_rig,
      "print the example rig file of this dial's dialect and end");
}

/// The exit code after output: a full disk or a closed pipe is no success.
int printed(std::ostream& out, std::ostream& err) {
  if (out.flush()) return static_cast<int>(ExitCode::kOk);
  err << "the output could not be written whole\n";
  return static_cast<int>(ExitCode::kFailed);
}

int print_rig(const std::string& dialect, std::ostream& out, std::ostream& err) {
  const auto* protocol = acquisition::find_dial_protocol(dialect);
  if (protocol == nullptr) {
    err << "there is no dialect " << dialect << "; --print-dials lists them\n";
    return static_cast<int>(ExitCode::kUsage);
  }
  return printed(out << acquisition::example_rig(*protocol), err);
}

/// Ends the process some time after `begin`, if it is still there: a request that hangs (a dead
/// network file system, say) must not hold up the machine's shutdown.
class Deadline {
 public:
  explicit Deadline(std::chrono::milliseconds longest) : longest_(longest) {}
  void begin() {
    thread_ = std::jthread([this](const std::stop_token& stop) {
      std::unique_lock lock(mutex_);
      never_.wait_for(lock, stop, longest_, [] { return false; });
      if (stop.stop_requested()) return;
      // What was acknowledged is on the disk already.
      spdlog::warn("a request or a job does not end; the process ends without it");
      std::_Exit(0);
    });
  }

 private:
  std::chrono::milliseconds longest_;
  std::mutex mutex_;
  std::condition_variable_any never_;
  std::jthread thread_;  // last: it uses the others
};

/// Until a signal or the method shutdown ends it.
void serve(const DaemonOptions& options, std::ostream& out) {
  // First, so that it outlives what may hang.
  Deadline deadline(std::chrono::milliseconds(std::llround(1e3 * options.longest_shut_down_s)));
  Service service(service_options(options));
  Server server(
      service, {.socket_path = options.socket,
                .take_over_from_systemd = true,
                .handle_signals = true,
                .going_down = [&deadline] { deadline.begin(); }});
  std::optional<LivePage> page;
  if (options.live->count() > 0) {
    page.emplace(LivePageOptions{.socket_path = options.socket, .port = options.live_port});
    out << "Live page: " << page->url() << std::endl;
    if (!out) spdlog::warn("the address of the live page could not be written to stdout");
  }
  server.run();
  spdlog::info("ended");
}

}  // namespace

std::filesystem::path default_database_path() {
  constexpr const char* kFile = "sixdial.db";
  if (const auto state = directory_from("STATE_DIRECTORY"); !state.empty())
    return state / kFile;
  if (const auto data = directory_from("XDG_DATA_HOME"); !data.empty()) {
    return data / "sixdial" / kFile;
  }
  if (const auto home = directory_from("HOME"); !home.empty()) {
    return home / ".local" / "share" / "sixdial" / kFile;
  }
  return std::filesystem::path("/var/lib/sixdial") / kFile;
}

int run_daemon(
    int argc, const char* const* argv, std::ostream& out, std::ostream& err,
    const ManualPage& manual_page) {
  DaemonOptions options;
  CLI::App app{"The measurement service of Sixdial, on a Unix socket.", "sixdiald"};
  add_options(app, options);
  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& error) {
    return app.exit(error, out, err) == 0 ? printed(out, err)
                                          : static_cast<int>(ExitCode::kUsage);
  }
  if (options.print_causes) return printed(out << report::causes_markdown(), err);
  if (options.print_protocol) return printed(out << protocol_markdown(), err);
  if (options.print_dials) return printed(out << acquisition::dial_table(), err);
  if (options.print_robots) return printed(out << acquisition::robot_table(), err);
  if (!options.print_rig.empty()) return print_rig(options.print_rig, out, err);
  if (options.print_manual) return printed(out << manual_page(app), err);
  start_log(options.log_level);
  std::signal(SIGPIPE, SIG_IGN);
  try {
    serve(options, out);
    return static_cast<int>(ExitCode::kOk);
  } catch (...) {
    const Json error = to_error_object(std::current_exception());
    const Json& data = error["data"];
    auto message = error["message"].get<std::string>();
    const auto file = data["at"].value("file", std::string());
    if (message.find(file) == std::string::npos) message = fmt::format("{}: {}", file, message);
    spdlog::error("{}. {}", message, data["hint"].get<std::string>());
    return static_cast<int>(exit_code_of(error));
  }
}

}  // namespace sixdial::service
