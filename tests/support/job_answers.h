// What a job of the service came to, asked for through its socket.
#pragma once

#include <string>

#include "tests/support/rig_for_tests.h"

namespace sixdial::testing {

/// State of a job once it has ended, however long that takes: ctest's limit ends a test that
/// hangs.
inline Json finished(LineClient& client, const Json& job) {
  // A client of these tests waits kPatience for an answer and no longer.
  constexpr int kPiece_s = 20;
  static_assert(std::chrono::seconds(2 * kPiece_s) < kPatience);
  Json status;
  do {
    status = client.call("job.wait", {{"job", job["job"]}, {"timeout_s", kPiece_s}})["result"];
  } while (status["state"] == "queued" || status["state"] == "running");
  return status;
}

/// A stored result, page by page.
inline Json whole_result(LineClient& client, const Json& result) {
  std::string text;
  for (;;) {
    const Json page =
        client.call("result.get", {{"result", result}, {"offset", text.size()}})["result"];
    text += page["text"].get<std::string>();
    if (page["next_offset"].is_null()) return Json::parse(text);
  }
}

}  // namespace sixdial::testing
