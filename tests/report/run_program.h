// Runs a program of the system, for tests that let another judge look at what we made.
#pragma once

#include <filesystem>
#include <string>

namespace sixdial::report {

struct Ran {
  int exit_code = -1;
  std::string out, err;
};
/// `command` by /bin/sh, at most 120 s.
[[nodiscard]] Ran run_program(const std::string& command);

/// A folder that is removed again.
class TemporaryFolder {
 public:
  TemporaryFolder();
  ~TemporaryFolder();
  TemporaryFolder(const TemporaryFolder&) = delete;
  TemporaryFolder& operator=(const TemporaryFolder&) = delete;
  [[nodiscard]] const std::filesystem::path& path() const { return path_; }
  /// Writes a file and returns its path.
  [[nodiscard]] std::string write(const std::string& name, const std::string& text) const;

 private:
  std::filesystem::path path_;
};

}  // namespace sixdial::report
