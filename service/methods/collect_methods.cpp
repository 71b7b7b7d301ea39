// Collecting a session on the rig: start, follow, command.
#include <fmt/format.h>

#include <array>
#include <cmath>
#include <string>
#include <vector>

#include "geometry/units.h"
#include "report/documents/plan_json.h"
#include "service/methods/shared_params.h"
#include "service/service.h"
#include "session/plan.h"
#include "session/sample_layout.h"

namespace sixdial::service {
namespace {

Json start(const Call& call) {
  CollectRequest request;
  request.session = call.params.at("session").get<std::string>();
  request.caller = call.caller;
  const auto plan_csv = param_or<std::string>(call.params, "plan_csv", "");
  if (!plan_csv.empty()) {
    db::Store& reader = call.service.reader();
    request.plan = session::parse_plan(
        plan_csv, "plan", reader.load_rig(reader.find_session(request.session)));
  }
  acquisition::CollectorSettings& settings = request.settings;
  settings.settle_spread_mm = param_or(call.params, "settle_spread_mm", 0.0);
  settings.settle_timeout = std::chrono::milliseconds(param_or<std::int64_t>(
      call.params, "settle_timeout_ms", settings.settle_timeout.count()));
  if (param_or<std::string>(call.params, "on_dial_fault", "store") == "pause") {
    settings.on_dial_fault = acquisition::OnDialFault::kPause;
  }
  settings.halt_on_lost_contact =
      param_or<std::string>(call.params, "on_lost_contact", "halt") == "halt";
  request.first_pass = param_or(call.params, "first_pass", false);
  if (call.params.contains("speed_percent")) {
    request.speed_percent = call.params["speed_percent"].get<int>();
  }
  if (param_or<std::string>(call.params, "on_mode_change", "pause") == "go") {
    settings.on_branch_change = acquisition::OnBranchChange::kGo;
  }
  if (const double limit_mm = param_or(call.params, "stop_below_mm", 0.0); limit_mm > 0.0) {
    request.stop_below_mm = limit_mm;
  }
  return call.service.collection().start(std::move(request));
}

Json plan_next(const Call& call) {
  db::Store& reader = call.service.reader();
  const session::Session session =
      reader.load_session(reader.find_session(call.params.at("session").get<std::string>()));
  studies::NextPlanRequest request;
  request.points = param_or(call.params, "points", request.points);
  request.criterion =
      *calibration::criterion_from(param_or<std::string>(call.params, "criterion", "I"));
  for (const auto& mode : param_or<std::vector<std::string>>(call.params, "modes", {})) {
    request.modes.push_back(*geometry::working_mode_from(mode));
  }
  return report::plan_answer(studies::next_plan(session, request), session.rig);
}

Json plan_separate(const Call& call) {
  db::Store& reader = call.service.reader();
  const session::Session session =
      reader.load_session(reader.find_session(call.params.at("session").get<std::string>()));
  studies::SeparationRequest request;
  request.points = param_or(call.params, "points", request.points);
  for (const auto& mode : param_or<std::vector<std::string>>(call.params, "modes", {})) {
    request.modes.push_back(*geometry::working_mode_from(mode));
  }
  return report::plan_answer(studies::separation_plan(session, request), session.rig);
}

Json status(const Call& call) { return call.service.collection().status(); }

Wait wait(const Call& call) {
  Collection& collection = call.service.collection();
  return {
      .ready = [&collection] { return !collection.active(); },
      .answer = [&collection] { return collection.status(); },
      .timeout = std::chrono::milliseconds(
          static_cast<std::int64_t>(1000.0 * param_or(call.params, "timeout_s", 60.0)))};
}

template <void (Collection::*Command)()>
Json command(const Call& call) {
  (call.service.collection().*Command)();
  return call.service.collection().status();
}

/// Joint values by their columns, as "joints" or, of a five-bar, on their own; empty: none.
std::optional<Eigen::VectorXd> joints_told(const Call& call) {
  Json told = param_or(call.params, "joints", Json::object());
  for (const char* name : {"theta1_rad", "theta2_rad"}) {
    if (call.params.contains(name)) told[name] = call.params[name];
  }
  if (told.empty()) return std::nullopt;
  db::Store& reader = call.service.reader();
  const auto session = call.service.collection().status()["session"].get<std::string>();
  const session::SampleLayout layout =
      session::layout_of(reader.load_rig(reader.find_session(session)));
  Eigen::VectorXd q(static_cast<Eigen::Index>(layout.joints.size()));
  for (std::size_t i = 0; i < layout.joints.size(); ++i) {
    const std::string name = layout.joints[i].column();
    if (!told.contains(name) || !told[name].is_number()) {
      throw Error(
          ErrorCode::kInvalidParams, fmt::format("{} is missing", name), {{"param", name}},
          "Give every joint, or none: then the values asked for count.");
    }
    q[static_cast<Eigen::Index>(i)] = told[name].get<double>();
    told.erase(name);
  }
  if (!told.empty()) {
    throw Error(
        ErrorCode::kInvalidParams, fmt::format("the robot has no joint {}", told.begin().key()),
        {{"param", told.begin().key()}}, "collect.status names the joints: move_to.");
  }
  return q;
}

/// A person's figures far from what was asked for are asked back once: degrees given as
/// radians, a slip of the pen.
void check_near(const Call& call, const Eigen::VectorXd& told) {
  constexpr double kFar_rad = 0.2;
  constexpr double kFar_mm = 20.0;
  if (param_or(call.params, "confirm", false)) return;
  const Json asked = call.service.collection().status()["move_to"];
  if (!asked.is_array() || std::ssize(asked) != told.size()) return;
  for (std::size_t i = 0; i < asked.size(); ++i) {
    const auto joint = asked[i]["joint"].get<std::string>();
    const auto unit = asked[i]["unit"].get<std::string>();
    const double wanted = asked[i]["value"].get<double>();
    const double value = told[static_cast<Eigen::Index>(i)];
    const bool turns = unit == "rad";
    if (std::abs(value - wanted) <= (turns ? kFar_rad : kFar_mm)) continue;
    const bool degrees = turns && std::abs(value * geometry::kRadPerDeg - wanted) <= kFar_rad;
    const double per = turns ? geometry::kDegPerRad : 1.0;
    throw Error(
        ErrorCode::kInvalidParams,
        fmt::format(
            "{} is told to be at {:.6g} {} ({:.4g} {}), where {:.4g} {} were asked for", joint,
            value, unit, value * per, turns ? "deg" : unit, wanted * per, turns ? "deg" : unit),
        {{"param", joint + '_' + unit}},
        degrees ? fmt::format(
                      "{:.6g} looks like degrees: this parameter is in radians. If it is no "
                      "slip, say it again with confirm (--confirm).",
                      value)
                : "If the robot really stands there, say it again with confirm (--confirm).");
  }
}

Json moved(const Call& call) {
  acquisition::ManualAnswer answer;
  answer.done = param_or(call.params, "reached", true);
  answer.q = joints_told(call);
  if (answer.q && answer.done) check_near(call, *answer.q);
  if (call.params.contains("temperature_c")) {
    answer.temperature_c = call.params["temperature_c"].get<double>();
  }
  call.service.collection().moved(std::move(answer));
  return call.service.collection().status();
}

constexpr std::array<std::string_view, 2> kOnFault{"store", "pause"};
constexpr std::array<std::string_view, 2> kOnModeChange{"pause", "go"};
constexpr std::array<std::string_view, 2> kOnLostContact{"halt", "go"};
constexpr std::array kStartParams{
    params::kSession,
    Param{
        .name = "plan_csv",
        .doc =
            "text of a plan file; left out: the session's plan, from the next open point on"},
    Param{
        .name = "settle_spread_mm",
        .type = ParamType::kNumber,
        .doc = "readings within this are settled; 0: six times the dial's repeatability",
        .min = 0,
        .max = 10},
    Param{
        .name = "settle_timeout_ms",
        .type = ParamType::kInteger,
        .doc = "longer than this, and not before three readings, is stored as unsettled; "
               "default 10000",
        .min = 1,
        .max = 3'600'000},
    Param{
        .name = "on_dial_fault",
        .doc = "store the point without that dial, or pause for a person; default store",
        .one_of = kOnFault},
    Param{
        .name = "on_mode_change",
        .doc = "before a point in another working mode pause until a person has brought the "
               "legs over, or go (a rig that does it by itself); default pause",
        .one_of = kOnModeChange},
    Param{
        .name = "on_lost_contact",
        .doc = "where two dials lose the cuboid on a move on which they should touch all the "
               "way: halt the robot and pause, or go; default halt",
        .one_of = kOnLostContact},
    Param{
        .name = "first_pass",
        .type = ParamType::kBoolean,
        .doc = "go to the outermost points only, slowly, and pause where a dial does not show "
               "what it should; asks before the first move and stores nothing"},
    Param{
        .name = "speed_percent",
        .type = ParamType::kInteger,
        .doc = "of the controller's full speed, until the collection ends; default: as it is, "
               "of a first pass 10",
        .min = 1,
        .max = 100},
    Param{
        .name = "stop_below_mm",
        .type = ParamType::kNumber,
        .doc =
            "leave out what is left of G1 once the standard deviation of the tool's position "
            "is below this at the worst place of the workspace; 0: never, the default",
        .min = 0,
        .max = 100}};
constexpr std::array<std::string_view, 2> kCriteria{"I", "D"};
constexpr std::array kNextParams{
    params::kSession,
    Param{
        .name = "points",
        .type = ParamType::kInteger,
        .doc = "so many; default 10",
        .min = 1,
        .max = 400},
    Param{
        .name = "criterion",
        .doc = "I: the tool's position over the workspace, D: all parameters; default I",
        .one_of = kCriteria},
    Param{
        .name = "modes",
        .type = ParamType::kStringList,
        .doc = "working modes to measure in; default: those of the session",
        .one_of = params::kModeWords}};
constexpr std::array kSeparateParams{
    params::kSession,
    Param{
        .name = "points",
        .type = ParamType::kInteger,
        .doc = "so many; default 24",
        .min = 1,
        .max = 400},
    Param{
        .name = "modes",
        .type = ParamType::kStringList,
        .doc = "working modes to measure in; default: all that can be measured",
        .one_of = params::kModeWords}};
constexpr std::array kWaitParams{Param{
    .name = "timeout_s",
    .type = ParamType::kNumber,
    .doc = "answer after this long in any case; default 60",
    .min = 0,
    .max = 600}};
constexpr std::array kMovedParams{
    Param{
        .name = "reached",
        .type = ParamType::kBoolean,
        .doc = "false: the robot cannot go there; default true"},
    Param{
        .name = "joints",
        .type = ParamType::kObject,
        .doc = "what the encoders show, by column: {\"theta1_rad\": 1.5, \"theta2_rad\": 3.0}; "
               "left out: the values asked for"},
    Param{
        .name = "theta1_rad", .type = ParamType::kNumber, .doc = "of a five-bar, as in joints"},
    Param{
        .name = "theta2_rad", .type = ParamType::kNumber, .doc = "of a five-bar, as in joints"},
    Param{
        .name = "confirm",
        .type = ParamType::kBoolean,
        .doc = "the joints really are far (0.2 rad, 20 mm) from what was asked for, which is "
               "asked back otherwise"},
    Param{.name = "temperature_c", .type = ParamType::kNumber, .doc = "at the robot"}};

constexpr std::string_view kStatus =
    "state (idle, starting, running, paused, stopping, done, stopped, failed), session, "
    "operator, "
    "done, total, stage, message, pause_reason (asked, dial_fault, mode_change, robot, store, "
    "first_move, lost_contact; null: not paused), trouble (the message without its advice), "
    "eta_s, stored_in_this_run, "
    "skipped, failed, left_out, "
    "troubles [{set, point, repeat, why}], clock_steps [{by_s, time_utc, after_samples}], "
    "point {set, point, repeat, target_mm}, move_to_rad "
    "and move_to [{joint, unit, value}] (a person is to move the robot there), move (the same "
    "for people: target_mm, joints [{joint, unit, to, from, first}], words), error, "
    "ended_because, estimate (null before the "
    "first sample of G1; in events only of type estimate and of the end: samples, set_aside, "
    "noise_times, parameters [{name, unit, value, sd, meaning}], position_sd_mm {mean, max, "
    "worst_mm, of_rig} over the workspace (of_rig: what is not known of the rig alone, at the "
    "worst place; not there where the rig file states nothing of itself), rig [{name, unit, "
    "off, sd, known_sd, stated}] as the samples so far see it, where they are enough, "
    "condition, undetermined [names], last_times_usual, last_unusual)";

constexpr std::array kMethods{
    RpcMethod{
        .name = "collect.start",
        .summary = "Measures the open points of a session's plan on the rig; goes on where an "
                   "earlier run ended.",
        .params = kStartParams,
        .result = kStatus,
        .example = R"({"session": "demo"})",
        .command = "sixdial collect PLAN --session {session}",
        .run = start},
    RpcMethod{
        .name = "collect.status",
        .summary = "How far the collection is.",
        .result = kStatus,
        .example = "{}",
        .run = status},
    RpcMethod{
        .name = "collect.wait",
        .summary =
            "As collect.status, but answers when the collection has ended or the time is "
            "over.",
        .params = kWaitParams,
        .result = kStatus,
        .example = R"({"timeout_s": 60})",
        .wait = wait},
    RpcMethod{
        .name = "collect.pause",
        .summary = "Pauses after the point in hand.",
        .result = kStatus,
        .example = "{}",
        .run = command<&Collection::pause>},
    RpcMethod{
        .name = "collect.resume",
        .summary =
            "Goes on after a pause; measures the point again that was the reason for it.",
        .result = kStatus,
        .example = "{}",
        .run = command<&Collection::resume>},
    RpcMethod{
        .name = "collect.skip",
        .summary = "Leaves out the point in hand, or the next one while paused.",
        .result = kStatus,
        .example = "{}",
        .run = command<&Collection::skip>},
    RpcMethod{
        .name = "collect.retake",
        .summary = "Measures the point in hand again, or the last stored one, as a new row.",
        .result = kStatus,
        .example = "{}",
        .command = "sixdial collection retake",
        .run = command<&Collection::retake>},
    RpcMethod{
        .name = "collect.accept",
        .summary = "While paused for a dial fault: stores the point as it is.",
        .result = kStatus,
        .example = "{}",
        .run = command<&Collection::accept>},
    RpcMethod{
        .name = "collect.moved",
        .summary = "A person has moved a robot without a controller to move_to_rad, or cannot.",
        .params = kMovedParams,
        .result = kStatus,
        .example = R"({"reached": true, "temperature_c": 20.5})",
        .run = moved},
    RpcMethod{
        .name = "collect.stop",
        .summary =
            "Ends the collection; the point in hand is rolled back, what is stored stays.",
        .result = kStatus,
        .example = "{}",
        .command = "sixdial collection stop",
        .run = command<&Collection::stop>},
    RpcMethod{
        .name = "plan.next",
        .summary = "The poses to measure next: a plan that makes the tool's position over the "
                   "workspace best known, given the session's samples so far.",
        .params = kNextParams,
        .result = "samples, points, criterion, now {mean_mm, max_mm}, after {mean_mm, max_mm}, "
                  "steps [{target_mm, mode, mean_mm, max_mm}] in the order chosen, plan_csv "
                  "(text of a plan file), notes [for the operator]",
        .example = R"({"session": "demo", "points": 5, "criterion": "I"})",
        .runs_on = RunsOn::kLong,
        .run = plan_next},
    RpcMethod{
        .name = "plan.separate",
        .summary = "The poses that would tell tied causes apart, or show the effect that the "
                   "session is blindest to: a plan ready to be collected.",
        .params = kSeparateParams,
        .result =
            "separates {cause, where}, rival {cause, where} or null, size_assumed, unit, "
            "points, log_odds_now, log_odds_after, by_point [{target_mm, mode, log_odds}], "
            "plan_csv (text of a plan file), notes [for the operator]",
        .example = R"({"session": "demo", "points": 8})",
        .runs_on = RunsOn::kLong,
        .run = plan_separate},
};

}  // namespace

std::span<const RpcMethod> collect_methods() { return kMethods; }

}  // namespace sixdial::service
