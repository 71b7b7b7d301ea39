#include "service/error.h"

#include <algorithm>
#include <array>
#include <system_error>

#include "db/store_error.h"
#include "session/data_error.h"
#include "studies/error.h"

namespace sixdial::service {
namespace {

constexpr std::array kTable{
    ErrorKind{
        ErrorCode::kParseError, -32700, "parse_error", false, ExitCode::kFailed,
        "The line is not JSON.", "Send one JSON object a line, in UTF-8."},
    ErrorKind{
        ErrorCode::kInvalidRequest, -32600, "invalid_request", false, ExitCode::kFailed,
        "The line is JSON but no JSON-RPC 2.0 request.",
        R"(A request looks like {"jsonrpc":"2.0","id":1,"method":"hello"}.)"},
    ErrorKind{
        ErrorCode::kUnknownMethod, -32601, "unknown_method", false, ExitCode::kUsage,
        "There is no method of this name.", "rpc.discover lists all methods."},
    ErrorKind{
        ErrorCode::kInvalidParams, -32602, "invalid_params", false, ExitCode::kUsage,
        "A parameter is missing, unknown, of the wrong type or out of range.",
        "rpc.discover gives the schema and an example."},
    ErrorKind{
        ErrorCode::kInternal, -32603, "internal", false, ExitCode::kFailed,
        "A fault in the service itself.", "Keep the service's log and report it."},
    ErrorKind{
        ErrorCode::kLineTooLong, -32001, "line_too_long", false, ExitCode::kFailed,
        "The request line is longer than the limit that hello gives.",
        "Hand large data over as a file."},
    ErrorKind{
        ErrorCode::kNestingTooDeep, -32002, "nesting_too_deep", false, ExitCode::kFailed,
        "Arrays and objects are nested deeper than the limit that hello gives.",
        "No method needs more than a few levels."},
    ErrorKind{
        ErrorCode::kTooManyClients, -32003, "too_many_clients", true, ExitCode::kUnreachable,
        "All places for clients are taken.", "Close a connection, or try again later."},
    ErrorKind{
        ErrorCode::kTooManyRequests, -32004, "too_many_requests", true, ExitCode::kFailed,
        "This connection has too many requests under way.",
        "Wait for answers before asking more."},
    ErrorKind{
        ErrorCode::kResultTooLarge, -32005, "result_too_large", false, ExitCode::kFailed,
        "The answer does not fit into one line.", "Ask by page, or to a file."},
    ErrorKind{
        ErrorCode::kShuttingDown, -32006, "shutting_down", true, ExitCode::kUnreachable,
        "The service is going down.", "Try again when it is up."},
    ErrorKind{
        ErrorCode::kNotFound, -32010, "not_found", false, ExitCode::kFailed,
        "No session, job, result or point of this name.",
        "The list methods show what there is.",
        "sixdial session list and sixdial job list show what there is."},
    ErrorKind{
        ErrorCode::kAlreadyExists, -32011, "already_exists", false, ExitCode::kFailed,
        "The name is taken.", "Choose another name; nothing is overwritten."},
    ErrorKind{
        ErrorCode::kWrongState, -32012, "wrong_state", true, ExitCode::kFailed,
        "Not possible in the present state.", "collect.status and job.status tell the state."},
    ErrorKind{
        ErrorCode::kBadData, -32013, "bad_data", false, ExitCode::kDataQuality,
        "The data or the rig file cannot be used as they are.",
        "Mend the place that `at` names."},
    ErrorKind{
        ErrorCode::kDevice, -32014, "device", true, ExitCode::kDevice,
        "A dial or the robot does not answer as it should.",
        "Check cable, power and the connection in the rig file."},
    ErrorKind{
        ErrorCode::kStorage, -32015, "storage", true, ExitCode::kFailed,
        "The database refuses.", "Check disk space and rights; what was acknowledged is kept."},
    ErrorKind{
        ErrorCode::kFile, -32016, "file", false, ExitCode::kFailed,
        "A file cannot be read or written.", "Check path and rights, as the service's user."},
    ErrorKind{
        ErrorCode::kCancelled, -32017, "cancelled", true, ExitCode::kCancelled,
        "The job was cancelled.", "Start it again when wanted."},
    ErrorKind{
        ErrorCode::kJobFailed, -32018, "job_failed", false, ExitCode::kFailed,
        "The job ended without a result.", "job.status has the reason."},
    ErrorKind{
        ErrorCode::kUnreachable, -32019, "unreachable", true, ExitCode::kUnreachable,
        "No service answers on the socket.",
        "Start it: sixdiald & (or systemctl --user start sixdiald.socket). sixdial doctor "
        "finds "
        "what is wrong. --socket names another place."},
};

ErrorCode code_of(studies::StudyErrorCode code) {
  switch (code) {
    case studies::StudyErrorCode::kInvalidParams:
      return ErrorCode::kInvalidParams;
    case studies::StudyErrorCode::kBadData:
      return ErrorCode::kBadData;
    case studies::StudyErrorCode::kFile:
      return ErrorCode::kFile;
    case studies::StudyErrorCode::kCancelled:
      return ErrorCode::kCancelled;
  }
  return ErrorCode::kInternal;
}

ErrorCode code_of(db::StoreTrouble trouble) {
  switch (trouble) {
    case db::StoreTrouble::kNotFound:
      return ErrorCode::kNotFound;
    case db::StoreTrouble::kNameTaken:
    case db::StoreTrouble::kAlreadyThere:
      return ErrorCode::kAlreadyExists;
    case db::StoreTrouble::kRefused:
      return ErrorCode::kBadData;
    case db::StoreTrouble::kLocked:
      return ErrorCode::kWrongState;
    default:
      return ErrorCode::kStorage;
  }
}

Json object_of(
    const ErrorKind& kind, const std::string& message, const Json& at, std::string_view hint) {
  return {
      {"code", kind.number},
      {"message", message},
      {"data",
       {{"code", kind.code},
        {"at", at},
        {"retry", kind.retry},
        {"hint", hint.empty() ? kind.hint : hint}}}};
}

}  // namespace

std::span<const ErrorKind> error_table() { return kTable; }

const ErrorKind& error_kind(ErrorCode code) {
  return *std::ranges::find(kTable, code, &ErrorKind::key);
}

const ErrorKind* find_error_kind(int number) {
  const auto* kind = std::ranges::find(kTable, number, &ErrorKind::number);
  return kind == kTable.end() ? nullptr : kind;
}

Json to_error_object(const std::exception_ptr& thrown) {
  try {
    std::rethrow_exception(thrown);
  } catch (const Error& error) {
    return object_of(error_kind(error.code()), error.what(), error.at(), error.hint());
  } catch (const studies::StudyError& error) {
    Json at = Json::object();
    for (const auto& field : error.at()) {
      std::visit([&](const auto& value) { at[field.first] = value; }, field.second);
    }
    return object_of(error_kind(code_of(error.code())), error.what(), at, error.hint());
  } catch (const RemoteError& error) {
    return error.error();
  } catch (const session::DataError& error) {
    Json at{{"file", error.file}};
    if (error.line > 0) at["line"] = error.line;
    if (error.column > 0) at["column"] = error.column;
    if (!error.field.empty()) at["field"] = error.field;
    if (error.total > 1) at["findings"] = error.total;
    return object_of(error_kind(ErrorCode::kBadData), error.what(), at, error.hint);
  } catch (const db::StoreError& error) {
    Json at{{"file", error.path}};
    if (!error.missing.empty()) at["missing"] = error.missing;
    return object_of(error_kind(code_of(error.trouble)), error.problem, at, error.hint);
  } catch (const std::system_error& error) {
    return object_of(error_kind(ErrorCode::kFile), error.what(), Json::object(), {});
  } catch (const std::exception& error) {
    return object_of(error_kind(ErrorCode::kInternal), error.what(), Json::object(), {});
  } catch (...) {
    return object_of(
        error_kind(ErrorCode::kInternal), "something that is no exception was thrown",
        Json::object(), {});
  }
}

ExitCode exit_code_of(const Json& error_object) {
  const ErrorKind* kind = find_error_kind(error_object.value("code", 0));
  return kind == nullptr ? ExitCode::kFailed : kind->exit_code;
}

}  // namespace sixdial::service
