#include "acquisition/child_process.h"

#include <fcntl.h>
#include <poll.h>
#include <spawn.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <csignal>
#include <cstdlib>
#include <cstring>
#include <optional>
#include <string_view>
#include <utility>
#include <vector>

namespace sixdial::acquisition {
namespace {

using std::chrono::milliseconds;
using std::chrono::nanoseconds;
using std::chrono::steady_clock;

constexpr milliseconds kSlice{20};  // an end or a stop is seen within this

// Enough to find programs, a home and a ROS installation; no tokens, no sockets of this
// service.
constexpr std::array kPassedOn{
    "PATH", "HOME", "LANG", "LC_ALL", "TZ", "TMPDIR", "LD_LIBRARY_PATH", "PYTHONPATH"};
constexpr const char* kUsualPath = "PATH=/usr/local/bin:/usr/bin:/bin";

/// Two ends of a pipe; closed with the object.
class Pipe {
 public:
  Pipe() { good_ = ::pipe2(ends_.data(), O_CLOEXEC) == 0; }
  ~Pipe() {
    close_end(0);
    close_end(1);
  }
  Pipe(const Pipe&) = delete;
  Pipe& operator=(const Pipe&) = delete;
  [[nodiscard]] bool good() const { return good_; }
  [[nodiscard]] int read_end() const { return ends_[0]; }
  [[nodiscard]] int write_end() const { return ends_[1]; }
  void close_end(std::size_t which) {
    if (ends_[which] >= 0) ::close(std::exchange(ends_[which], -1));
  }
  /// What is there now, up to the limit of `text`; the rest is dropped.
  void drain(std::string& text) {
    std::array<char, 4096> bytes{};
    while (ends_[0] >= 0) {
      const ssize_t got = ::read(ends_[0], bytes.data(), bytes.size());
      if (got > 0) {
        const std::size_t room = kMostPrinted - std::min(kMostPrinted, text.size());
        text.append(bytes.data(), std::min(room, static_cast<std::size_t>(got)));
      } else if (got == 0) {
        close_end(0);
      } else if (errno != EINTR) {
        return;
      }
    }
  }

 private:
  std::array<int, 2> ends_{-1, -1};
  bool good_ = false;
};

std::vector<std::string> small_environment() {
  std::vector<std::string> all;
  bool has_path = false;
  for (const char* const name : kPassedOn) {
    const char* value = std::getenv(name);
    if (value == nullptr) continue;
    all.push_back(std::string(name) + '=' + value);
    has_path = has_path || std::string_view(name) == "PATH";
  }
  if (!has_path) all.emplace_back(kUsualPath);
  return all;
}

std::vector<char*> pointers(std::vector<std::string>& words) {
  std::vector<char*> result;
  for (std::string& word : words) result.push_back(word.data());
  result.push_back(nullptr);
  return result;
}

/// 0 and the process, or why not.
int spawn(std::span<const std::string> words, const Pipe& out, const Pipe& err, pid_t& child) {
  posix_spawn_file_actions_t files;
  posix_spawnattr_t attributes;
  ::posix_spawn_file_actions_init(&files);
  ::posix_spawnattr_init(&attributes);
  ::posix_spawn_file_actions_addopen(&files, 0, "/dev/null", O_RDONLY, 0);
  ::posix_spawn_file_actions_adddup2(&files, out.write_end(), 1);
  ::posix_spawn_file_actions_adddup2(&files, err.write_end(), 2);
  ::posix_spawn_file_actions_addclosefrom_np(&files, 3);
  // This process blocks and ignores signals that a script counts on.
  sigset_t none;
  sigset_t all;
  sigemptyset(&none);
  sigfillset(&all);
  ::posix_spawnattr_setsigmask(&attributes, &none);
  ::posix_spawnattr_setsigdefault(&attributes, &all);
  ::posix_spawnattr_setpgroup(&attributes, 0);
  ::posix_spawnattr_setflags(
      &attributes, POSIX_SPAWN_SETSIGMASK | POSIX_SPAWN_SETSIGDEF | POSIX_SPAWN_SETPGROUP);
  std::vector<std::string> arguments(words.begin(), words.end());
  std::vector<std::string> environment = small_environment();
  const std::vector<char*> argv = pointers(arguments);
  const std::vector<char*> envp = pointers(environment);
  const int trouble =
      ::posix_spawn(&child, argv[0], &files, &attributes, argv.data(), envp.data());
  ::posix_spawnattr_destroy(&attributes);
  ::posix_spawn_file_actions_destroy(&files);
  return trouble;
}

}  // namespace

std::span<const char* const> passed_on_variables() { return kPassedOn; }

ProcessResult run_program(
    std::span<const std::string> words, nanoseconds timeout, nanoseconds grace,
    const std::stop_token& stop) {
  ProcessResult result;
  Pipe out;
  Pipe err;
  if (words.empty() || !out.good() || !err.good()) {
    result.err = words.empty() ? "no program is named" : std::strerror(errno);
    return result;
  }
  pid_t child = -1;
  if (const int trouble = spawn(words, out, err, child); trouble != 0) {
    result.err = std::strerror(trouble);
    return result;
  }
  out.close_end(1);
  err.close_end(1);
  ::fcntl(out.read_end(), F_SETFL, O_NONBLOCK);
  ::fcntl(err.read_end(), F_SETFL, O_NONBLOCK);
  const auto deadline = steady_clock::now() + timeout;
  std::optional<steady_clock::time_point> kill_at;
  std::optional<ProcessEnd> killed;
  int status = 0;
  for (;;) {
    std::array<pollfd, 2> watched{
        pollfd{.fd = out.read_end(), .events = POLLIN, .revents = 0},
        pollfd{.fd = err.read_end(), .events = POLLIN, .revents = 0}};
    ::poll(watched.data(), watched.size(), static_cast<int>(kSlice.count()));
    out.drain(result.out);
    err.drain(result.err);
    const pid_t ended = ::waitpid(child, &status, WNOHANG);
    if (ended == child || (ended < 0 && errno != EINTR)) break;
    const auto now = steady_clock::now();
    if (!killed && (stop.stop_requested() || now >= deadline)) {
      killed = stop.stop_requested() ? ProcessEnd::kStopped : ProcessEnd::kTimeout;
      kill_at = now + grace;
      ::kill(-child, SIGTERM);
    } else if (kill_at && now >= *kill_at) {
      ::kill(-child, SIGKILL);
      kill_at = now + grace;
    }
  }
  out.drain(result.out);
  err.drain(result.err);
  // What it has started goes with it.
  if (killed) ::kill(-child, SIGKILL);
  result.end = killed                ? *killed
               : WIFSIGNALED(status) ? ProcessEnd::kSignal
                                     : ProcessEnd::kExited;
  result.code = WIFSIGNALED(status) ? WTERMSIG(status) : WEXITSTATUS(status);
  return result;
}

}  // namespace sixdial::acquisition
