// Sessions: create, list, show, import, export.
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <filesystem>
#include <functional>
#include <map>
#include <tuple>

#include "report/documents/warnings_document.h"
#include "service/methods/shared_params.h"
#include "service/patient_files.h"
#include "service/sample_json.h"
#include "service/service.h"
#include "service/session_choices.h"
#include "service/session_name.h"
#include "service/store_json.h"
#include "session/bundle.h"
#include "session/plan.h"
#include "session/rig_file.h"
#include "session/trials.h"
#include "studies/plausibility.h"

namespace sixdial::service {
namespace {

std::string session_name(const Call& call, std::string_view key = "session") {
  return call.params.at(key).get<std::string>();
}

Json info_json(Service& service, db::SessionId id) {
  Json json = to_json(service.reader().session_info(id));
  json["rig_name"] = service.reader().load_rig(id).name;
  return json;
}

session::Session loaded(const Call& call) {
  db::Store& reader = call.service.reader();
  return reader.load_session(reader.find_session(session_name(call)));
}

Json create(const Call& call) {
  const std::string name = session_name(call, "name");
  check_session_name(name);
  const db::SessionId id = call.service.store().create_session(
      name, call.params.at("rig_toml").get<std::string>(), to_operator(call.caller));
  call.service.events().publish("session", {{"type", "created"}, {"session", name}});
  return info_json(call.service, id);
}

Json list(const Call& call) {
  const auto limit = param_or<std::int64_t>(call.params, "limit", 50);
  const auto offset = param_or<std::int64_t>(call.params, "offset", 0);
  std::vector<db::SessionInfo> all = call.service.reader().list_sessions();
  std::ranges::sort(all, std::greater{}, [](const auto& info) { return info.id.value; });
  Json rows = Json::array();
  for (auto i = offset; i < std::min(offset + limit, std::ssize(all)); ++i) {
    rows.push_back(info_json(call.service, all[static_cast<std::size_t>(i)].id));
  }
  return {{"sessions", std::move(rows)}, {"total", all.size()}};
}

/// The newest of one kind of action on the session, the newest last; `detail` under that name.
Json actions_of(
    db::Store& reader, db::SessionId id, std::string_view kind, const char* detail) {
  constexpr std::size_t kMost = 20;
  std::vector<Json> rows;
  for (const db::ActionRecord& action : reader.list_actions()) {
    if (action.session != id || action.action != kind) continue;
    rows.push_back(
        {{"time_utc", action.time_utc},
         {"operator", action.who.name},
         {detail, action.detail}});
  }
  if (rows.size() > kMost) rows.erase(rows.begin(), rows.end() - kMost);
  return rows;
}

Json show(const Call& call) {
  db::Store& reader = call.service.reader();
  const db::SessionId id = reader.find_session(session_name(call));
  Json answer = info_json(call.service, id);
  answer["collections"] = actions_of(reader, id, "collect.end", "ended_because");
  answer["clock_steps"] = actions_of(reader, id, kClockStep, "what");
  const session::Session session = reader.load_session(id);
  answer["readings_within_ms"] = readings_within_json(session);
  answer["warnings"] = report::warnings_json(studies::plausible(session).warnings);
  const auto limit = param_or<std::int64_t>(call.params, "limit", 0);
  const auto offset = param_or<std::int64_t>(call.params, "offset", 0);
  if (limit > 0) {
    Json samples = Json::array();
    for (auto i = offset; i < std::min(offset + limit, std::ssize(session.samples)); ++i) {
      samples.push_back(sample_json(session.rig, session.samples[static_cast<std::size_t>(i)]));
    }
    answer["page"] = std::move(samples);
  }
  return answer;
}

Json import_bundle(const Call& call) {
  const std::filesystem::path path = params::absolute_path(call);
  const auto name = param_or<std::string>(call.params, "name", "");
  if (!name.empty()) check_session_name(name);
  const session::ReadOptions options{
      .skip_bad_rows = param_or(call.params, "skip_bad_rows", false), .name = name};
  const session::Session read = with_patience(
      call.service, path, [path, options] { return session::read_bundle(path, options); });
  check_session_name(read.name);
  const db::SessionId id = call.service.store().import_session(read, to_operator(call.caller));
  Json answer = info_json(call.service, id);
  call.service.events().publish("session", {{"type", "imported"}, {"session", read.name}});
  answer["warnings"] = report::warnings_json(studies::plausible(read).warnings);
  answer["rejected"] = Json::array();
  constexpr std::size_t kMostShown = 100;
  for (const session::RejectedRow& row : read.rejected) {
    if (answer["rejected"].size() == kMostShown) break;
    answer["rejected"].push_back({{"line", row.line}, {"reason", row.reason}});
  }
  return answer;
}

Json export_bundle(const Call& call) {
  const std::filesystem::path path = params::absolute_path(call);
  session::Session session = loaded(call);
  const std::size_t samples = session.samples.size();
  run_patiently(call.service, path, [path, session = std::move(session)] {
    session::write_bundle(session, path);
  });
  return {
      {"path", path.string()}, {"files", {"session.csv", "rig.toml"}}, {"samples", samples}};
}

Json planned(const Call& call) {
  const session::Session session = loaded(call);
  const auto plan =
      call.service.reader().load_plan(call.service.reader().find_session(session_name(call)));
  const std::vector<session::PlanPoint> none;
  const std::vector<session::PlanPoint>& points = plan ? plan->points : none;
  std::map<std::tuple<std::string, int, int>, const session::Sample*> measured;
  for (const session::Sample& sample : session.samples) {
    measured[{sample.set, sample.point, sample.repeat}] = &sample;
  }
  const auto limit = param_or<std::int64_t>(call.params, "limit", 200);
  const auto offset = param_or<std::int64_t>(call.params, "offset", 0);
  Json rows = Json::array();
  for (auto i = offset; i < std::min(offset + limit, std::ssize(points)); ++i) {
    const session::PlanPoint& point = points[static_cast<std::size_t>(i)];
    Json row{
        {"set", point.set},
        {"point", point.point},
        {"repeat", point.repeat},
        {"target_mm", {point.target_mm.x(), point.target_mm.y()}},
        {"state", "open"}};
    const auto found = measured.find({point.set, point.point, point.repeat});
    if (found != measured.end()) {
      std::string doubt = doubt_of(session.rig, *found->second);
      if (doubt.empty()) {
        doubt = call.service.collection().unusual(
            session.name, {point.set, point.point, point.repeat});
      }
      row["state"] = doubt.empty() ? "done" : "suspect";
      if (!doubt.empty()) row["why"] = doubt;
    }
    rows.push_back(std::move(row));
  }
  return {{"session", session.name}, {"total", points.size()}, {"points", std::move(rows)}};
}

/// The row stays in the store as withdrawn; what it had replaced counts again.
Json undo(const Call& call) {
  Service& service = call.service;
  const Json collecting = service.collection().status();
  if (service.collection().active() && collecting["session"] == call.params["session"]) {
    throw Error(
        ErrorCode::kWrongState, "the session is being collected",
        {{"session", collecting["session"]}}, "collect.retake measures the last point again.");
  }
  const db::SessionId id = service.reader().find_session(session_name(call));
  const auto undone = service.store().undo_last(
      id, param_or<std::string>(call.params, "reason", "undo"), to_operator(call.caller));
  Json answer = info_json(service, id);
  answer["undone"] = undone ? Json(undone->value) : Json(nullptr);
  if (undone) {
    service.collection().samples_changed(session_name(call));
    service.events().publish(
        "session", {{"type", "undone"},
                    {"session", session_name(call)},
                    {"sample", undone->value},
                    {"samples", answer["samples"]},
                    {"operator", call.caller.operator_name}});
  }
  return answer;
}

Json choices(const Call& call) { return session_choices(call.service, session_name(call)); }

using params::kSession;
constexpr Param kPage{
    .name = "limit", .type = ParamType::kInteger, .doc = "so many", .min = 0, .max = 50};
constexpr Param kOffset{
    .name = "offset", .type = ParamType::kInteger, .doc = "from here on, default 0", .min = 0};
constexpr std::array kCreateParams{
    Param{.name = "name", .required = true, .doc = "of the new session"},
    Param{.name = "rig_toml", .required = true, .doc = "text of the rig file"}};
constexpr std::array kListParams{kPage, kOffset};
constexpr std::array kPlannedParams{
    kSession,
    Param{
        .name = "limit",
        .type = ParamType::kInteger,
        .doc = "so many; default 200",
        .min = 1,
        .max = 200},
    kOffset};
constexpr std::array kShowParams{kSession, kPage, kOffset};
constexpr std::array kImportParams{
    Param{
        .name = "path",
        .required = true,
        .doc =
            "absolute path of a folder with session.csv and rig.toml, as the service sees it"},
    Param{.name = "name", .doc = "of the session; default: the folder's"},
    Param{
        .name = "skip_bad_rows",
        .type = ParamType::kBoolean,
        .doc = "leave bad rows out and list them, instead of refusing the bundle"}};
constexpr std::array kExportParams{
    kSession, Param{.name = "path", .required = true, .doc = "absolute path of the folder"}};
constexpr std::array kOnlySession{kSession};
constexpr std::array kUndoParams{kSession, Param{.name = "reason", .doc = "kept with the row"}};
constexpr std::string_view kInfo =
    "name, created_utc, operator, rig_name, rig_hash, samples, samples_by_set, plan_points, "
    "rejected_rows";

constexpr std::array kMethods{
    RpcMethod{
        .name = "session.create",
        .summary = "A new, empty session with its rig file.",
        .params = kCreateParams,
        .result = kInfo,
        .example =
            R"({"name": "monday", "rig_toml": "name = \"a tracker\"\n[robot]\nmodel = \"five_bar\"\nworking_mode = \"++\"\nassembly = 1\nl11_mm = 60.0\nl12_mm = 60.0\nl21_mm = 60.0\nl22_mm = 60.0\nd_mm = 90.0\nx0_mm = 0.0\ny0_mm = 0.0\nalpha_deg = 0.0\ntheta1_offset_deg = 0.0\ntheta2_offset_deg = 0.0\n[cuboid]\nside_mm = 80.0\nmount = \"distal2\"\nreference_pose_mm = [28.0, 48.0]\n"})",
        .run = create},
    RpcMethod{
        .name = "session.list",
        .summary = "The sessions in the store, newest first.",
        .params = kListParams,
        .result = "sessions [as session.show], total",
        .example = R"({"limit": 20})",
        .run = list},
    RpcMethod{
        .name = "session.plan",
        .summary = "The session's planned points and which of them are measured, by page.",
        .params = kPlannedParams,
        .result = "session, total, points [{set, point, repeat, target_mm, state (open, done, "
                  "suspect: a dial was doubtful, there is no position, or the residual is "
                  "unusual), why}]",
        .example = R"({"session": "demo", "limit": 200, "offset": 0})",
        .run = planned},
    RpcMethod{
        .name = "session.show",
        .summary = "One session, with a page of its samples if `limit` says so.",
        .params = kShowParams,
        .result =
            "name, created_utc, operator, rig_name, rig_hash, samples, samples_by_set, "
            "plan_points, rejected_rows, collections [{time_utc, operator, "
            "ended_because}], clock_steps [{time_utc, operator, what}], readings_within_ms "
            "{median, max}: between the first and the last dial's answer of a sample, null "
            "where no times are known, warnings [{code, severity, message, where, place, "
            "parts}], "
            "page [samples]",
        .example = R"({"session": "demo", "offset": 0, "limit": 5})",
        .runs_on = RunsOn::kReading,
        .run = show},
    RpcMethod{
        .name = "session.import",
        .summary = "Takes a session bundle into the store, all or nothing.",
        .params = kImportParams,
        .result = "as session.show, and rejected [{line, reason}]",
        .example = R"({"path": "/srv/rig/bundle", "name": "imported"})",
        .runs_on = RunsOn::kFiles,
        .run = import_bundle},
    RpcMethod{
        .name = "session.export",
        .summary = "Writes a session as a bundle; an imported one gets its own bytes back.",
        .params = kExportParams,
        .result = "path, files, samples",
        .example = R"({"session": "demo", "path": "/srv/rig/exported"})",
        .runs_on = RunsOn::kFiles,
        .run = export_bundle},
    RpcMethod{
        .name = "session.undo",
        .summary =
            "Withdraws the newest sample; its row stays in the store, and its point is open "
            "again.",
        .params = kUndoParams,
        .result = "as session.show, and undone: the sample's number, null if there was none",
        .example = R"({"session": "demo", "reason": "the dial slipped"})",
        .run = undo},
    RpcMethod{
        .name = "session.choices",
        .summary = "What can be done with a session now, and what each of the rest waits for.",
        .params = kOnlySession,
        .result =
            "session, choices {start, undo, calibrate, diagnose, report: null, or why it "
            "cannot be done now}, report_of (calibration, diagnosis or null), warnings [{code, "
            "severity, message, where, place, parts}]: what speaks against the session",
        .example = R"({"session": "demo"})",
        .runs_on = RunsOn::kReading,
        .run = choices},
};

}  // namespace

std::span<const RpcMethod> session_methods() { return kMethods; }

}  // namespace sixdial::service
