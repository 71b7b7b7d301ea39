// Every command that a message or a page of the manual advises is understood by the parser:
// nobody is sent to an option that does not exist.
#include <gtest/gtest.h>

#include <filesystem>
#include <regex>
#include <set>
#include <sstream>

#include "cli/cli.h"
#include "session/csv.h"
#include "tests/support/paths.h"

namespace sixdial::cli {
namespace {

const std::filesystem::path kSource = test_paths::source_dir();

struct Advice {
  std::string from;  // file
  std::string text;  // "sixdial compare {session} --space dials"
};

/// String literals of C++, those that follow each other as one.
std::vector<std::string> literals_in(const std::string& code) {
  std::vector<std::string> literals;
  bool joined = false;  // the next one continues the last
  for (std::size_t i = 0; i < code.size(); ++i) {
    if (code.compare(i, 2, "//") == 0) {
      i = std::min(code.find('\n', i), code.size());
    } else if (code[i] == '\'' && i + 2 < code.size()) {
      const std::size_t end = code.find('\'', i + (code[i + 1] == '\\' ? 3 : 2));
      if (end != std::string::npos && end - i < 8) i = end;
      joined = false;
    } else if (code[i] == '"') {
      std::string text;
      for (++i; i < code.size() && code[i] != '"'; ++i) {
        if (code[i] != '\\') {
          text += code[i];
        } else if (code[++i] == '"') {
          text += '"';
        } else {
          text += ' ';
        }
      }
      if (joined) {
        literals.back() += text;
      } else {
        literals.push_back(text);
      }
      joined = true;
    } else if (std::isspace(static_cast<unsigned char>(code[i])) == 0) {
      joined = false;
    }
  }
  return literals;
}

/// From "sixdial " to where the sentence goes on: a quote, a bracket, a comma, the end.
std::vector<std::string> commands_in(const std::string& text) {
  std::vector<std::string> commands;
  for (std::size_t at = text.find("sixdial "); at != std::string::npos;
       at = text.find("sixdial ", at + 1)) {
    if (at > 0 && (std::isalnum(static_cast<unsigned char>(text[at - 1])) != 0 ||
                   text[at - 1] == '-' || text[at - 1] == '/')) {
      continue;
    }
    // The group "sixdial" that a user joins is no command.
    if (text.compare(at, 9, "sixdial $") == 0) continue;
    const std::size_t end = text.find_first_of("\"`;()\n#>", at);
    commands.push_back(text.substr(at, end == std::string::npos ? end : end - at));
  }
  return commands;
}

std::vector<Advice> all_advice() {
  std::vector<Advice> advice;
  const auto add = [&](const std::filesystem::path& file) {
    const std::string text = session::read_file(file.string());
    const bool code = file.extension() != ".md";
    for (const std::string& literal : code ? literals_in(text) : std::vector{text}) {
      for (const std::string& command : commands_in(literal)) {
        advice.push_back({file.lexically_relative(kSource).string(), command});
      }
    }
  };
  for (const char* folder :
       {"acquisition", "calibration", "cli", "db", "diagnosis", "doc", "geometry", "report",
        "service", "session", "simulation", "studies"}) {
    for (const auto& each : std::filesystem::recursive_directory_iterator(kSource / folder)) {
      const auto kind = each.path().extension();
      if (kind == ".cpp" || kind == ".h" || kind == ".md") add(each.path());
    }
  }
  add(kSource / "README.md");
  return advice;
}

/// Words of a command as somebody would type them: what stands for something is filled in.
std::vector<std::string> words_of(const std::string& command) {
  std::string text = std::regex_replace(command, std::regex(R"(\{[^}]*\})"), "1");
  text = std::regex_replace(text, std::regex(R"("?\$[A-Z_]+[^ ]*)"), "folder/");
  std::istringstream in(text);
  std::vector<std::string> words;
  std::string word;
  in >> word;  // "sixdial"
  while (in >> word) {
    const bool ends = word.back() == ',' || word.back() == '.' || word.back() == ':';
    if (ends) word.pop_back();
    if (word == "..." || word.empty()) break;
    if (word == "MM") word = "1";  // stands for millimetres
    words.push_back(word);
    if (ends) break;
  }
  return words;
}

/// Whether a command is only cut short: by the end of a sentence, a file that is not here, a
/// group of commands that is named as such.
bool is_cut_short(const ParseTrouble& trouble, const std::vector<std::string>& words) {
  const auto says = [&](const char* part) {
    return trouble.message.find(part) != std::string::npos;
  };
  if (says("no such file") || says("does not exist")) return true;
  if (trouble.kind == "RequiredError" && says("subcommand")) {
    const std::set<std::string> groups{"collection", "job", "plan", "rig", "session"};
    return words.size() == 1 && groups.contains(words.front());
  }
  return trouble.kind == "RequiredError" || trouble.kind == "RequiresError" ||
         (trouble.kind == "ArgumentMismatch" && says("missing"));
}

/// Empty: understood, as far as it goes. A sentence may go on behind a command that is only
/// named, so words that are too many are cut off one by one.
std::string trouble_with(const std::string& command) {
  std::vector<std::string> words = words_of(command);
  while (!words.empty()) {
    const auto trouble = parse_trouble(words);
    if (!trouble || is_cut_short(*trouble, words)) return "";
    const bool too_many = trouble->message.find("not expected") != std::string::npos;
    if (!too_many || words.back().starts_with("-") || words.size() == 1) {
      return trouble->kind + ": " + trouble->message;
    }
    words.pop_back();
  }
  return "";
}

TEST(Advice, EveryCommandThatIsAdvisedIsUnderstood) {
  const std::vector<Advice> advice = all_advice();
  EXPECT_GT(advice.size(), 80U);
  for (const Advice& each : advice) {
    EXPECT_EQ(trouble_with(each.text), "") << each.from << ": " << each.text;
  }
}

TEST(Advice, AnOptionIsNamedWithItsCommand) {
  // "fit with --space dials" tells nobody which command has it.
  const std::regex option(R"((^|[ (])(--[a-z][a-z-]+))");
  for (const char* folder : {"calibration", "diagnosis", "report", "session", "studies"}) {
    for (const auto& each : std::filesystem::recursive_directory_iterator(kSource / folder)) {
      if (each.path().extension() != ".cpp") continue;
      for (const std::string& literal : literals_in(session::read_file(each.path().string()))) {
        std::smatch found;
        if (!std::regex_search(literal, found, option)) continue;
        const std::size_t command = literal.find("sixdial");  // or another of the programs
        EXPECT_LT(command, static_cast<std::size_t>(found.position(2)))
            << each.path().lexically_relative(kSource) << ": " << literal;
      }
    }
  }
}

TEST(Advice, WhatDoesNotExistIsFound) {
  EXPECT_NE(trouble_with("sixdial calibrate {session} --no-such-option"), "");
  EXPECT_NE(trouble_with("sixdial compare {session} --space angles"), "");
  EXPECT_NE(trouble_with("sixdial recalibrate"), "");
  EXPECT_EQ(trouble_with("sixdial compare {session} --space dials"), "");
  EXPECT_EQ(trouble_with("sixdial diagnose looks for the cause"), "");
}

}  // namespace
}  // namespace sixdial::cli
