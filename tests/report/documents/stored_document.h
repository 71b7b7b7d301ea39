// A document that an earlier version wrote: tests/data/documents/ORIGIN.md says how.
#pragma once

#include <gtest/gtest.h>

#include <fstream>
#include <string>

#include "report/documents/json.h"
#include "tests/support/paths.h"

namespace sixdial::report {

inline Json stored_document(const std::string& name) {
  std::ifstream file(test_paths::test_data() + "/documents/" + name);
  EXPECT_TRUE(file) << name;
  return Json::parse(file);
}

/// What is written equals what was read, key for key and digit for digit.
inline void expect_same_document(const Json& written, const Json& stored) {
  EXPECT_EQ(Json::parse(written.dump()), stored) << Json::diff(stored, written).dump(1);
}

}  // namespace sixdial::report
