// The time of day of the service's own doings (jobs, events), as text. Samples carry the
// acquisition clock's time instead, which a mock rig may run faster.
#pragma once

#include <string>

namespace sixdial::session {

/// "2026-03-02T08:30:06.976Z", now.
[[nodiscard]] std::string now_utc_text();

}  // namespace sixdial::session
