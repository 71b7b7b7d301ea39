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
    db::ResultRecord record = reader.load_result({call.params["result"].get<std::int64_t>()});
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
      "Use one of this session, or ask for it where the robot is the same: from_other_session, "
      "at "
      "the terminal --from-other-session.");
}

db::ResultRecord calibration_record(const Call& call) {
  return record_of(
      call, "calibration", "has no result yet", "Start a calibration: calibrate.start.");
}

db::ResultRecord diagnosis_record(const Call& call) {
  return record_of(
      call, "diagnosis", "has not been diagnosed yet", "Start a diagnosis: diagnose.start.");
}

db::ResultRecord extending_record(const Call& call) {
  Json params = Json::object();
  if (call.params.contains("diagnosis")) params["result"] = call.params["diagnosis"];
  for (const char* key : {"session", "from_other_session"}) {
    if (call.params.contains(key)) params[key] = call.params[key];
  }
  const db::ResultRecord record =
      diagnosis_record({call.service, params, call.caller, call.sink});
  if (record.kind == "diagnosis") return record;
  throw Error(
      ErrorCode::kBadData,
      fmt::format("result {} is a {}, not a diagnosis", record.id.value, record.kind),
      {{"param", "diagnosis"}});
}

std::optional<db::ResultRecord> companion_of(
    db::Store& reader, const db::ResultRecord& calibration, const char* kind) {
  std::vector<db::ResultRecord> all = reader.load_results(calibration.session, kind);
  std::erase_if(all, [&](const db::ResultRecord& each) {
    return each.data_sha256 != calibration.data_sha256;
  });
  if (all.empty()) return std::nullopt;
  return std::move(all.back());
}

}  // namespace sixdial::service
