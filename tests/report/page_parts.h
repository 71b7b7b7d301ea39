// A report's page and tables, taken apart again by other means than made them.
#pragma once

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <nlohmann/json.hpp>
#include <stdexcept>
#include <string>
#include <vector>

#include "report/csv_report.h"
#include "run_program.h"
#include "tests/support/paths.h"

namespace sixdial::report {

/// The page's tables by id as the independent reader sees them; fails the test on a fault.
inline nlohmann::json tables_of(const std::string& page) {
  const TemporaryFolder folder;
  const Ran ran = run_program(fmt::format(
      "python3 {}/tests/report/check_html.py {}", test_paths::source_dir(),
      folder.write("page.html", page)));
  EXPECT_EQ(ran.exit_code, 0) << "faults in the page (or no python3): " << ran.err;
  return nlohmann::json::parse(ran.out, nullptr, false);
}

/// `text` without what stands in <script> elements.
inline std::string without_scripts(const std::string& page) {
  std::string out;
  std::size_t at = 0;
  while (at < page.size()) {
    const std::size_t open = page.find("<script", at);
    out += page.substr(at, open == std::string::npos ? open : open - at);
    if (open == std::string::npos) break;
    at = page.find("</script>", open);
    if (at == std::string::npos) break;
  }
  return out;
}

inline std::vector<std::vector<std::string>> read_csv(const std::string& text) {
  std::vector<std::vector<std::string>> rows{{""}};
  bool quoted = false;
  for (std::size_t i = 0; i < text.size(); ++i) {
    const char c = text[i];
    if (quoted && c == '"' && i + 1 < text.size() && text[i + 1] == '"') {
      rows.back().back() += '"';
      ++i;
    } else if (c == '"') {
      quoted = !quoted;
    } else if (!quoted && c == ',') {
      rows.back().emplace_back();
    } else if (!quoted && c == '\n') {
      rows.push_back({""});
    } else {
      rows.back().back() += c;
    }
  }
  rows.pop_back();
  return rows;
}

inline const std::string& csv_file(const std::vector<CsvFile>& files, const std::string& name) {
  const auto found = std::find_if(
      files.begin(), files.end(), [&](const CsvFile& f) { return f.name == name; });
  if (found == files.end()) throw std::runtime_error("no " + name);
  return found->text;
}

}  // namespace sixdial::report
