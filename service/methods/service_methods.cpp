// The service about itself: hello, rpc.discover, events.subscribe, shutdown.
#include <array>

#include "service/service.h"
#include "service/socket/request.h"
#include "service/socket/server.h"

namespace sixdial::service {
namespace {

Json hello(const Call& call) {
  const std::filesystem::path database =
      std::filesystem::absolute(call.service.reader().path());
  return {
      {"database", database.string()},
      {"out_folder", (database.parent_path() / "out").string()},
      {"service", "sixdiald"},
      {"version", SIXDIAL_VERSION},
      {"protocol", 1},
      {"epoch", call.service.events().epoch()},
      {"last_seq", call.service.events().last_seq()},
      {"operator", call.caller.operator_name},
      {"limits",
       {{"request_bytes", kMaxRequestBytes},
        {"nesting", kMaxNesting},
        {"clients", kMaxClients},
        {"batch", kMaxBatch},
        {"line_bytes", kMaxLineBytes - 1}}}};
}

Json discover(const Call& call) {
  const auto only = param_or<std::string>(call.params, "method", "");
  Json methods = Json::array();
  for (const RpcMethod* method : all_methods()) {
    if (!only.empty() && method->name != only) continue;
    methods.push_back(
        {{"name", method->name},
         {"summary", method->summary},
         {"params", params_schema(*method)},
         {"result", method->result},
         {"example", Json::parse(method->example)}});
  }
  if (methods.empty()) static_cast<void>(find_method(only));  // says which is nearest
  Json errors = Json::array();
  for (const ErrorKind& kind : error_table()) {
    errors.push_back(
        {{"number", kind.number},
         {"code", kind.code},
         {"retry", kind.retry},
         {"meaning", kind.meaning}});
  }
  return {
      {"version", SIXDIAL_VERSION},
      {"methods", std::move(methods)},
      {"errors", std::move(errors)}};
}

Json subscribe(const Call& call) {
  if (call.sink == nullptr) {
    throw Error(ErrorCode::kWrongState, "only a connection can subscribe to events");
  }
  const auto since = call.params.find("since_seq");
  return call.sink->subscribe(
      param_or<std::vector<std::string>>(call.params, "topics", {}),
      since == call.params.end() || since->is_null()
          ? std::nullopt
          : std::optional(since->get<std::uint64_t>()));
}

Json shutdown(const Call& call) {
  call.service.request_shut_down();
  return {{"stopping", true}};
}

constexpr std::array kDiscoverParams{
    Param{.name = "method", .doc = "only this method instead of all"}};
constexpr std::array kSubscribeParams{
    Param{
        .name = "topics",
        .type = ParamType::kStringList,
        .doc = "which events; empty or left out: all",
        .one_of = kTopics},
    Param{
        .name = "since_seq",
        .type = ParamType::kInteger,
        .doc =
            "replay what came after this number and is still kept; left out: only new events",
        .min = 0}};

constexpr std::array kMethods{
    RpcMethod{
        .name = "hello",
        .summary = "Versions, limits and who you are to the service.",
        .result = "service, version, protocol, database, out_folder (where it may write), "
                  "epoch (this run of "
                  "the service), last_seq, operator, "
                  "limits {request_bytes, nesting, clients, batch, line_bytes}",
        .example = "{}",
        .runs_on = RunsOn::kLoop,
        .run = hello},
    RpcMethod{
        .name = "rpc.discover",
        .summary = "Every method with its schema and an example, and the table of errors.",
        .params = kDiscoverParams,
        .result = "version, methods [{name, summary, params (JSON Schema), result, example}], "
                  "errors [{number, code, retry, meaning}]",
        .example = R"({"method": "hello"})",
        .runs_on = RunsOn::kLoop,
        .run = discover},
    RpcMethod{
        .name = "events.subscribe",
        .summary = "Streams numbered events on this connection, beginning after `since_seq`.",
        .params = kSubscribeParams,
        .result =
            "epoch, last_seq, replayed, lost; then notifications events.event {seq, topic, "
            "time_utc, data} and events.gap {from_seq, to_seq, count, live}",
        .example = R"({"topics": ["job", "sample"], "since_seq": 0})",
        .runs_on = RunsOn::kLoop,
        .run = subscribe},
    RpcMethod{
        .name = "shutdown",
        .summary = "Ends the service: the point in hand is finished or rolled back, jobs are "
                   "cancelled, queued lines are sent.",
        .result = "stopping",
        .example = "{}",
        .runs_on = RunsOn::kLoop,
        .run = shutdown},
};

}  // namespace

std::span<const RpcMethod> service_methods() { return kMethods; }

}  // namespace sixdial::service
