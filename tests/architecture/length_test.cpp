// No function of more than 80 lines and no file of more than 450, unless
// doc/decisions/0007-long-functions-and-files.md names it and says why.
#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <optional>
#include <regex>
#include <set>
#include <sstream>
#include <string>
#include <utility>
#include <vector>

#include "tests/support/paths.h"

namespace {

namespace fs = std::filesystem;

constexpr std::size_t kMostOfFunction = 80;
constexpr std::size_t kMostOfFile = 450;
constexpr const char* kDecision = "doc/decisions/0007-long-functions-and-files.md";

struct Function {
  std::string first_line;
  std::size_t at = 0;  // line number of its head
  std::size_t lines = 0;
};

std::vector<std::string> lines_of(std::istream& in) {
  std::vector<std::string> lines;
  for (std::string line; std::getline(in, line);) lines.push_back(line);
  return lines;
}

std::size_t indent_of(const std::string& line) { return line.find_first_not_of(' '); }

/// Whether a line cannot be the first of a declaration that goes on in the next one.
bool ends_what_was_before(const std::string& line) {
  static const std::regex end(
      R"re((^\s*$)|(^\s*(//|#|template\b|\w+:$))|([;{}]\s*(//.*)?$))re");
  return std::regex_search(line, end);
}

/// The head of a function whose body begins in line `open`, as the formatter leaves it: its
/// first line, or nothing where another thing begins there.
std::optional<std::size_t> head_of(const std::vector<std::string>& lines, std::size_t open) {
  static const std::regex other(
      R"re(^\s*(if|for|while|switch|else|do|try|catch|return|namespace|struct|class|enum|union|case|default|[.{}/#"\[])|^\s*extern "C")re");
  if (!lines[open].ends_with('{') || std::regex_search(lines[open], other)) return {};
  std::size_t first = open;
  std::string head = lines[open];
  while (first > 0 && !ends_what_was_before(lines[first - 1])) head = lines[--first] + head;
  const std::size_t bracket = head.find('(');
  if (bracket == std::string::npos || std::regex_search(lines[first], other)) return {};
  // A row of a table, or a lambda that is given a name.
  if (head.find('"') < bracket) return {};
  if (head.find('=') < bracket && head.find("operator") == std::string::npos) return {};
  return first;
}

/// Functions from their head to the brace that stands as far left as the head does.
std::vector<Function> functions_in(const std::vector<std::string>& lines) {
  std::vector<Function> found;
  for (std::size_t i = 0; i < lines.size(); ++i) {
    const auto first = head_of(lines, i);
    if (!first) continue;
    const std::string end = std::string(indent_of(lines[*first]), ' ') + "}";
    std::size_t last = i + 1;
    while (last < lines.size() && !lines[last].starts_with(end)) ++last;
    found.push_back({lines[*first], *first + 1, last - *first + 1});
    i = last;
  }
  return found;
}

/// What the decision names: a file alone, or a file and a part of a function's first line.
std::vector<std::pair<std::string, std::string>> allowed() {
  std::ifstream in(sixdial::test_paths::source_dir() + "/" + kDecision);
  static const std::regex row(R"re(^\| `([^`]+)` \| (?:`([^`]+)`)? *\| (.{20,}) \|$)re");
  std::vector<std::pair<std::string, std::string>> named;
  for (const std::string& line : lines_of(in)) {
    std::smatch match;
    if (std::regex_match(line, match, row)) named.emplace_back(match[1], match[2]);
  }
  return named;
}

std::vector<fs::path> sources() {
  static const std::set<std::string> beside{"build", ".git", "out", "doc", "examples"};
  std::vector<fs::path> files;
  for (const auto& folder : fs::directory_iterator(sixdial::test_paths::source_dir())) {
    if (!folder.is_directory() || beside.contains(folder.path().filename())) continue;
    for (const auto& entry : fs::recursive_directory_iterator(folder)) {
      const std::string extension = entry.path().extension();
      if (extension == ".h" || extension == ".cpp") files.push_back(entry.path());
    }
  }
  return files;
}

TEST(Length, LongFunctionsAndFilesHaveAReason) {
  const auto named = allowed();
  std::set<std::size_t> used;
  const auto may = [&](const std::string& file, const std::string& line) {
    for (std::size_t i = 0; i < named.size(); ++i) {
      if (named[i].first != file || named[i].second.empty() != line.empty()) continue;
      if (!line.empty() && line.find(named[i].second) == std::string::npos) continue;
      used.insert(i);
      return true;
    }
    return false;
  };
  std::size_t functions = 0;
  for (const fs::path& path : sources()) {
    const std::string name = fs::relative(path, sixdial::test_paths::source_dir());
    std::ifstream in(path);
    const std::vector<std::string> lines = lines_of(in);
    EXPECT_TRUE(lines.size() <= kMostOfFile || may(name, ""))
        << name << " has " << lines.size() << " lines: split it, or say why in " << kDecision;
    for (const Function& each : functions_in(lines)) {
      ++functions;
      EXPECT_TRUE(each.lines <= kMostOfFunction || may(name, each.first_line))
          << name << ":" << each.at << ": " << each.lines << " lines: " << each.first_line
          << "\nshorten it, or say why in " << kDecision;
    }
  }
  EXPECT_GT(functions, 3'000U);
  for (std::size_t i = 0; i < named.size(); ++i) {
    EXPECT_TRUE(used.contains(i))
        << kDecision << " names what is not long any more: " << named[i].first << " "
        << named[i].second;
  }
}

TEST(Length, CountsAFunctionFromItsHeadToItsBrace) {
  std::istringstream text(
      "constexpr std::array kTable{\n"
      "    Row{.name = \"a\", .run = call(1)},\n"
      "};\n"
      "\n"
      "// a comment\n"
      "std::vector<int>\n"
      "numbers(\n"
      "    int a, int b) {\n"
      "  for (int i = 0; i < a; ++i) {\n"
      "  }\n"
      "  return {};\n"
      "}\n"
      "\n"
      "class Box {\n"
      " public:\n"
      "  Box(int a)\n"
      "      : a_(a) {\n"
      "    if (a > 0) {\n"
      "    }\n"
      "  }\n"
      "};\n");
  const auto found = functions_in(lines_of(text));
  ASSERT_EQ(found.size(), 2U);
  EXPECT_EQ(found[0].at, 6U);
  EXPECT_EQ(found[0].lines, 7U);
  EXPECT_EQ(found[1].at, 16U);
  EXPECT_EQ(found[1].lines, 5U);
}

}  // namespace
