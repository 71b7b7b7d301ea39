#include "service/result_lookup.h"

#include <fmt/format.h>

#include <utility>
#include <vector>

namespace sixdial::service {

db::ResultRecord calibration_record(const Call& call) {
  db::Store& reader = call.service.reader();
  if (call.params.contains("result")) {
    return reader.load_result({call.params["result"].get<std::int64_t>()});
  }
  if (!call.params.contains("session")) {
    throw Error(
        ErrorCode::kInvalidParams, "one of 'result' and 'session' is needed",
        {{"param", "result"}});
  }
  const auto name = call.params["session"].get<std::string>();
  std::vector<db::ResultRecord> all =
      reader.load_results(reader.find_session(name), "calibration");
  if (all.empty()) {
    throw Error(
        ErrorCode::kNotFound, fmt::format("session {} has no result yet", name),
        {{"session", name}}, "Start a calibration: calibrate.start.");
  }
  return std::move(all.back());
}

}  // namespace sixdial::service
