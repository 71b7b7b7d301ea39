#include "session/data_error.h"

#include <fmt/format.h>

#include <algorithm>
#include <limits>
#include <numeric>
#include <utility>

#include "session/nearest.h"

namespace sixdial::session {
namespace {

std::string message_of(
    const std::string& file, const std::vector<Mistake>& mistakes, std::size_t total) {
  std::string text;
  const std::size_t shown = std::min(mistakes.size(), DataError::kMostShown);
  for (std::size_t i = 0; i < shown; ++i) {
    if (i > 0) text += '\n';
    text += to_string(file, mistakes[i]);
  }
  if (total > shown) text += fmt::format("\n{}: and {} more", file, total - shown);
  return text;
}

}  // namespace

DataError::DataError(const std::string& file_name, std::vector<Mistake> all, std::size_t count)
    : std::runtime_error(message_of(file_name, all, count)),
      file(file_name),
      mistakes(std::move(all)),
      total(count) {
  if (mistakes.size() > kMostShown) mistakes.resize(kMostShown);
  if (mistakes.empty()) return;
  line = mistakes[0].line;
  column = mistakes[0].column;
  field = mistakes[0].field;
  problem = mistakes[0].what;
  hint = mistakes[0].hint;
}

DataError::DataError(const std::string& file_name, Mistake mistake)
    : DataError(file_name, std::vector<Mistake>{std::move(mistake)}, 1) {}

std::string to_string(const std::string& file, const Mistake& mistake) {
  std::string text = file;
  if (mistake.line > 0) text += fmt::format(":{}", mistake.line);
  if (mistake.line > 0 && mistake.column > 0) text += fmt::format(":{}", mistake.column);
  text += ": ";
  if (!mistake.field.empty()) text += mistake.field + ": ";
  text += mistake.what;
  if (!mistake.hint.empty()) text += "; " + mistake.hint;
  return text;
}

std::string nearest_word(const std::string& word, const std::vector<std::string>& candidates) {
  // A file may hold a megabyte where a key should be; its first characters tell enough.
  const std::string start = word.substr(0, 64);
  std::string best;
  int least = std::numeric_limits<int>::max();
  for (const std::string& candidate : candidates) {
    const int distance = edit_distance(start, candidate);
    if (distance < least) {
      least = distance;
      best = candidate;
    }
  }
  return best;
}

}  // namespace sixdial::session
