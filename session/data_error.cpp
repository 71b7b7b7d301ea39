#include "session/data_error.h"

#include <fmt/format.h>

#include <algorithm>
#include <limits>
#include <numeric>
#include <utility>

namespace sixdial::session {
namespace {

std::string message_of(
    const std::string& file, const std::vector<Finding>& findings, std::size_t total) {
  std::string text;
  const std::size_t shown = std::min(findings.size(), DataError::kMostShown);
  for (std::size_t i = 0; i < shown; ++i) {
    if (i > 0) text += '\n';
    text += to_string(file, findings[i]);
  }
  if (total > shown) text += fmt::format("\n{}: and {} more", file, total - shown);
  return text;
}

std::size_t edit_distance(const std::string& a, const std::string& b) {
  std::vector<std::size_t> row(b.size() + 1);
  std::iota(row.begin(), row.end(), std::size_t{0});
  for (std::size_t i = 0; i < a.size(); ++i) {
    std::size_t diagonal = row[0];
    row[0] = i + 1;
    for (std::size_t j = 0; j < b.size(); ++j) {
      const std::size_t changed = diagonal + (a[i] == b[j] ? 0U : 1U);
      diagonal = row[j + 1];
      row[j + 1] = std::min({changed, row[j] + 1, diagonal + 1});
    }
  }
  return row.back();
}

}  // namespace

DataError::DataError(const std::string& file_name, std::vector<Finding> all, std::size_t count)
    : std::runtime_error(message_of(file_name, all, count)),
      file(file_name),
      findings(std::move(all)),
      total(count) {
  if (findings.size() > kMostShown) findings.resize(kMostShown);
  if (findings.empty()) return;
  line = findings[0].line;
  column = findings[0].column;
  field = findings[0].field;
  problem = findings[0].what;
  hint = findings[0].hint;
}

DataError::DataError(const std::string& file_name, Finding finding)
    : DataError(file_name, std::vector<Finding>{std::move(finding)}, 1) {}

std::string to_string(const std::string& file, const Finding& finding) {
  std::string text = file;
  if (finding.line > 0) text += fmt::format(":{}", finding.line);
  if (finding.line > 0 && finding.column > 0) text += fmt::format(":{}", finding.column);
  text += ": ";
  if (!finding.field.empty()) text += finding.field + ": ";
  text += finding.what;
  if (!finding.hint.empty()) text += "; " + finding.hint;
  return text;
}

std::string nearest_word(const std::string& word, const std::vector<std::string>& candidates) {
  // A file may hold a megabyte where a key should be; its first characters tell enough.
  const std::string start = word.substr(0, 64);
  std::string best;
  std::size_t least = std::numeric_limits<std::size_t>::max();
  for (const std::string& candidate : candidates) {
    const std::size_t distance = edit_distance(start, candidate);
    if (distance < least) {
      least = distance;
      best = candidate;
    }
  }
  return best;
}

}  // namespace sixdial::session
