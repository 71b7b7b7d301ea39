#include "service/result_lookup.h"

#include <fmt/format.h>

#include <utility>
#include <vector>

namespace sixdial::service {
namespace {

db::ResultRecord record_of(
    const Call& call, const char* kind, const char* none_yet, const char* hint) {
  db::Store& reader = call.service.reader();
  if (call.params.contains("result")) {
    db::ResultRecord record =
        reader.load_result({call.params["result"].get<std::int64_t>()});
    if (call.params.contains("session") &&
        !param_or(call.params, "from_other_session", false)) {
      const auto name = call.params["session"].get<std::string>();
      check_session(record, reader.find_session(name), name);
    }
    return record;
  }
  if (!call.params.contains("session")) {
    throw Error(
        ErrorCode::kInvalidParams, "one of 'result' and 'session' is needed",
        {{"param", "result"}});
  }
  const auto name = call.params["session"].get<std::string>();
  std::vector<db::ResultRecord> all = reader.load_results(reader.find_session(name), kind);
  if (all.empty()) {
    throw Error(
        ErrorCode::kNotFound, fmt::format("session {} {}", name, none_yet), {{"session", name}},
        hint);
  }
  return std::move(all.back());
}

}  // namespace

void check_session(
    const db::ResultRecord& record, db::SessionId wanted, const std::string& name) {
  if (record.session == wanted) return;
  throw Error(
      ErrorCode::kBadData,
      fmt::format(
          "result {} is a {} of another session than {}", record.id.value, record.kind, name),
      {{"session", name}},
      "Use one of this session, or say from_other_session where the robot is the same.");
}

db::ResultRecord calibration_record(const Call& call) {
  return record_of(
      call, "calibration", "has no result yet", "Start a calibration: calibrate.start.");
}

db::ResultRecord diagnosis_record(const Call& call) {
  return record_of(
      call, "diagnosis", "has not been diagnosed yet", "Start a diagnosis: diagnose.start.");
}

}  // namespace sixdial::service
