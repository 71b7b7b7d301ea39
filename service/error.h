// Every error a client can see: one table of codes, one exception that carries its evidence,
// and one function that turns whatever was thrown into the `error` object of JSON-RPC 2.0.
#pragma once

#include <cstdint>
#include <exception>
#include <optional>
#include <span>
#include <stdexcept>
#include <string>
#include <string_view>

#include "report/documents/json.h"

namespace sixdial::service {

enum class ErrorCode : std::uint8_t {
  kParseError,
  kInvalidRequest,
  kUnknownMethod,
  kInvalidParams,
  kInternal,
  kLineTooLong,
  kNestingTooDeep,
  kTooManyClients,
  kTooManyRequests,
  kResultTooLarge,
  kShuttingDown,
  kNotFound,
  kAlreadyExists,
  kWrongState,
  kBadData,
  kDevice,
  kStorage,
  kFile,
  kCancelled,
  kJobFailed,
  kUnreachable,
};

/// Exit codes of the command line (spec 6).
enum class ExitCode : int {
  kOk = 0,
  kFailed = 1,
  kUsage = 2,
  kUnreachable = 3,
  kDevice = 4,
  kDataQuality = 5,
  kCancelled = 6,
  kInterrupted = 130,
};

/// One row of the published table.
struct ErrorKind {
  ErrorCode key;
  int number;             // `error.code` on the wire
  std::string_view code;  // `error.data.code`, stable
  bool retry;             // whether the same request may succeed later
  ExitCode exit_code;     // of the command line
  std::string_view meaning;
  std::string_view hint;            // used when the place that failed gives none
  std::string_view command_hint{};  // the same for the command line; empty: as `hint`
};
[[nodiscard]] std::span<const ErrorKind> error_table();
[[nodiscard]] const ErrorKind& error_kind(ErrorCode code);
/// By its number on the wire; null: a code outside the table.
[[nodiscard]] const ErrorKind* find_error_kind(int number);

/// `at` is what was at fault: any of "dial", "column", "file", "line", "param", "field", "set",
/// "point", "session", "job", "findings"; "missing": what kind of thing does not exist ("plan",
/// "session", "job").
class Error : public std::runtime_error {
 public:
  Error(
      ErrorCode code, const std::string& message, Json at = Json::object(),
      std::string hint = {})
      : std::runtime_error(message), code_(code), at_(std::move(at)), hint_(std::move(hint)) {}
  [[nodiscard]] ErrorCode code() const { return code_; }
  [[nodiscard]] const Json& at() const { return at_; }
  [[nodiscard]] const std::string& hint() const { return hint_; }

 private:
  ErrorCode code_;
  Json at_;
  std::string hint_;
};

/// An error that came back from a service, on the client's side.
class RemoteError : public std::runtime_error {
 public:
  explicit RemoteError(Json error)
      : std::runtime_error(error.value("message", "the service gave an error without words")),
        error_(std::move(error)) {}
  [[nodiscard]] const Json& error() const { return error_; }

 private:
  Json error_;
};

/// The one translator: {"code", "message", "data": {"code", "at", "retry", "hint"}}.
[[nodiscard]] Json to_error_object(const std::exception_ptr& thrown);
/// Exit code that belongs to an error object; kFailed for a code outside the table.
[[nodiscard]] ExitCode exit_code_of(const Json& error_object);

}  // namespace sixdial::service
