// Any bytes as a line from a client: an error of the table, or a request whose answer is one
// line that Python's default reader takes.
#include <cstdint>
#include <cstdlib>
#include <string_view>

#include "service/socket/request.h"

using namespace sixdial;
using namespace sixdial::service;

namespace {

void expect(bool law) {
  if (!law) std::abort();
}

void check_line(const Json& reply) {
  const std::string line = to_reply_line(reply);
  expect(line.size() + 1 < kMaxLineBytes);
  expect(line.find('\n') == std::string::npos);
  expect(Json::parse(line)["jsonrpc"] == "2.0");
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const std::string_view line(reinterpret_cast<const char*>(data), size);
  Json json;
  try {
    json = parse_line(line);
    expect(nesting_depth(line) <= kMaxNesting);
    const Request request = parse_request(json);
    expect(request.params.is_object());
    check_line(
        result_reply(request.id, {{"method", request.method}, {"params", request.params}}));
  } catch (const Error&) {
    const Json error = to_error_object(std::current_exception());
    expect(error["code"].is_number() && !error["data"]["code"].get<std::string>().empty());
    check_line(error_reply(id_of(json), error));
  }
  return 0;
}
