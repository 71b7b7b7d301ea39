// One line from a client: checked for length and nesting before any parser sees it, then JSON,
// then the shape of JSON-RPC 2.0.
#pragma once

#include <cstddef>
#include <string>
#include <string_view>

#include "service/error.h"

namespace sixdial::service {

inline constexpr std::size_t kMaxRequestBytes = std::size_t{1} << 20;
inline constexpr int kMaxNesting = 32;
/// Every line sent is shorter than this, its newline counted (Python's default reader's limit).
inline constexpr std::size_t kMaxLineBytes = std::size_t{64} * 1024;
inline constexpr std::size_t kMaxBatch = 64;

/// Deepest level of [ and { outside strings; 1 for a flat object. Works on text that is not
/// JSON.
[[nodiscard]] int nesting_depth(std::string_view text);

/// The line as JSON. Throws Error: line_too_long, nesting_too_deep, parse_error.
[[nodiscard]] Json parse_line(std::string_view line);

struct Request {
  Json id;                    // null where the request had none
  bool notification = false;  // without id: no answer is sent
  std::string method;
  Json params;  // object
};
/// Throws Error: invalid_request, invalid_params (positional).
[[nodiscard]] Request parse_request(const Json& json);
/// The id to answer a broken request with: its own where that is a number or a string, else
/// null.
[[nodiscard]] Json id_of(const Json& json);

[[nodiscard]] Json result_reply(const Json& id, Json result);
[[nodiscard]] Json error_reply(const Json& id, Json error_object);
/// Compact, one line, no newline inside, invalid UTF-8 replaced.
[[nodiscard]] std::string to_line(const Json& json);
/// As to_line; a reply too long for a line becomes the error result_too_large.
[[nodiscard]] std::string to_reply_line(const Json& reply);

}  // namespace sixdial::service
