// A diagnosis in sentences: what was found, where, how big, how sure, what to do, what it
// gains, what could not be judged.
#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "studies/diagnosis_result.h"

namespace sixdial::report {

/// A sentence, and the cause that it is about: its number in the result, if it is about one.
struct Line {
  std::string text{};
  std::optional<std::size_t> cause{};
};

struct Verdict {
  studies::VerdictKind kind = studies::VerdictKind::kNothing;
  std::string title{};
  std::string headline{};
  std::string gain{};  // empty: not computed
  std::vector<Line> found{};
  std::vector<Line> to_do{};
  std::vector<std::string> trust{};
  std::vector<std::string> not_judged{};
};

[[nodiscard]] Verdict verdict_in_words(const studies::DiagnosisResult& result);

[[nodiscard]] std::vector<std::string> texts_of(const std::vector<Line>& lines);

}  // namespace sixdial::report
