// Turns the examples in the comments of headers into one test program:
//
//   extract_examples OUT SOURCE_DIR HEADER...
//
// An example is what stands indented below a line "// Example:" at the top of a header. It is
// the body of a function in the header's own namespace that may use what tests/examples/given.h
// gives (rig, session, ...). "expression;  // -> value" must be equal.
#include <filesystem>
#include <fstream>
#include <iostream>
#include <optional>
#include <regex>
#include <string>
#include <vector>

namespace {

struct Example {
  std::string namespace_name;
  std::size_t first_line = 0;  // of the header, counted from 1
  std::vector<std::string> lines;
};

/// The text of a comment line behind "// " or "/// ", or nothing where it is none.
std::optional<std::string> comment_in(const std::string& line) {
  static const std::regex comment(R"re(^///?(?: (.*))?$)re");
  std::smatch match;
  if (!std::regex_match(line, match, comment)) return std::nullopt;
  return match[1].str();
}

std::optional<Example> example_in(std::istream& header) {
  static const std::regex space(R"re(^namespace (sixdial::[a-z_:]+) \{)re");
  std::optional<Example> found;
  bool inside = false;
  std::size_t number = 0;
  for (std::string line; std::getline(header, line);) {
    ++number;
    const auto comment = comment_in(line);
    if (inside && comment && (comment->empty() || comment->starts_with("  "))) {
      found->lines.push_back(*comment);
      continue;
    }
    inside = !found && comment == "Example:";
    if (inside) found = Example{.namespace_name = {}, .first_line = number + 1, .lines = {}};
    std::smatch match;
    if (found && std::regex_search(line, match, space)) {
      found->namespace_name = match[1];
      break;
    }
  }
  return found;
}

/// "GeometryRobotKind" for "geometry/robot_kind.h".
std::string test_name(const std::string& header) {
  std::string name;
  bool capital = true;
  for (const char c : header.substr(0, header.rfind('.'))) {
    const bool letter = std::isalnum(static_cast<unsigned char>(c)) != 0;
    if (letter) name += capital ? static_cast<char>(std::toupper(c)) : c;
    capital = !letter;
  }
  return name;
}

/// An example's line as code; "a;  // -> b" asks whether both are equal.
std::string code_of(const std::string& line) {
  static const std::regex result(R"re(^(\s*)(.*?);\s+// -> (.*)$)re");
  std::smatch match;
  if (!std::regex_match(line, match, result)) return line;
  return match[1].str() + "EXPECT_EQ((" + match[2].str() + "), (" + match[3].str() + "));";
}

}  // namespace

int main(int count, char** arguments) {
  const std::vector<std::string> given(arguments + 1, arguments + count);
  std::ofstream out(given.at(0));
  const std::filesystem::path source = given.at(1);
  out << "// Made by tests/examples/extract_examples.cpp.\n";
  for (std::size_t i = 2; i < given.size(); ++i) out << "#include \"" << given[i] << "\"\n";
  out << "#include \"tests/examples/given.h\"\n";
  for (std::size_t i = 2; i < given.size(); ++i) {
    std::ifstream header(source / given[i]);
    const auto example = example_in(header);
    if (!example || example->lines.empty() || example->namespace_name.empty()) {
      std::cerr << given[i] << " shows no example of its use (a comment \"// Example:\")\n";
      return 1;
    }
    out << "\nnamespace " << example->namespace_name << " {\nnamespace {\n"
        << "using HeaderExample = sixdial::testing::HeaderExample;\n"
        << "TEST_F(HeaderExample, " << test_name(given[i]) << ") {\n"
        << "#line " << example->first_line << " \"" << (source / given[i]).string() << "\"\n";
    for (const std::string& line : example->lines) out << code_of(line) << "\n";
    out << "}\n}  // namespace\n}  // namespace " << example->namespace_name << "\n";
  }
  return out ? 0 : 1;
}
