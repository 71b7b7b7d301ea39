// One name, one thing: no two folders have a type of the same name (doc/notation.md), so that a
// word means the same wherever it is read, and no two definitions can meet in one namespace.
#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <map>
#include <regex>
#include <set>
#include <sstream>
#include <string>

#include "tests/support/paths.h"

namespace {

namespace fs = std::filesystem;

/// Types that two folders may both have, because it is the same thing in another form.
const std::map<std::string, std::string>& shared_names() {
  static const std::string as_result =
      "the same thing as a result keeps it: ids and numbers, without pointers and fits";
  static const std::map<std::string, std::string> kShared{
      {"GainRow", as_result},
      {"GrossReading", as_result},
      {"Limit", as_result},
      {"NotTestable", as_result},
      {"Rival", as_result}};
  return kShared;
}

/// Names of the types that a header defines for others: not nested, not in an unnamed
/// namespace.
std::set<std::string> types_in(std::istream& header) {
  static const std::regex definition(
      R"re(^(?:struct|class|enum class|enum) ([A-Z]\w*)(?:[^;]*)?(?:\{.*)?$)re");
  std::set<std::string> names;
  for (std::string line; std::getline(header, line);) {
    std::smatch match;
    if (line.find(';') != std::string::npos && line.find('{') == std::string::npos) continue;
    if (std::regex_search(line, match, definition)) names.insert(match[1]);
  }
  return names;
}

TEST(Names, NoTwoFoldersHaveATypeOfTheSameName) {
  // mock_devices/ is the other end of each cable: the same words, by another hand.
  const std::set<std::string> folders{"geometry", "simulation", "session",     "calibration",
                                      "studies",  "diagnosis",  "acquisition", "db",
                                      "report",   "service",    "cli"};
  std::map<std::string, std::set<std::string>> where;
  for (const std::string& folder : folders) {
    for (const auto& entry : fs::recursive_directory_iterator(
             fs::path(sixdial::test_paths::source_dir()) / folder)) {
      if (entry.path().extension() != ".h") continue;
      std::ifstream in(entry.path());
      for (const std::string& name : types_in(in)) where[name].insert(folder);
    }
  }
  EXPECT_GT(where.size(), 300U);
  for (const auto& [name, in] : where) {
    std::string list;
    for (const std::string& folder : in) list += " " + folder;
    if (shared_names().contains(name)) {
      EXPECT_GT(in.size(), 1U) << name << " is in one folder only: take it off the list";
    } else {
      EXPECT_EQ(in.size(), 1U) << name << " is a type of" << list
                               << ": give each its own word (doc/notation.md)";
    }
  }
}

TEST(Names, TypesAreFoundInAHeader) {
  std::istringstream header(
      "struct Rig;\n"
      "struct Box {\n"
      "  struct Inner {};\n"
      "};\n"
      "class Open final : public Port {\n"
      "enum class Colour { kRed };\n");
  EXPECT_EQ(types_in(header), (std::set<std::string>{"Box", "Open", "Colour"}));
}

}  // namespace
