// The twenty sessions with answers, their diagnosis without what takes time, and its document.
#pragma once

#include <filesystem>
#include <set>
#include <stdexcept>
#include <string>

#include "report/documents/diagnosis_json.h"
#include "session/bundle.h"
#include "studies/diagnose.h"
#include "tests/support/paths.h"

namespace sixdial::studies {

inline const std::filesystem::path kSessions =
    std::filesystem::path(test_paths::test_data()) / "sessions";

inline session::Session session_of(const std::string& number) {
  return session::read_bundle(kSessions / number);
}

/// Without what takes time: networks and simulated noise.
inline DiagnosisResult quick_result(const session::Session& session) {
  return diagnose(session, {.bootstrap = 0, .with_gain = false});
}
inline Json quick(const session::Session& session) {
  return report::to_json(quick_result(session));
}

inline std::string name_of(const Json& cause) {
  return cause["cause"].get<std::string>() + "@" + cause["where"].get<std::string>();
}

inline std::set<std::string> names_of(const Json& document) {
  std::set<std::string> names;
  for (const Json& cause : document["causes"]) names.insert(name_of(cause));
  return names;
}

inline const Json& cause_of(const Json& document, const std::string& name) {
  for (const Json& cause : document["causes"]) {
    if (name_of(cause) == name) return cause;
  }
  throw std::runtime_error("no cause " + name);
}

}  // namespace sixdial::studies
