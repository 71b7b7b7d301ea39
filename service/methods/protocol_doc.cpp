// doc/protocol.md, printed from the method table so that the two cannot differ.
#include <fmt/format.h>

#include <string>

#include "service/methods/method.h"
#include "service/socket/request.h"
#include "service/socket/server.h"

namespace sixdial::service {
namespace {

constexpr std::string_view kOpening =
    R"(# The socket protocol

<!-- Printed by `sixdiald --print-protocol` from the method table; a test compares. -->

JSON-RPC 2.0 on a Unix socket, one compact object a line, in UTF-8. Parameters go by name.
The socket is `$XDG_RUNTIME_DIR/sixdial/sixdiald.sock`, else `/run/sixdial/sixdiald.sock`, or what
`sixdiald --socket PATH` says. By hand:

```
echo '{{"jsonrpc":"2.0","id":1,"method":"hello"}}' | nc -U -N $XDG_RUNTIME_DIR/sixdial/sixdiald.sock
```

From Python:

```python
import json, os, socket
s = socket.socket(socket.AF_UNIX); s.connect(os.environ["XDG_RUNTIME_DIR"] + "/sixdial/sixdiald.sock")
s.sendall(b'{{"jsonrpc":"2.0","id":1,"method":"hello"}}\n'); print(json.loads(s.makefile().readline()))
```

- Answers come in the order of the requests, except that a request that waits (`job.wait`,
  `collect.wait`) does not hold up those after it: go by `id`. A request without `id` gets no answer.
- A batch (an array of at most {batch} requests) gets one array back.
- A client that closes its sending side gets what is under way, then the connection ends.

## Limits

| what | limit | beyond it |
|---|---|---|
| request line | {request} bytes | `line_too_long`; the rest of the line is skipped, the connection goes on |
| nesting | {nesting} levels | `nesting_too_deep`, before the line is parsed |
| clients | {clients} | `too_many_clients`, then the connection is closed |
| line sent | under {line} bytes | `result_too_large`: ask by page or to a file |
| a client that does not read | 10 s | the connection is closed; events queued for it beyond 1024 are dropped before and named by `events.gap` |

## Events

After `events.subscribe` the service sends, on the same connection:

```
{{"jsonrpc":"2.0","method":"events.event","params":{{"seq":12,"topic":"job","time_utc":"...","data":{{...}}}}}}
{{"jsonrpc":"2.0","method":"events.gap","params":{{"from_seq":3,"to_seq":9,"count":7,"live":false}}}}
```

Numbers rise by one over all topics within one run of the service (`epoch`). After a reconnection,
subscribe with `since_seq` to get what was missed; the last 4096 events are kept. `live` readings
are never replayed, and a client too slow for them gets the newest (`"live":true` in the gap).

| topic | data |
|---|---|
| job | `type` (queued, started, progress, done, failed, cancelled) and the job as in `job.status` |
| sample | a sample, after it is stored: set, point, repeat, number, readings, position, flags |
| collect | `type` (started, point, paused, resumed, skipped, flagged, stopped, done, failed) and the state as in `collect.status` |
| live | while a session is collected, or dials.watch asks for it, the dials as they are now: `dials` {{id: value_mm, quality, reason, `words` of it, `state` (ok, settling, waiting: no value while the robot moves, free: touches nothing, stale, lost)}}, `check` as dials.check has it, `settle` {{spread_mm, limit_mm, settled}} of the last two values shown of the dial that is furthest from rest, `pose` {{x_mm, y_mm, gamma_rad, dials used}} or null |
| service | `type` (stopping) |

What an event, a job, a session, a collection and every stored document hold to the last key is in the JSON Schemas of
[doc/schemas/](schemas): [event](schemas/event.json), [job](schemas/job.json), [session](schemas/session.json),
[collect](schemas/collect.json), [calibration](schemas/calibration.json), [diagnosis](schemas/diagnosis.json).

## Errors

`error.data` is `{{"code", "at", "retry", "hint"}}`: a stable word, what was at fault (`dial`, `column`,
`file`, `line`, `param`, ...), whether the same request may succeed later, and what to do.
The last column is the exit code of `sixdial`.

| number | code | retry | meaning | exit |
|---|---|---|---|---|
)";

std::string parameter_table(const RpcMethod& method) {
  if (method.params.empty()) return "No parameters.\n";
  std::string text = "| parameter | type | | what |\n|---|---|---|---|\n";
  for (const Param& param : method.params) {
    text += fmt::format(
        "| {} | {} | {} | {}{} |\n", param.name, to_string(param.type),
        param.required ? "required" : "", param.doc,
        param.one_of.empty() ? ""
                             : fmt::format(" (one of: {})", fmt::join(param.one_of, ", ")));
  }
  return text;
}

}  // namespace

std::string protocol_markdown() {
  std::string text = fmt::format(
      kOpening, fmt::arg("batch", kMaxBatch), fmt::arg("request", kMaxRequestBytes),
      fmt::arg("nesting", kMaxNesting), fmt::arg("clients", kMaxClients),
      fmt::arg("line", kMaxLineBytes));
  for (const ErrorKind& kind : error_table()) {
    text += fmt::format(
        "| {} | `{}` | {} | {} | {} |\n", kind.number, kind.code, kind.retry ? "yes" : "no",
        kind.meaning, static_cast<int>(kind.exit_code));
  }
  text += "\n## Methods\n";
  for (const RpcMethod* method : all_methods()) {
    const Json example{
        {"jsonrpc", "2.0"},
        {"id", 1},
        {"method", method->name},
        {"params", Json::parse(method->example)}};
    text += fmt::format(
        "\n### {}\n\n{}\n\n{}\nResult: {}.\n\n```\n{}\n```\n", method->name, method->summary,
        parameter_table(*method), method->result, to_line(example));
  }
  return text;
}

}  // namespace sixdial::service
