// What can be done with a session now, and what each of the rest waits for: one answer for the
// live page's buttons and for anybody else who asks.
#pragma once

#include <string>

#include "service/service.h"

namespace sixdial::service {

/// {session, report_of ("calibration", "diagnosis" or null), warnings, choices {start, undo,
/// calibrate, diagnose, report: null where it can be done, else why not, in words}}. Throws
/// not_found.
[[nodiscard]] Json session_choices(Service& service, const std::string& name);

}  // namespace sixdial::service
