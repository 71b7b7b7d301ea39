#include "run_program.h"

#include <fmt/format.h>
#include <stdlib.h>  // mkdtemp
#include <sys/wait.h>

#include <cstdlib>
#include <fstream>
#include <sstream>
#include <stdexcept>
#include <system_error>

namespace sixdial::report {
namespace {

std::string text_of(const std::filesystem::path& path) {
  std::ifstream file{path, std::ios::binary};
  std::ostringstream out;
  out << file.rdbuf();
  return out.str();
}

}  // namespace

Ran run_program(const std::string& command) {
  const TemporaryFolder folder;
  const std::string script = folder.write("command.sh", command + "\n");
  const std::string base = folder.path().string();
  const int status = std::system(
      fmt::format("timeout 120 sh {0} >{1}/out 2>{1}/err </dev/null", script, base).c_str());
  Ran out;
  out.exit_code = WIFEXITED(status) ? WEXITSTATUS(status) : -1;
  out.out = text_of(folder.path() / "out");
  out.err = text_of(folder.path() / "err");
  return out;
}

TemporaryFolder::TemporaryFolder() {
  std::string name =
      (std::filesystem::temp_directory_path() / "sixdial_report_XXXXXX").string();
  if (mkdtemp(name.data()) == nullptr) {
    throw std::system_error(errno, std::generic_category(), "no folder for the test: " + name);
  }
  path_ = name;
}

TemporaryFolder::~TemporaryFolder() {
  std::error_code ignored;  // a browser may still be writing its last file
  std::filesystem::remove_all(path_, ignored);
}

std::string TemporaryFolder::write(const std::string& name, const std::string& text) const {
  const std::filesystem::path path = path_ / name;
  std::ofstream file{path, std::ios::binary};
  file << text;
  if (!file.flush()) throw std::runtime_error("cannot write " + path.string());
  return path.string();
}

}  // namespace sixdial::report
