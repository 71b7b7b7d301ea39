// One session that is right, and faults put into it.
#pragma once

#include <gtest/gtest.h>

#include <filesystem>
#include <functional>
#include <string>
#include <vector>

#include "session/bundle.h"
#include "session/trials.h"
#include "studies/calibrate.h"
#include "studies/plausibility.h"
#include "tests/support/paths.h"

namespace sixdial::studies {

inline session::Session right_session() {
  return session::read_bundle(std::filesystem::path(test_paths::test_data()) / "session_00");
}

inline session::Session session_with(const std::function<void(session::Session&)>& fault) {
  session::Session session = right_session();
  fault(session);
  return session;
}

inline std::vector<std::string> codes_of(const std::vector<Warning>& warnings) {
  std::vector<std::string> codes;
  for (const Warning& each : warnings) codes.push_back(each.code);
  return codes;
}

/// The only warning of a session with one fault.
inline Warning only_warning(const PlausibleSession& judged) {
  EXPECT_EQ(judged.warnings.size(), 1U) << ::testing::PrintToString(codes_of(judged.warnings));
  return judged.warnings.empty() ? Warning() : judged.warnings.front();
}

inline double number(const Warning& warning, const std::string& part) {
  return std::get<double>(warning.parts.at(part));
}

inline std::size_t counted(const PlausibleSession& judged, const char* set) {
  return session::trials_of(judged.session, set).size();
}

inline CalibrationRequest quick() {
  CalibrationRequest request;
  request.method = "lm";
  request.threads = 1;
  return request;
}

}  // namespace sixdial::studies
