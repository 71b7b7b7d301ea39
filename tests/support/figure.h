// A measured figure of a test, on a line that scripts/reliability.sh collects; and a size that
// the script may raise through the environment.
#pragma once

#include <cstdio>
#include <cstdlib>
#include <string>

namespace sixdial::test {

/// "FIGURE crash.runs 200".
template <typename Number>
void figure(const std::string& key, Number value) {
  std::printf("FIGURE %s %.6g\n", key.c_str(), static_cast<double>(value));
  std::fflush(stdout);
}

/// `usual` unless the environment has a positive number of that name.
inline int size_of_run(const char* variable, int usual) {
  const char* text = std::getenv(variable);
  const int wanted = text == nullptr ? 0 : std::atoi(text);
  return wanted > 0 ? wanted : usual;
}

}  // namespace sixdial::test
