// What is wrong with a file someone gave us: where it stands and what to do about it.
#pragma once

#include <cstddef>
#include <stdexcept>
#include <string>
#include <vector>

namespace sixdial::session {

/// One fault in a file. Line and column count from 1, the column in characters; 0: no one
/// place.
struct Mistake {
  int line = 0;
  int column = 0;
  std::string field{};  // name of the column or key; empty: none
  std::string what{};
  std::string hint{};  // what to do
};

/// A file cannot be used as it stands. what() names file, line, column, fault and remedy, one
/// line a mistake; the fields are those of the first mistake.
class DataError : public std::runtime_error {
 public:
  /// `mistakes` is not empty; at most kMostShown are kept, `total` counts all.
  DataError(const std::string& file, std::vector<Mistake> mistakes, std::size_t total);
  DataError(const std::string& file, Mistake mistake);

  static constexpr std::size_t kMostShown = 20;

  std::string file;
  int line = 0;
  int column = 0;
  std::string field;
  std::string problem;
  std::string hint;
  std::vector<Mistake> mistakes;
  std::size_t total = 0;
};

/// "session.csv:12:31: theta1_rad: 'abc' is not a number; write ...".
[[nodiscard]] std::string to_string(const std::string& file, const Mistake& mistake);

/// The candidate nearest to `word` by insertions, deletions and changes of a character; empty
/// if there are no candidates.
[[nodiscard]] std::string nearest_word(
    const std::string& word, const std::vector<std::string>& candidates);

}  // namespace sixdial::session
