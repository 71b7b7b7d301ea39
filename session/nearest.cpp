#include "session/nearest.h"

#include <algorithm>
#include <numeric>
#include <vector>

namespace sixdial::session {

int edit_distance(std::string_view a, std::string_view b) {
  std::vector<int> row(b.size() + 1);
  std::iota(row.begin(), row.end(), 0);
  for (std::size_t i = 0; i < a.size(); ++i) {
    int diagonal = row[0];
    ++row[0];
    for (std::size_t j = 0; j < b.size(); ++j) {
      const int replaced = diagonal + (a[i] == b[j] ? 0 : 1);
      diagonal = row[j + 1];
      row[j + 1] = std::min({replaced, row[j] + 1, row[j + 1] + 1});
    }
  }
  return row.back();
}

std::optional<std::string_view> nearest_name(
    std::string_view word, std::span<const std::string_view> known) {
  constexpr std::size_t kLongestWord = 64;  // the distance is quadratic; names are short
  if (known.empty() || word.size() > kLongestWord) return std::nullopt;
  const auto best = std::ranges::min_element(
      known, {}, [&](std::string_view name) { return edit_distance(word, name); });
  if (2 * edit_distance(word, *best) > static_cast<int>(std::max(word.size(), best->size()))) {
    return std::nullopt;
  }
  return *best;
}

}  // namespace sixdial::session
