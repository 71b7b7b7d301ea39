// A mock rig with everything a collection needs, and a real sixdiald process to collect with.
#pragma once

#include <signal.h>
#include <spawn.h>
#include <sys/wait.h>

#include <map>
#include <tuple>

#include "mock_devices/iso_time.h"
#include "mock_devices/mock_rig.h"
#include "session/plan.h"
#include "session/rig_file.h"
#include "tests/support/paths.h"
#include "tests/support/rig_for_tests.h"

extern char** environ;

namespace sixdial::testing {

inline constexpr double kSpeed = 50.0;  // rig seconds a wall second, unless told otherwise

/// A mock rig, its rig file, and plans for it.
class Rig {
 public:
  explicit Rig(double speed = kSpeed) : speed_(speed), mock_(options(speed)) { mock_.start(); }
  [[nodiscard]] std::string toml() const {
    return session::write_rig(mock_.connected_rig("modbus-tcp"));
  }
  [[nodiscard]] std::string now() const { return mock_devices::iso8601(mock_.utc_ms()); }
  [[nodiscard]] service::ServiceOptions service_options() const {
    service::ServiceOptions options;
    options.clock_speed = speed_;
    options.clock_start = session::from_iso8601(now());
    return options;
  }
  [[nodiscard]] static session::Plan plan(int count, const std::string& set = "G1") {
    session::PlanOptions options;
    options.set = set;
    options.seed = 5;
    return session::plan_random(geometry::default_rig(), count, options).value();
  }
  mock_devices::MockRig& mock() { return mock_; }

 private:
  static mock_devices::MockRigOptions options(double speed) {
    mock_devices::MockRigOptions options;
    options.world.rig = geometry::default_rig();
    options.world.robot.parameters = geometry::table_2_robot();
    options.clock_speed = speed;
    return options;
  }
  double speed_;
  mock_devices::MockRig mock_;
};

inline Json create(LineClient& client, const Rig& rig) {
  return client.call("session.create", {{"name", "live"}, {"rig_toml", rig.toml()}});
}

inline Json start(LineClient& client, const session::Plan& plan) {
  return client.call(
      "collect.start",
      {{"session", "live"},
       {"plan_csv", session::plan_csv(plan, session::layout_of(geometry::default_rig()))}});
}

inline Json wait_for_end(LineClient& client) {
  Json status;
  do {
    status = client.call("collect.wait", {{"timeout_s", 60}})["result"];
  } while (status["state"] == "running" || status["state"] == "starting" ||
           status["state"] == "stopping");
  return status;
}

using Key = std::tuple<std::string, int, int>;

inline Key key_of(const Json& sample) {
  return {
      sample["set"].get<std::string>(), sample["point"].get<int>(),
      sample["repeat"].get<int>()};
}

/// A real sixdiald process; what it logs is in `directory`/log.
class Daemon {
 public:
  Daemon(
      const std::filesystem::path& directory, const std::string& clock_start,
      const std::vector<std::string>& environment = {}, const std::string& socket = "s")
      : socket_(directory / socket), log_(directory / (socket + ".log")) {
    const std::string program = test_paths::bin_dir() + "/sixdiald";
    const std::string database = (directory / "daemon.db").string();
    std::vector<std::string> words{
        program,
        "--socket",
        socket_.string(),
        "--db",
        database,
        "--log-level",
        "warn",
        "--clock-speed",
        std::to_string(kSpeed),
        "--clock-start",
        clock_start,
        "--longest-shutdown",
        std::to_string(kPatience.count())};
    std::vector<char*> arguments;
    for (std::string& word : words) arguments.push_back(word.data());
    arguments.push_back(nullptr);
    std::vector<std::string> variables = environment;
    for (char** each = environ; *each != nullptr; ++each) variables.emplace_back(*each);
    std::vector<char*> all;
    for (std::string& variable : variables) all.push_back(variable.data());
    all.push_back(nullptr);
    posix_spawn_file_actions_t actions;
    posix_spawn_file_actions_init(&actions);
    posix_spawn_file_actions_addopen(
        &actions, STDERR_FILENO, log_.c_str(), O_WRONLY | O_CREAT | O_TRUNC, 0600);
    const int failed =
        posix_spawn(&pid_, program.c_str(), &actions, nullptr, arguments.data(), all.data());
    posix_spawn_file_actions_destroy(&actions);
    if (failed != 0) throw std::runtime_error("cannot start " + program);
  }
  ~Daemon() {
    if (pid_ > 0) end(SIGKILL);
  }
  Daemon(const Daemon&) = delete;
  Daemon& operator=(const Daemon&) = delete;

  [[nodiscard]] const std::filesystem::path& socket() const { return socket_; }
  [[nodiscard]] const std::filesystem::path& log() const { return log_; }
  /// Waits until it answers.
  LineClient client() {
    std::optional<LineClient> connected;
    if (!eventually([&] {
          try {
            connected.emplace(socket_);
            return connected->call("hello").contains("result");
          } catch (const std::runtime_error&) {
            return false;
          }
        })) {
      throw std::runtime_error("sixdiald does not answer");
    }
    return *std::move(connected);
  }
  /// The wait status of one that ends by itself; killed if it does not.
  int ended() {
    int status = 0;
    if (eventually([&] { return ::waitpid(pid_, &status, WNOHANG) == pid_; })) {
      pid_ = -1;
      return status;
    }
    return end(SIGKILL);
  }
  /// The wait status after the signal.
  int end(int signal) {
    ::kill(pid_, signal);
    int status = 0;
    ::waitpid(std::exchange(pid_, -1), &status, 0);
    return status;
  }

 private:
  std::filesystem::path socket_, log_;
  pid_t pid_ = -1;
};

}  // namespace sixdial::testing
