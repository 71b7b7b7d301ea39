#include "service/socket/request.h"

#include <fmt/format.h>

#include <algorithm>
#include <exception>

namespace sixdial::service {
namespace {

bool is_id(const Json& json) { return json.is_null() || json.is_string() || json.is_number(); }

}  // namespace

int nesting_depth(std::string_view text) {
  int depth = 0;
  int deepest = 0;
  bool in_string = false;
  bool escaped = false;
  for (const char letter : text) {
    if (in_string) {
      if (escaped) {
        escaped = false;
      } else if (letter == '\\') {
        escaped = true;
      } else if (letter == '"') {
        in_string = false;
      }
    } else if (letter == '"') {
      in_string = true;
    } else if (letter == '[' || letter == '{') {
      deepest = std::max(deepest, ++depth);
    } else if (letter == ']' || letter == '}') {
      --depth;
    }
  }
  return deepest;
}

Json parse_line(std::string_view line) {
  if (line.size() > kMaxRequestBytes) {
    throw Error(
        ErrorCode::kLineTooLong,
        fmt::format("a request line may have {} bytes", kMaxRequestBytes));
  }
  if (const int depth = nesting_depth(line); depth > kMaxNesting) {
    throw Error(
        ErrorCode::kNestingTooDeep,
        fmt::format(
            "the request is nested {} levels deep, {} are allowed", depth, kMaxNesting));
  }
  try {
    return Json::parse(line);
  } catch (const Json::parse_error& error) {
    throw Error(
        ErrorCode::kParseError, fmt::format("not JSON from byte {} on", error.byte),
        {{"column", error.byte}});
  } catch (const Json::out_of_range&) {  // 1e999
    throw Error(ErrorCode::kParseError, "a number is too large for a double");
  }
}

Request parse_request(const Json& json) {
  const auto refuse = [](const std::string& what) {
    throw Error(ErrorCode::kInvalidRequest, what);
  };
  if (!json.is_object()) refuse("a request is a JSON object");
  if (json.value("jsonrpc", Json{}) != "2.0") refuse(R"(the member "jsonrpc" must be "2.0")");
  if (!json.contains("method") || !json["method"].is_string()) {
    refuse(R"(the member "method" must be a string)");
  }
  for (const auto& [key, value] : json.items()) {
    if (key != "jsonrpc" && key != "id" && key != "method" && key != "params") {
      refuse(fmt::format(
          "a request has no member '{}' (only jsonrpc, id, method, params)",
          key.substr(0, 64)));
    }
  }
  Request request;
  request.notification = !json.contains("id");
  if (!request.notification) {
    request.id = json["id"];
    if (!is_id(request.id)) refuse(R"(the member "id" must be a number, a string or null)");
  }
  request.method = json["method"].get<std::string>();
  request.params = json.value("params", Json::object());
  if (request.params.is_array()) {
    if (!request.params.empty()) {
      throw Error(
          ErrorCode::kInvalidParams, "parameters go by name, not by position", {},
          R"(Write "params":{"name":value}.)");
    }
    request.params = Json::object();
  }
  if (!request.params.is_object()) refuse(R"(the member "params" must be an object)");
  return request;
}

Json id_of(const Json& json) {
  if (!json.is_object() || !json.contains("id") || !is_id(json["id"])) return nullptr;
  return json["id"];
}

Json result_reply(const Json& id, Json result) {
  return {{"jsonrpc", "2.0"}, {"id", id}, {"result", std::move(result)}};
}

Json error_reply(const Json& id, Json error_object) {
  return {{"jsonrpc", "2.0"}, {"id", id}, {"error", std::move(error_object)}};
}

std::string to_line(const Json& json) {
  return json.dump(-1, ' ', false, Json::error_handler_t::replace);
}

std::string to_reply_line(const Json& reply) {
  std::string line = to_line(reply);
  if (line.size() + 1 < kMaxLineBytes) return line;
  Json id = id_of(reply);
  constexpr std::size_t kLongestEchoedId = 1024;
  if (id.is_string() && id.get_ref<const std::string&>().size() > kLongestEchoedId)
    id = nullptr;
  return to_line(error_reply(
      id,
      to_error_object(std::make_exception_ptr(Error(
          ErrorCode::kResultTooLarge, fmt::format(
                                          "the answer has {} bytes, a line has fewer than {}",
                                          line.size(), kMaxLineBytes))))));
}

}  // namespace sixdial::service
