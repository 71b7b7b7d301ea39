// The other end of the socket: asks a service, one line out and one line back, and takes
// events.
//
// Example:
//   Client client(socket_path);
//   client.call("session.create", {{"name", "monday"}, {"rig_toml", rig_text}});
//   client.call("session.list")["sessions"].size();  // -> 1U
#pragma once

#include <chrono>
#include <cstdint>
#include <deque>
#include <filesystem>
#include <optional>
#include <string>
#include <string_view>

#include "service/error.h"
#include "service/socket/interruption.h"

namespace sixdial::service {

class Client {
 public:
  /// Throws Error unreachable.
  explicit Client(const std::filesystem::path& socket_path);
  ~Client();
  Client(const Client&) = delete;
  Client& operator=(const Client&) = delete;

  /// The result. Throws RemoteError for an error answer, Error unreachable if the connection
  /// ends, Interrupted. Events that come meanwhile are kept for next_event.
  Json call(std::string_view method, const Json& params = Json::object());
  /// The next notification (events.event or events.gap); empty when the time is over.
  std::optional<Json> next_event(std::chrono::milliseconds timeout);

 private:
  std::optional<Json> read_line(std::optional<std::chrono::milliseconds> timeout);
  int fd_ = -1;
  std::int64_t last_id_ = 0;
  std::string buffer_;
  std::size_t searched_ = 0;
  std::deque<Json> events_;
};

}  // namespace sixdial::service
