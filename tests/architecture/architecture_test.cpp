// Reads the includes of every folder and refuses an arrow that allowed.txt does not name.
#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <map>
#include <regex>
#include <set>
#include <sstream>
#include <string>
#include <vector>

#include "tests/support/paths.h"

namespace {

namespace fs = std::filesystem;
using Allowed = std::map<std::string, std::set<std::string>>;

Allowed read_allowed(std::istream& in) {
  Allowed allowed;
  for (std::string line; std::getline(in, line);) {
    if (line.empty() || line[0] == '#') continue;
    const auto colon = line.find(':');
    const std::string folder = line.substr(0, colon);
    std::istringstream rest(line.substr(colon + 1));
    allowed[folder].insert(folder);
    for (std::string name; rest >> name;) allowed[folder].insert(name);
  }
  return allowed;
}

/// "file:line: geometry must not include db" for each wrong arrow in one file's text.
std::vector<std::string> wrong_arrows(
    const Allowed& allowed, const std::string& folder, const std::string& file,
    std::istream& text) {
  static const std::regex include(R"re(^\s*#\s*include\s*"([a-z_]+)/[^"]*")re");
  static const std::regex asio(R"re(^\s*#\s*include\s*<boost/(asio|beast)[/.])re");
  std::vector<std::string> wrong;
  int number = 0;
  for (std::string line; std::getline(text, line);) {
    ++number;
    const std::string where = file + ":" + std::to_string(number) + ": ";
    std::smatch match;
    if (std::regex_search(line, match, include)) {
      if (allowed.contains(match[1]) && !allowed.at(folder).contains(match[1])) {
        wrong.push_back(where + folder + " must not include " + match[1].str());
      }
    }
    if (folder != "service" && std::regex_search(line, asio)) {
      wrong.push_back(where + "Asio belongs to service only");
    }
  }
  return wrong;
}

Allowed the_allowed() {
  std::ifstream in(sixdial::test_paths::source_dir() + "/tests/architecture/allowed.txt");
  return read_allowed(in);
}

TEST(Architecture, NoFolderIncludesWhatItMustNot) {
  const Allowed allowed = the_allowed();
  int files = 0;
  for (const auto& [folder, unused] : allowed) {
    const fs::path root = fs::path(sixdial::test_paths::source_dir()) / folder;
    if (!fs::exists(root)) continue;
    for (const auto& entry : fs::recursive_directory_iterator(root)) {
      const std::string extension = entry.path().extension();
      if (extension != ".h" && extension != ".cpp") continue;
      ++files;
      std::ifstream in(entry.path());
      for (const auto& line : wrong_arrows(allowed, folder, entry.path(), in)) {
        ADD_FAILURE() << line;
      }
    }
  }
  EXPECT_GT(files, 10);
}

TEST(Architecture, EveryFolderWithCodeIsListed) {
  const Allowed allowed = the_allowed();
  static const std::set<std::string> beside{"tests", "bench", "cmake",
                                            "doc",   "build", "examples"};
  for (const auto& entry : fs::directory_iterator(sixdial::test_paths::source_dir())) {
    const std::string name = entry.path().filename();
    if (!entry.is_directory() || name[0] == '.' || beside.contains(name)) continue;
    bool code = false;
    for (const auto& file : fs::recursive_directory_iterator(entry)) {
      code = code || file.path().extension() == ".cpp";
    }
    EXPECT_TRUE(!code || allowed.contains(name)) << name << " is not in allowed.txt";
  }
}

TEST(Architecture, AWrongArrowIsNamedByFileAndLine) {
  std::istringstream text("#include <vector>\n#include \"db/store.h\"\n");
  const auto wrong = wrong_arrows(the_allowed(), "geometry", "geometry/x.cpp", text);
  ASSERT_EQ(wrong.size(), 1U);
  EXPECT_EQ(wrong[0], "geometry/x.cpp:2: geometry must not include db");
  std::istringstream asio("#include <boost/asio.hpp>\n");
  EXPECT_EQ(wrong_arrows(the_allowed(), "db", "x", asio).size(), 1U);
}

}  // namespace
