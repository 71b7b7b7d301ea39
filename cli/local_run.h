// A calculation on a bundle in this process: a progress line while it runs, and Ctrl-C ends it.
#pragma once

#include <functional>
#include <optional>
#include <stop_token>
#include <string>
#include <type_traits>
#include <utility>

#include "cli/console.h"
#include "service/job_board.h"

namespace sixdial::cli {

using LocalProgress = std::function<void(service::JobProgress)>;
using LocalWork = std::function<void(const LocalProgress& progress, std::stop_token stop)>;

void do_here(const Console& console, const std::string& what, const LocalWork& work);

/// The work's result. `what` names it for the person who interrupts it ("the calibration").
/// Throws Interrupted after a signal, and says that nothing was kept; else what the work
/// throws.
template <class Work>
[[nodiscard]] auto run_here(const Console& console, const std::string& what, const Work& work) {
  std::optional<std::invoke_result_t<Work, const LocalProgress&, std::stop_token>> result;
  do_here(console, what, [&](const LocalProgress& progress, std::stop_token stop) {
    result = work(progress, std::move(stop));
  });
  return std::move(*result);
}

}  // namespace sixdial::cli
