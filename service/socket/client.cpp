#include "service/socket/client.h"

#include <fmt/format.h>
#include <poll.h>
#include <sys/socket.h>
#include <sys/un.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <system_error>

#include "service/socket/request.h"

namespace sixdial::service {
namespace {

[[noreturn]] void unreachable(const std::string& what, const std::filesystem::path& path) {
  throw Error(ErrorCode::kUnreachable, what, {{"file", path.string()}});
}

}  // namespace

Client::Client(const std::filesystem::path& socket_path) {
  sockaddr_un address{};
  address.sun_family = AF_UNIX;
  const std::string path = socket_path.string();
  if (path.size() >= sizeof(address.sun_path)) {
    throw Error(
        ErrorCode::kUnreachable,
        fmt::format(
            "the socket path {} has {} bytes, {} are possible", path, path.size(),
            sizeof(address.sun_path) - 1),
        {{"file", path}}, "Choose a shorter one with --socket, here and for sixdiald.");
  }
  path.copy(address.sun_path, path.size());
  fd_ = ::socket(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC, 0);
  if (fd_ < 0 ||
      ::connect(fd_, reinterpret_cast<const sockaddr*>(&address), sizeof(address)) != 0) {
    const std::string reason = std::generic_category().message(errno);
    if (fd_ >= 0) ::close(fd_);
    unreachable(fmt::format("no service answers on {}: {}", path, reason), socket_path);
  }
}

Client::~Client() { ::close(fd_); }

Json Client::call(std::string_view method, const Json& params) {
  const std::int64_t id = ++last_id_;
  const std::string line =
      to_line({{"jsonrpc", "2.0"}, {"id", id}, {"method", method}, {"params", params}}) + '\n';
  std::string_view rest = line;
  while (!rest.empty()) {
    const ssize_t sent = ::send(fd_, rest.data(), rest.size(), MSG_NOSIGNAL);
    if (sent > 0) {
      rest.remove_prefix(static_cast<std::size_t>(sent));
    } else if (errno != EINTR) {
      break;  // what the service said before it went may still be read
    }
  }
  for (;;) {
    std::optional<Json> reply = read_line(std::nullopt);
    if (!reply) continue;
    if (reply->contains("method")) {
      events_.push_back(*std::move(reply));
    } else if (reply->contains("error") && ((*reply)["id"] == id || (*reply)["id"].is_null())) {
      throw RemoteError((*reply)["error"]);
    } else if (reply->value("id", Json{}) == id) {
      return (*reply)["result"];
    }
  }
}

std::optional<Json> Client::next_event(std::chrono::milliseconds timeout) {
  const auto end = std::chrono::steady_clock::now() + timeout;
  while (events_.empty()) {
    const auto left = std::chrono::duration_cast<std::chrono::milliseconds>(
        end - std::chrono::steady_clock::now());
    auto line = read_line(std::max(left, std::chrono::milliseconds(0)));
    if (!line) return std::nullopt;
    if (line->contains("method")) events_.push_back(*std::move(line));
  }
  Json event = std::move(events_.front());
  events_.pop_front();
  return event;
}

std::optional<Json> Client::read_line(std::optional<std::chrono::milliseconds> timeout) {
  const auto end =
      std::chrono::steady_clock::now() + timeout.value_or(std::chrono::milliseconds(0));
  for (;;) {
    const std::size_t newline = buffer_.find('\n', searched_);
    if (newline != std::string::npos) {
      const std::string line = buffer_.substr(0, newline);
      buffer_.erase(0, newline + 1);
      searched_ = 0;
      return Json::parse(line);
    }
    searched_ = buffer_.size();
    int wait_ms = 500;  // a signal between the check and the poll is noticed after this
    if (timeout) {
      const auto left = std::chrono::duration_cast<std::chrono::milliseconds>(
          end - std::chrono::steady_clock::now());
      wait_ms = static_cast<int>(std::clamp<std::int64_t>(left.count(), 0, wait_ms));
    }
    pollfd ready{.fd = fd_, .events = POLLIN, .revents = 0};
    const int found = ::poll(&ready, 1, wait_ms);
    if (take_interruption()) throw Interrupted();
    if (found <= 0) {
      if (timeout && std::chrono::steady_clock::now() >= end) return std::nullopt;
      continue;
    }
    std::array<char, 65536> chunk;
    const ssize_t size = ::recv(fd_, chunk.data(), chunk.size(), 0);
    if (size == 0 || (size < 0 && errno != EINTR && errno != EAGAIN)) {
      throw Error(ErrorCode::kUnreachable, "the service ended the connection");
    }
    if (size > 0) buffer_.append(chunk.data(), static_cast<std::size_t>(size));
  }
}

}  // namespace sixdial::service
