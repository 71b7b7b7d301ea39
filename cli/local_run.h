// A calculation on a bundle in this process: a progress line while it runs, and Ctrl-C ends it.
#pragma once

#include <functional>
#include <stop_token>
#include <string>

#include "cli/console.h"
#include "service/job_board.h"

namespace sixdial::cli {

using LocalWork = std::function<Json(
    const std::function<void(service::JobProgress)>& progress, std::stop_token stop)>;

/// The work's document. `what` names it for the person who interrupts it ("the calibration").
/// Throws Interrupted after a signal, and says that nothing was kept; else what the work
/// throws.
[[nodiscard]] Json run_here(
    const Console& console, const std::string& what, const LocalWork& work);

}  // namespace sixdial::cli
