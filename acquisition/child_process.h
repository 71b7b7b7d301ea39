// A program of the user's own, run to its end: without a shell, in a process group of its own,
// with a small environment, and no file of this process open in it.
#pragma once

#include <chrono>
#include <span>
#include <stop_token>
#include <string>

namespace sixdial::acquisition {

enum class ProcessEnd {
  kExited,      // by itself, `code` is its exit code
  kSignal,      // by a signal, `code` is its number
  kTimeout,     // it was killed: not done in its time
  kStopped,     // it was killed: `stop` was asked for
  kNotStarted,  // `err` says why
};

struct ProcessResult {
  ProcessEnd end = ProcessEnd::kNotStarted;
  int code = 0;
  std::string out;  // what it printed, the first kMostPrinted bytes
  std::string err;
};
inline constexpr std::size_t kMostPrinted = std::size_t{64} * 1024;

/// What the program sees of this process's environment: these, if they are set.
[[nodiscard]] std::span<const char* const> passed_on_variables();

/// `words[0]` is the program's path; the others reach it as they are. Blocks. Whoever is killed
/// gets SIGTERM, with all that it has started, and `grace` later SIGKILL. Times are on the
/// wall.
[[nodiscard]] ProcessResult run_program(
    std::span<const std::string> words, std::chrono::nanoseconds timeout,
    std::chrono::nanoseconds grace, const std::stop_token& stop);

}  // namespace sixdial::acquisition
