// The pieces of a connection string, PLACE?key=value&key=value, and refusals in words. Only for
// what reads connection strings.
#pragma once

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <array>
#include <map>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "acquisition/connection.h"

namespace sixdial::acquisition {

/// Why a connection string cannot be used; caught by whoever parses the whole of it.
struct Refused {
  std::string why;
};

template <typename... Args>
[[noreturn]] void refuse(fmt::format_string<Args...> format, Args&&... args) {
  throw Refused{fmt::format(format, std::forward<Args>(args)...)};
}
/// "connection '...': why".
[[nodiscard]] std::string refused_connection(std::string_view text, const Refused& refused);

/// The known word that looks most like `word`; `known` is not empty.
[[nodiscard]] std::string_view nearest(
    std::string_view word, std::span<const std::string_view> known);
/// What stands before the first colon.
[[nodiscard]] std::string_view scheme_of(std::string_view text);

/// PLACE?QUERY.
struct ConnectionPieces {
  std::string_view place;
  std::string_view query;
};
[[nodiscard]] ConnectionPieces split(std::string_view text);

/// HOST:PORT of //HOST:PORT, which may be written either way.
[[nodiscard]] std::string_view without_slashes(std::string_view place);
/// host, host:port, [v6]:port. Throws Refused.
[[nodiscard]] ModbusTcpEndpoint tcp_endpoint(std::string_view place, int usual_port = 502);
/// HOST:PORT?key=value of a Modbus device, with these keys only. Throws Refused.
[[nodiscard]] ModbusConnection tcp_connection(
    std::string_view rest, std::span<const std::string_view> keys);
/// A device path; throws Refused.
[[nodiscard]] std::string device_path(std::string_view place);

/// key=value&key=value. Everything throws Refused.
class ConnectionOptions {
 public:
  ConnectionOptions(std::string_view query, std::span<const std::string_view> known);

  [[nodiscard]] bool has(const std::string& key) const { return values_.contains(key); }
  [[nodiscard]] std::string text(const std::string& key, std::string_view otherwise) const;
  [[nodiscard]] int whole(const std::string& key, int otherwise, int least, int most) const;
  /// As `whole`, or "none": -1.
  [[nodiscard]] int address(const std::string& key, int otherwise) const;
  /// Finite and not 0.
  [[nodiscard]] double number(const std::string& key, double otherwise) const;

  template <typename Value, std::size_t count>
  [[nodiscard]] Value one_of(
      const std::string& key, Value otherwise,
      const std::array<std::pair<std::string_view, Value>, count>& choices) const {
    const auto found = values_.find(key);
    if (found == values_.end()) return otherwise;
    std::vector<std::string_view> words;
    for (const auto& [word, value] : choices) {
      if (word == found->second) return value;
      words.push_back(word);
    }
    refuse("{}={} is none of {}", key, found->second, fmt::join(words, ", "));
  }

 private:
  std::map<std::string, std::string> values_;
};

}  // namespace sixdial::acquisition
