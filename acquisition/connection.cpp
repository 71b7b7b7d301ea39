#include "acquisition/connection.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <array>
#include <span>
#include <vector>

#include "acquisition/connection_text.h"

namespace sixdial::acquisition {
namespace {

std::chrono::milliseconds timeout_of(const ConnectionOptions& options) {
  return std::chrono::milliseconds(options.whole("timeout_ms", 300, 20, 300));
}

constexpr std::array<std::pair<std::string_view, Parity>, 3> kParities{
    {{"N", Parity::kNone}, {"E", Parity::kEven}, {"O", Parity::kOdd}}};

SerialConnection serial_connection(std::string_view rest) {
  static constexpr std::array<std::string_view, 3> kKeys{"dialect", "channel", "timeout_ms"};
  const ConnectionPieces pieces = split(rest);
  const std::string device = device_path(pieces.place);
  const ConnectionOptions options(pieces.query, kKeys);
  std::vector<std::string_view> dialects;
  for (const DialProtocol* protocol : dial_protocols()) dialects.push_back(protocol->name);
  if (!options.has("dialect")) {
    refuse("no dialect is given; add ?dialect= one of {}", fmt::join(dialects, ", "));
  }
  SerialConnection result;
  result.device = device;
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

ModbusMap modbus_map(const ConnectionOptions& options, int most_units) {
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

ModbusConnection rtu_connection(std::string_view rest) {
  std::vector<std::string_view> keys(kTcpDialKeys.begin(), kTcpDialKeys.end());
  keys.insert(keys.end(), {"baud", "parity", "stop_bits"});
  const ConnectionPieces pieces = split(rest);
  const std::string device = device_path(pieces.place);
  const ConnectionOptions options(pieces.query, keys);
  ModbusRtuEndpoint endpoint;
  endpoint.device = device;
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

}  // namespace

ModbusConnection tcp_connection(std::string_view rest, std::span<const std::string_view> keys) {
  const ConnectionPieces pieces = split(rest);
  const ConnectionOptions options(pieces.query, keys);
  ModbusConnection result;
  result.endpoint = tcp_endpoint(pieces.place);
  result.map = modbus_map(options, 255);
  if (options.has("index")) result.index = options.whole("index", 0, 0, 59);
  result.timeout = timeout_of(options);
  result.quiet = std::chrono::milliseconds(options.whole("quiet_ms", 1000, 0, 10000));
  return result;
}

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
    return tl::unexpected(refused_connection(text, refused));
  }
}

std::string name_of(const ModbusEndpoint& endpoint) {
  if (const auto* tcp = std::get_if<ModbusTcpEndpoint>(&endpoint)) {
    return fmt::format("{}:{}", tcp->host, tcp->port);
  }
  return std::get<ModbusRtuEndpoint>(endpoint).device;
}

}  // namespace sixdial::acquisition
