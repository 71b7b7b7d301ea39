#include "acquisition/connection.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <map>
#include <numeric>
#include <span>
#include <vector>

#include "session/nearest.h"

namespace sixdial::acquisition {
namespace {

// Thrown and caught within this file: one way out of a nest of small parsers.
struct Refused {
  std::string why;
};

template <typename... Args>
[[noreturn]] void refuse(fmt::format_string<Args...> format, Args&&... args) {
  throw Refused{fmt::format(format, std::forward<Args>(args)...)};
}

std::string_view nearest(std::string_view word, std::span<const std::string_view> known) {
  return *std::min_element(known.begin(), known.end(), [&](auto a, auto b) {
    return session::edit_distance(word, a) < session::edit_distance(word, b);
  });
}

class Options {
 public:
  Options(std::string_view query, std::span<const std::string_view> known) {
    while (!query.empty()) {
      const std::size_t end = query.find('&');
      const std::string_view item = query.substr(0, end);
      query = end == std::string_view::npos ? std::string_view{} : query.substr(end + 1);
      const std::size_t equals = item.find('=');
      if (equals == std::string_view::npos) {
        refuse("'{}' is not key=value", item);
      }
      const std::string_view key = item.substr(0, equals);
      if (std::find(known.begin(), known.end(), key) == known.end()) {
        refuse(
            "unknown key '{}'; did you mean '{}'? (known: {})", key, nearest(key, known),
            fmt::join(known, ", "));
      }
      if (!values_.emplace(std::string(key), std::string(item.substr(equals + 1))).second) {
        refuse("key '{}' is there twice", key);
      }
    }
  }

  [[nodiscard]] bool has(const std::string& key) const { return values_.contains(key); }

  [[nodiscard]] std::string text(const std::string& key, std::string_view otherwise) const {
    const auto found = values_.find(key);
    return found == values_.end() ? std::string(otherwise) : found->second;
  }

  [[nodiscard]] int whole(const std::string& key, int otherwise, int least, int most) const {
    const auto found = values_.find(key);
    if (found == values_.end()) return otherwise;
    const std::string& word = found->second;
    int value = 0;
    const auto [end, error] = std::from_chars(word.data(), word.data() + word.size(), value);
    if (error != std::errc{} || end != word.data() + word.size() || value < least ||
        value > most) {
      refuse("{}={} is not a whole number from {} to {}", key, word, least, most);
    }
    return value;
  }

  /// As `whole`, or "none": -1.
  [[nodiscard]] int address(const std::string& key, int otherwise) const {
    return text(key, "") == "none" ? -1 : whole(key, otherwise, 0, 65535);
  }

