// An effect is asked for by what its row says, never by its name: no file outside of
// simulation/effects/ has the name of one. (The true rig in mock_devices/ and tests have names
// of their own to hide and to expect.)
#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <map>
#include <set>
#include <sstream>
#include <string>
#include <vector>

#include "simulation/effect.h"
#include "tests/support/paths.h"

namespace sixdial {
namespace {

namespace fs = std::filesystem;

/// Words that are also names of effects, but mean something else there.
const std::map<std::string, std::set<std::string>> kOtherMeanings{
    {"report/words/budget_words.cpp", {"dial_curve"}},    // a source of uncertainty
    {"report/chart_json.cpp", {"step"}},                  // a line drawn in steps
    {"report/figures.cpp", {"step"}},                     // of an optimiser
    {"report/tables.cpp", {"step"}},                      // of an optimiser
    {"report/documents/calibration_json.cpp", {"step"}},  // of an optimiser
};

/// Names of effects that a text has as whole string literals.
std::set<std::string> names_in(const std::string& text) {
  std::set<std::string> result;
  for (const simulation::Effect* effect : simulation::all_effects()) {
    const std::string name(effect->cause);
    if (text.find('"' + name + '"') != std::string::npos) result.insert(name);
  }
  return result;
}

TEST(NamesOfEffects, AreInTheEffectsOwnFilesOnly) {
  const fs::path tree(test_paths::source_dir());
  int files = 0;
  for (const char* folder :
       {"geometry", "simulation", "session", "calibration", "diagnosis", "studies",
        "acquisition", "db", "report", "service", "cli", "apps", "bench"}) {
    for (const auto& entry : fs::recursive_directory_iterator(tree / folder)) {
      const fs::path& path = entry.path();
      if (path.extension() != ".cpp" && path.extension() != ".h") continue;
      const std::string name = fs::relative(path, tree).generic_string();
      if (name.starts_with("simulation/effects/")) continue;
      ++files;
      std::ifstream in(path);
      std::stringstream text;
      for (std::string line; std::getline(in, line);) {
        const std::size_t comment = line.find("//");
        text << line.substr(0, comment) << "\n";
      }
      std::set<std::string> found = names_in(text.str());
      if (const auto other = kOtherMeanings.find(name); other != kOtherMeanings.end()) {
        for (const std::string& word : other->second) found.erase(word);
      }
      for (const std::string& word : found) {
        ADD_FAILURE() << name << " asks for the effect \"" << word << "\" by its name";
      }
    }
  }
  EXPECT_GT(files, 200);
}

TEST(NamesOfEffects, AreFoundInAText) {
  EXPECT_EQ(
      names_in(R"(if (cause == "joint_backlash" || cause == "step"))"),
      (std::set<std::string>{"joint_backlash", "step"}));
  EXPECT_TRUE(names_in("joint_backlash stands in words").empty());
}

}  // namespace
}  // namespace sixdial
