// What a study refuses, and why: the data, or what was asked of them. service/error.h turns it
// into the error object that clients see.
#pragma once

#include <map>
#include <stdexcept>
#include <string>
#include <utility>
#include <variant>
#include <vector>

namespace sixdial::studies {

enum class StudyErrorCode {
  kInvalidParams,  // a choice that does not exist or contradicts another
  kBadData,        // the session or a result cannot be used for this
  kFile,           // a file cannot be written
  kCancelled,
};

/// What was at fault, by name: "session", "param", "file", "target_mm".
using Evidence = std::map<std::string, std::variant<std::string, std::vector<double>>>;

/// what() says what is wrong; `hint` what to do about it, empty where nothing better than the
/// code's own hint is known.
class StudyError : public std::runtime_error {
 public:
  StudyError(
      StudyErrorCode code, const std::string& message, Evidence at = {}, std::string hint = {})
      : std::runtime_error(message), code_(code), at_(std::move(at)), hint_(std::move(hint)) {}
  [[nodiscard]] StudyErrorCode code() const { return code_; }
  [[nodiscard]] const Evidence& at() const { return at_; }
  [[nodiscard]] const std::string& hint() const { return hint_; }

 private:
  StudyErrorCode code_;
  Evidence at_;
  std::string hint_;
};

}  // namespace sixdial::studies
