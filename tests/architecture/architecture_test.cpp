// Reads the includes of every folder and refuses an arrow that allowed.txt does not name.
#include <gtest/gtest.h>

#include <algorithm>
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
  static const std::regex json(R"re(^\s*#\s*include\s*[<"](nlohmann/|.*[/_]json\.h))re");
  // JSON is a format at the border: whoever computes or measures returns structs.
  static const std::set<std::string> may_say_json{
      "report", "service", "cli", "apps", "mock_devices"};
  // ... and the wire protocol of one controller.
  const bool speaks_json = file.ends_with("acquisition/robots/klipper/message.cpp");
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
    if (!may_say_json.contains(folder) && !speaks_json && std::regex_search(line, json)) {
      wrong.push_back(where + folder + " must not include JSON");
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

/// Lines of a list, without its comments.
std::vector<std::string> lines_of(const std::string& file) {
  std::ifstream in(sixdial::test_paths::source_dir() + "/tests/architecture/" + file);
  std::vector<std::string> lines;
  for (std::string line; std::getline(in, line);) {
    if (!line.empty() && line[0] != '#') lines.push_back(line);
  }
  return lines;
}

const std::regex& five_bar_words() {
  static const std::regex words(
      R"re(theta1|\bl11\b|kParameterCount|Parameter(Vector|Matrix|Jacobian)\b)re");
  return words;
}

/// The first line of a text that says what only a five-bar has; 0: none does.
int says_five_bar(std::istream& text) {
  int number = 0;
  for (std::string line; std::getline(text, line);) {
    ++number;
    if (std::regex_search(line, five_bar_words())) return number;
  }
  return 0;
}

TEST(Architecture, OnlyListedFilesKnowThatTheRobotIsAFiveBar) {
  constexpr std::size_t kMost = 3;  // names in the list: it only gets shorter
  const std::vector<std::string> listed = lines_of("five_bar_words.txt");
  EXPECT_LE(listed.size(), kMost);
  const std::set<std::string> free_to{"geometry", "mock_devices", "session"};
  const fs::path root = sixdial::test_paths::source_dir();
  int files = 0;
  for (const auto& [folder, unused] : the_allowed()) {
    if (free_to.contains(folder) || !fs::exists(root / folder)) continue;
    for (const auto& entry : fs::recursive_directory_iterator(root / folder)) {
      const std::string extension = entry.path().extension();
      if (extension != ".h" && extension != ".cpp" && extension != ".js") continue;
      const std::string name = fs::relative(entry.path(), root);
      const bool may = std::any_of(listed.begin(), listed.end(), [&](const std::string& each) {
        return each.ends_with('/') ? name.starts_with(each) : name == each;
      });
      ++files;
      if (may || name.starts_with("db/migrations/")) continue;
      std::ifstream in(entry.path());
      const int line = says_five_bar(in);
      EXPECT_EQ(line, 0) << name << ":" << line
                         << ": take joints and parameters from the robot kind's lists";
    }
  }
  EXPECT_GT(files, 100);
}

TEST(Architecture, AFiveBarsWordIsFoundByItsLine) {
  std::istringstream text("int q;\ngeometry::ParameterVector v;\n");
  EXPECT_EQ(says_five_bar(text), 2);
  std::istringstream other("double theta = 1; int l112; ParameterVectors all;\n");
  EXPECT_EQ(says_five_bar(other), 0);
}

TEST(Architecture, AWrongArrowIsNamedByFileAndLine) {
  std::istringstream text("#include <vector>\n#include \"db/store.h\"\n");
  const auto wrong = wrong_arrows(the_allowed(), "geometry", "geometry/x.cpp", text);
  ASSERT_EQ(wrong.size(), 1U);
  EXPECT_EQ(wrong[0], "geometry/x.cpp:2: geometry must not include db");
  std::istringstream json(
      "#include <nlohmann/json.hpp>\n#include \"report/documents/json.h\"\n");
  EXPECT_EQ(wrong_arrows(the_allowed(), "studies", "x", json).size(), 3U);
  std::istringstream again(json.str());
  EXPECT_EQ(
      wrong_arrows(the_allowed(), "acquisition", "acquisition/robots/klipper/robot.cpp", again)
          .size(),
      3U)
      << "its message.cpp only";
  std::istringstream asio("#include <boost/asio.hpp>\n");
  EXPECT_EQ(wrong_arrows(the_allowed(), "db", "x", asio).size(), 1U);
}

}  // namespace
