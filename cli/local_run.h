// A calculation on a bundle in this process: a progress line while it runs, and Ctrl-C ends it.
#pragma once

#include <functional>
#include <optional>
#include <stop_token>
#include <string>
#include <type_traits>
#include <utility>

#include "cli/console.h"
#include "session/session.h"
#include "studies/error.h"
#include "studies/progress.h"

namespace sixdial::cli {

using LocalWork = std::function<void(const studies::ProgressCallback&, std::stop_token)>;

/// `what` names the work for the person who interrupts it ("the calibration"). Throws
/// Interrupted after a signal, and says that nothing was kept; else what the work throws.
void run_with_progress(const Console& console, const std::string& what, const LocalWork& work);

/// Warns of what speaks against a session.
void tell_why(const Console& console, const session::Session& session);

/// The same, and gives what the work returns.
template <class Work>
[[nodiscard]] auto run_here(const Console& console, const std::string& what, const Work& work) {
  std::optional<std::invoke_result_t<Work, const studies::ProgressCallback&, std::stop_token>>
      result;
  run_with_progress(
      console, what, [&](const studies::ProgressCallback& progress, std::stop_token stop) {
        result.emplace(work(progress, std::move(stop)));
      });
  return *std::move(result);
}

/// The calibration or diagnosis that a command needs first. Off a terminal one line announces
/// it: its progress would be longer than the answer. `option`: what takes a stored one.
template <class Work>
[[nodiscard]] auto made_first(
    const Console& console, const std::string& what, const std::string& option,
    const Work& work) {
  Console calm = console;
  if (!console.terminal && !console.quiet) {
    console.note("making " + what + " first; " + option + " FILE takes a stored one");
    calm.quiet = true;
  }
  return run_here(calm, what, work);
}

/// The same with a session: what speaks against it is told where the work gives up, too.
template <class Work>
[[nodiscard]] auto run_on(
    const Console& console, const session::Session& session, const std::string& what,
    const Work& work) {
  try {
    return run_here(console, what, work);
  } catch (const studies::StudyError& error) {
    if (error.code() == studies::StudyErrorCode::kBadData) tell_why(console, session);
    throw;
  }
}

}  // namespace sixdial::cli
