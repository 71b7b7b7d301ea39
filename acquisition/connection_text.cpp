#include "acquisition/connection_text.h"

#include <algorithm>
#include <charconv>
#include <cmath>

#include "session/nearest.h"

namespace sixdial::acquisition {

std::string refused_connection(std::string_view text, const Refused& refused) {
  return fmt::format("connection '{}': {}", text, refused.why);
}

std::string_view scheme_of(std::string_view text) { return text.substr(0, text.find(':')); }

std::string_view nearest(std::string_view word, std::span<const std::string_view> known) {
  return *std::min_element(known.begin(), known.end(), [&](auto a, auto b) {
    return session::edit_distance(word, a) < session::edit_distance(word, b);
  });
}

ConnectionPieces split(std::string_view text) {
  const std::size_t mark = text.find('?');
  if (mark == std::string_view::npos) return {text, {}};
  return {text.substr(0, mark), text.substr(mark + 1)};
}

std::string_view without_slashes(std::string_view place) {
  if (place.starts_with("//")) place.remove_prefix(2);
  return place;
}

ModbusTcpEndpoint tcp_endpoint(std::string_view place, int usual_port) {
  ModbusTcpEndpoint endpoint{.host = {}, .port = usual_port};
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

std::string device_path(std::string_view place) {
  if (!place.starts_with('/')) {
    refuse("'{}' is not a device path such as /dev/serial/by-id/...", place);
  }
  return std::string(place);
}

ConnectionOptions::ConnectionOptions(
    std::string_view query, std::span<const std::string_view> known) {
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

std::string ConnectionOptions::text(const std::string& key, std::string_view otherwise) const {
  const auto found = values_.find(key);
  return found == values_.end() ? std::string(otherwise) : found->second;
}

int ConnectionOptions::whole(const std::string& key, int otherwise, int least, int most) const {
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

int ConnectionOptions::address(const std::string& key, int otherwise) const {
  return text(key, "") == "none" ? -1 : whole(key, otherwise, 0, 65535);
}

double ConnectionOptions::number(const std::string& key, double otherwise) const {
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

}  // namespace sixdial::acquisition
