// The rig's devices while nothing is collected: the dials live, with the check by a finger.
#include <fmt/format.h>

#include <algorithm>
#include <array>

#include "acquisition/robot_driver.h"
#include "service/methods/shared_params.h"
#include "service/service.h"

namespace sixdial::service {
namespace {

Json watch(const Call& call) {
  const Json collecting = call.service.collection().status();
  if (call.service.collection().active()) {
    throw Error(
        ErrorCode::kWrongState, "the dials are in use: a session is being collected",
        {{"session", collecting["session"]}}, "Its live events show them.");
  }
  return call.service.dial_watch().watch(
      call.params.at("session").get<std::string>(),
      std::chrono::milliseconds(
          static_cast<std::int64_t>(1000.0 * param_or(call.params, "for_s", 30.0))));
}

constexpr std::array<std::string_view, 4> kSteps{"start", "again", "skip", "end"};

Json check(const Call& call) {
  const auto word = call.params.at("do").get<std::string>();
  const auto* found = std::ranges::find(kSteps, word);
  return call.service.dial_watch().check(
      static_cast<DialWatch::CheckStep>(found - kSteps.begin()));
}

Json stop(const Call& call) {
  call.service.dial_watch().stop();
  return call.service.dial_watch().status();
}

/// The controller of a session's robot while nothing is collected.
void halt_alone(const Call& call) {
  const auto session = param_or<std::string>(call.params, "session", "");
  if (session.empty()) {
    throw Error(
        ErrorCode::kWrongState, "nothing is being collected, so no robot is known", {},
        "Name the session whose robot it is.");
  }
  db::Store& reader = call.service.reader();
  const geometry::Rig rig = reader.load_rig(reader.find_session(session));
  const auto connection = acquisition::robot_connection_of(rig);
  if (!connection || connection->driver->by_hand) {
    throw Error(
        ErrorCode::kWrongState,
        "the robot of this session has no controller that could stop it",
        {{"session", session}},
        "It is moved by hand, or the rig file has no connection for it.");
  }
  acquisition::SystemClock clock;
  const auto told = connection->open({.clock = clock})->halt({});
  if (told) return;
  throw Error(
      ErrorCode::kDevice,
      fmt::format("the robot could not be told to stop: {}", told.error().detail),
      {{"session", session}}, "Use the emergency stop if anything is in danger.");
}

Json stop_robot(const Call& call) {
  const bool collecting = call.service.collection().active();
  if (collecting) {
    call.service.collection().halt_robot();
  } else {
    halt_alone(call);
  }
  return {
      {"told", true},
      {"words", collecting
                    ? "the controller was told to stop the robot; the collection pauses, and "
                      "resume goes to the point in hand again"
                    : "the controller was told to stop the robot"}};
}

constexpr std::array kStopParams{
    Param{.name = "session", .doc = "whose robot it is; needed while nothing is collected"}};
constexpr std::array kWatchParams{
    params::kSession, Param{
                          .name = "for_s",
                          .type = ParamType::kNumber,
                          .doc = "so long, unless it is asked for again meanwhile; default 30",
                          .min = 1,
                          .max = 3600}};
constexpr std::array kCheckParams{Param{
    .name = "do",
    .required = true,
    .doc =
        "start: with the first dial; again: the one before once more, at the end all that are "
        "not good; skip: the dial asked for; end",
    .one_of = kSteps}};
constexpr std::string_view kStatus =
    "watching, session, check (null, or asked: the dial to push, null at the end; instruction, "
    "done, good, dials [{dial, verdict (open, good, other, together, reversed, inch, short, "
    "skipped), words}])";

constexpr std::array kMethods{
    RpcMethod{
        .name = "dials.watch",
        .summary = "Shows the dials of a session's rig as live events while nothing is "
                   "collected.",
        .params = kWatchParams,
        .result = kStatus,
        .example = R"({"session": "demo", "for_s": 2})",
        .command = "sixdial dials {session}",
        .run = watch},
    RpcMethod{
        .name = "dials.check",
        .summary =
            "\"Push each dial with a finger\": whether the right letter moves, the right "
            "way, in millimetres. The live events carry it on.",
        .params = kCheckParams,
        .result = kStatus,
        .example = R"({"do": "start"})",
        .command = "sixdial dials {session} --check",
        .run = check},
    RpcMethod{
        .name = "robot.stop",
        .summary = "Tells the controller to stop the robot where it is, at once. No emergency "
                   "stop: that is hardware.",
        .params = kStopParams,
        .result = "told, words",
        .example = R"({"session": "demo"})",
        .command = "sixdial robot stop",
        .run = stop_robot},
    RpcMethod{
        .name = "dials.stop",
        .summary = "Lets the dials go that dials.watch shows.",
        .result = kStatus,
        .example = "{}",
        .run = stop},
};

}  // namespace

std::span<const RpcMethod> rig_methods() { return kMethods; }

}  // namespace sixdial::service