  [[nodiscard]] double number(const std::string& key, double otherwise) const {
    const auto found = values_.find(key);
    if (found == values_.end()) return otherwise;
    const std::string& word = found->second;
    double value = 0.0;
    const auto [end, error] = std::from_chars(word.data(), word.data() + word.size(), value);
    if (error != std::errc{} || end != word.data() + word.size() || !std::isfinite(value) ||
        value == 0.0) {
      refuse("{}={} is not a number other than 0", key, word);
    }
    return value;
  }

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

struct Pieces {
  std::string_view place;
  std::string_view query;
};

Pieces split(std::string_view text) {
  const std::size_t mark = text.find('?');
  if (mark == std::string_view::npos) return {text, {}};
  return {text.substr(0, mark), text.substr(mark + 1)};
}

std::chrono::milliseconds timeout_of(const Options& options) {
  return std::chrono::milliseconds(options.whole("timeout_ms", 300, 20, 300));
}

constexpr std::array<std::pair<std::string_view, Parity>, 3> kParities{
    {{"N", Parity::kNone}, {"E", Parity::kEven}, {"O", Parity::kOdd}}};

SerialConnection serial_connection(std::string_view rest) {
  static constexpr std::array<std::string_view, 3> kKeys{"dialect", "channel", "timeout_ms"};
  const Pieces pieces = split(rest);
  if (!pieces.place.starts_with('/')) {
    refuse("'{}' is not a device path such as /dev/serial/by-id/...", pieces.place);
  }
  const Options options(pieces.query, kKeys);
  std::vector<std::string_view> dialects;
  for (const DialProtocol* protocol : dial_protocols()) dialects.push_back(protocol->name);
  if (!options.has("dialect")) {
    refuse("no dialect is given; add ?dialect= one of {}", fmt::join(dialects, ", "));
  }
  SerialConnection result;
  result.device = std::string(pieces.place);
  const std::string dialect = options.text("dialect", "");
  result.protocol = find_dial_protocol(dialect);
  if (result.protocol == nullptr) {
    refuse(
        "unknown dialect '{}'; did you mean '{}'? (known: {})", dialect,
        nearest(dialect, dialects), fmt::join(dialects, ", "));
  }
  result.timeout = options.has("timeout_ms") ? timeout_of(options) : result.protocol->timeout;
  const int channels = result.protocol->channels;
  if (channels == 0 && options.has("channel")) {
    refuse("dialect {} is one dial a cable and has no channel", dialect);
  }
  if (channels > 0) {
    if (!options.has("channel")) {
      refuse("dialect {} needs channel=1..{}", dialect, channels);
    }
    result.channel = options.whole("channel", 1, 1, channels);
  }
  return result;
}

ModbusTcpEndpoint tcp_endpoint(std::string_view place) {
  ModbusTcpEndpoint endpoint;
  std::string_view port;
  bool has_port = false;
  if (place.starts_with('[')) {
    const std::size_t end = place.find(']');
    if (end == std::string_view::npos) refuse("'{}' has no closing ]", place);
    endpoint.host = std::string(place.substr(1, end - 1));
    const std::string_view after = place.substr(end + 1);
    has_port = after.starts_with(':');
    if (has_port) port = after.substr(1);
    if (!has_port && !after.empty()) refuse("'{}' after the ] is not a :port", after);
  } else {
    const std::size_t colon = place.rfind(':');
    has_port = colon != std::string_view::npos;
    endpoint.host = std::string(place.substr(0, colon));
    if (has_port) port = place.substr(colon + 1);
  }
  if (endpoint.host.empty() || endpoint.host.size() > 255 ||
      endpoint.host.find_first_of("/ ") != std::string::npos) {
    refuse("'{}' is not host:port", place);
  }
  if (has_port) {
    const auto [end, error] =
        std::from_chars(port.data(), port.data() + port.size(), endpoint.port);
    if (error != std::errc{} || end != port.data() + port.size() || endpoint.port < 1 ||
        endpoint.port > 65535) {
      refuse("port '{}' is not a number from 1 to 65535", port);
    }
  }
  return endpoint;
}

ModbusMap modbus_map(const Options& options, int most_units) {
  static constexpr std::array<std::pair<std::string_view, WordOrder>, 4> kOrders{
      {{"high", WordOrder::kHighFirst},
       {"low", WordOrder::kLowFirst},
       {"big", WordOrder::kHighFirst},
       {"little", WordOrder::kLowFirst}}};
  static constexpr std::array<std::pair<std::string_view, RegisterFormat>, 3> kFormats{
      {{"int32", RegisterFormat::kInt32},
       {"float32", RegisterFormat::kFloat32},
       {"int16", RegisterFormat::kInt16}}};
  static constexpr std::array<std::pair<std::string_view, int>, 2> kFunctions{
      {{"3", 3}, {"4", 4}}};
  ModbusMap map;
  map.unit = options.whole("unit", 1, 1, most_units);
  map.function = options.one_of("function", 4, kFunctions);
  map.format = options.one_of("format", RegisterFormat::kInt32, kFormats);
  const bool floating = map.format == RegisterFormat::kFloat32;
  map.base = options.whole("base", floating ? 8000 : 0, 0, 65535);
  map.count = options.whole("count", 0, 1, 60);
  map.scale = options.number("scale", floating ? 1.0 : 0.001);
  map.word_order = options.one_of("word_order", WordOrder::kHighFirst, kOrders);
  map.status = options.address("status", 100);
  map.counter = options.address("counter", 106);
  return map;
}

constexpr std::array<std::string_view, 12> kTcpDialKeys{
    "unit",   "index",  "base",    "count",      "scale",    "word_order",
    "format", "status", "counter", "timeout_ms", "quiet_ms", "function"};

ModbusConnection tcp_connection(std::string_view rest, std::span<const std::string_view> keys) {
  const Pieces pieces = split(rest);
  const Options options(pieces.query, keys);
  ModbusConnection result;
  result.endpoint = tcp_endpoint(pieces.place);
  result.map = modbus_map(options, 255);
  if (options.has("index")) result.index = options.whole("index", 0, 0, 59);
  result.timeout = timeout_of(options);
  result.quiet = std::chrono::milliseconds(options.whole("quiet_ms", 1000, 0, 10000));
  return result;
}

ModbusConnection rtu_connection(std::string_view rest) {
  std::vector<std::string_view> keys(kTcpDialKeys.begin(), kTcpDialKeys.end());
  keys.insert(keys.end(), {"baud", "parity", "stop_bits"});
  const Pieces pieces = split(rest);
  if (!pieces.place.starts_with('/')) {
    refuse("'{}' is not a device path such as /dev/serial/by-id/...", pieces.place);
  }
  const Options options(pieces.query, keys);
  ModbusRtuEndpoint endpoint;
  endpoint.device = std::string(pieces.place);
  endpoint.baud = options.whole("baud", 19200, 300, 921600);
  static constexpr std::array kBauds{300,   600,   1200,   2400,   4800,   9600,  19200,
                                     38400, 57600, 115200, 230400, 460800, 921600};
  if (std::find(kBauds.begin(), kBauds.end(), endpoint.baud) == kBauds.end()) {
    refuse("baud={} is none of {}", endpoint.baud, fmt::join(kBauds, ", "));
  }
  endpoint.parity = options.one_of("parity", Parity::kNone, kParities);
  endpoint.stop_bits = options.whole("stop_bits", 1, 1, 2);
  ModbusConnection result;
  result.endpoint = endpoint;
  result.map = modbus_map(options, 247);
  if (options.has("index")) result.index = options.whole("index", 0, 0, 59);
  result.timeout = timeout_of(options);
  result.quiet = std::chrono::milliseconds(options.whole("quiet_ms", 1000, 0, 10000));
  return result;
}

std::string_view scheme_of(std::string_view text) { return text.substr(0, text.find(':')); }

std::string context(std::string_view text, const Refused& refused) {
  return fmt::format("connection '{}': {}", text, refused.why);
}

}  // namespace

tl::expected<DialConnection, std::string> parse_dial_connection(std::string_view text) {
  static constexpr std::array<std::string_view, 3> kSchemes{
      "serial", "modbus-tcp", "modbus-rtu"};
  try {
    if (text.empty()) refuse("it is empty; give serial:, modbus-tcp:// or modbus-rtu:");
    if (text.starts_with("serial:")) return serial_connection(text.substr(7));
    if (text.starts_with("modbus-tcp://")) {
      return tcp_connection(text.substr(13), kTcpDialKeys);
    }
    if (text.starts_with("modbus-rtu:")) return rtu_connection(text.substr(11));
    const std::string_view scheme = scheme_of(text);
    refuse(
        "unknown scheme '{}'; did you mean '{}'? (known: serial:DEVICE, "
        "modbus-tcp://HOST:PORT, modbus-rtu:DEVICE)",
        scheme, nearest(scheme, kSchemes));
  } catch (const Refused& refused) {
    return tl::unexpected(context(text, refused));
  }
}

tl::expected<RobotConnection, std::string> parse_robot_connection(std::string_view text) {
  static constexpr std::array<std::string_view, 2> kSchemes{"modbus-tcp", "manual"};
  static constexpr std::array<std::string_view, 3> kKeys{"unit", "timeout_ms", "quiet_ms"};
  try {
    if (text == "manual") return ManualConnection{};
    if (text.empty()) refuse("it is empty; give modbus-tcp://HOST:PORT or manual");
    if (text.starts_with("modbus-tcp://")) return tcp_connection(text.substr(13), kKeys);
    const std::string_view scheme = scheme_of(text);
    refuse(
        "unknown scheme '{}'; did you mean '{}'? (known for the robot: "
        "modbus-tcp://HOST:PORT, manual)",
        scheme, nearest(scheme, kSchemes));
  } catch (const Refused& refused) {
    return tl::unexpected(context(text, refused));
  }
}

std::string name_of(const ModbusEndpoint& endpoint) {
  if (const auto* tcp = std::get_if<ModbusTcpEndpoint>(&endpoint)) {
    return fmt::format("{}:{}", tcp->host, tcp->port);
  }
  return std::get<ModbusRtuEndpoint>(endpoint).device;
}

}  // namespace sixdial::acquisition
