#include "session/clock_text.h"

#include <chrono>

#include "session/session.h"

namespace sixdial::session {

std::string now_utc_text() {
  return session::to_iso8601(
      std::chrono::floor<std::chrono::milliseconds>(std::chrono::system_clock::now()));
}

}  // namespace sixdial::session
