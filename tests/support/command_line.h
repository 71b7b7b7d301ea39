// The command line in this process: what it prints and how it ends.
#pragma once

#include <sstream>
#include <string>
#include <vector>

#include "cli/cli.h"
#include "report/documents/json.h"

namespace sixdial::testing {

struct Outcome {
  int code = -1;
  std::string out, err;
  [[nodiscard]] Json json() const { return Json::parse(out); }
};

/// `words` without the program's name: {"calibrate", "monday"}.
inline Outcome sixdial(std::vector<std::string> words) {
  words.insert(words.begin(), "sixdial");
  std::vector<const char*> arguments;
  for (const std::string& word : words) arguments.push_back(word.c_str());
  std::ostringstream out;
  std::ostringstream err;
  Outcome outcome;
  outcome.code = cli::run(static_cast<int>(arguments.size()), arguments.data(), out, err);
  outcome.out = out.str();
  outcome.err = err.str();
  return outcome;
}

}  // namespace sixdial::testing
