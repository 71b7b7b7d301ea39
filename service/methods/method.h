// The methods of the socket (JSON-RPC), one row each: the service dispatches by this table and
// checks parameters by it, rpc.discover and doc/protocol.md print it, and a test runs its
// examples.
#pragma once

#include <chrono>
#include <functional>
#include <limits>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "service/error.h"

namespace sixdial::service {

class Service;

/// Who asks: the peer credentials of the socket, kept as the operator of each action.
struct Caller {
  std::string operator_name = "local";
  int uid = -1;
  int pid = -1;
};

/// What a connection can do for a method besides answering.
class EventSink {
 public:
  virtual ~EventSink() = default;
  /// Replaces an earlier subscription. Topics empty: all. Returns {"epoch", "last_seq", ...}.
  virtual Json subscribe(
      std::vector<std::string> topics, std::optional<std::uint64_t> since) = 0;
};

enum class ParamType { kString, kInteger, kNumber, kBoolean, kStringList, kObject };
[[nodiscard]] std::string_view to_string(ParamType type);

struct Param {
  std::string_view name;
  ParamType type = ParamType::kString;
  bool required = false;
  std::string_view doc;
  double min = -std::numeric_limits<double>::infinity();
  double max = std::numeric_limits<double>::infinity();
  std::span<const std::string_view> one_of{};
};

struct Call {
  Service& service;
  const Json& params;  // checked against the method's row
  const Caller& caller;
  EventSink* sink = nullptr;  // null without a connection
};

/// An answer that comes when something has happened, without holding a thread.
struct Wait {
  std::function<bool()> ready;
  std::function<Json()> answer;  // also after the time is over
  std::chrono::milliseconds timeout{0};
};

enum class RunsOn {
  kLoop,     // at once on the socket's loop: microseconds, touches no file
  kWorker,   // on a worker thread: may use the database
  kFiles,    // on a worker for files that a client names, which may hang; others go on
  kReading,  // on a worker for what looks at a whole session: seconds; ends with its client
  kLong,     // on a worker for what may take minutes; ends with its client (long_work.h)
};

struct RpcMethod {
  std::string_view name;
  std::string_view summary;
  std::span<const Param> params{};
  std::string_view result;   // what the answer holds, in words
  std::string_view example;  // params as JSON text; paths begin with /srv/rig
  RunsOn runs_on = RunsOn::kWorker;
  /// The command that calls it, for people at a terminal: a hint that names this method names
  /// the command there. "{session}" is the session in question. Empty: none.
  std::string_view command{};
  Json (*run)(const Call&) = nullptr;
  Wait (*wait)(const Call&) = nullptr;  // instead of run
};

/// Sorted by name.
[[nodiscard]] std::span<const RpcMethod* const> all_methods();
/// Throws Error unknown_method, naming the nearest one.
[[nodiscard]] const RpcMethod& find_method(std::string_view name);
/// Throws Error invalid_params: required, type, range, choice, unknown name with the nearest.
void check_params(const RpcMethod& method, const Json& params);
/// JSON Schema of the parameters.
[[nodiscard]] Json params_schema(const RpcMethod& method);
/// doc/protocol.md: limits, errors, events and every method.
[[nodiscard]] std::string protocol_markdown();

// The groups of rows, one file each.
[[nodiscard]] std::span<const RpcMethod> service_methods();
[[nodiscard]] std::span<const RpcMethod> session_methods();
[[nodiscard]] std::span<const RpcMethod> plan_methods();
[[nodiscard]] std::span<const RpcMethod> collect_methods();
[[nodiscard]] std::span<const RpcMethod> job_methods();
[[nodiscard]] std::span<const RpcMethod> result_methods();
[[nodiscard]] std::span<const RpcMethod> compare_methods();
[[nodiscard]] std::span<const RpcMethod> diagnosis_methods();
[[nodiscard]] std::span<const RpcMethod> compensation_methods();
[[nodiscard]] std::span<const RpcMethod> export_methods();
[[nodiscard]] std::span<const RpcMethod> validation_methods();
[[nodiscard]] std::span<const RpcMethod> rig_methods();

/// params[name], or `otherwise` if it is absent or null. Only for a name that the method's row
/// declares.
template <typename T>
[[nodiscard]] T param_or(const Json& params, std::string_view name, T otherwise) {
  const auto found = params.find(name);
  return found == params.end() || found->is_null() ? otherwise : found->template get<T>();
}

}  // namespace sixdial::service
