#include "acquisition/line_channel.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <netdb.h>
#include <netinet/in.h>
#include <netinet/tcp.h>
#include <poll.h>
#include <sys/socket.h>
#include <sys/un.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstring>
#include <thread>
#include <utility>

#include "acquisition/serial_port.h"

namespace sixdial::acquisition {
namespace {

using std::chrono::milliseconds;
using std::chrono::nanoseconds;
using std::chrono::steady_clock;

constexpr milliseconds kSlice{50};  // a stop is seen within this
constexpr std::size_t kMostShown = 80;

std::string without_end(std::string line) {
  while (!line.empty() && (line.back() == '\n' || line.back() == '\r' || line.back() == ' ')) {
    line.pop_back();
  }
  return line;
}

Fault disconnected(std::string detail) { return {FaultKind::kDisconnected, std::move(detail)}; }

/// Cuts what comes into lines, and keeps what is not whole yet.
class CutLines : public LineChannel {
 public:
  explicit CutLines(char end = '\n', std::size_t longest = kLongestLine)
      : end_(end), longest_(longest) {}
  tl::expected<std::string, Fault> read_line(
      steady_clock::time_point deadline, const std::stop_token& stop) final {
    for (;;) {
      if (const std::size_t end = pending_.find(end_); end != std::string::npos) {
        std::string line = pending_.substr(0, end);
        pending_.erase(0, end + 1);
        return without_end(std::move(line));
      }
      if (pending_.size() > longest_) {
        const std::size_t size = pending_.size();
        pending_.clear();
        return tl::unexpected(Fault{
            FaultKind::kBadFrame,
            fmt::format("{} bytes without an end {}", size, what_ends())});
      }
      if (stop.stop_requested() || steady_clock::now() >= deadline) {
        return tl::unexpected(Fault{
            FaultKind::kTimeout,
            pending_.empty()
                ? "no answer"
                : fmt::format("{} has no end {}", printable(shown(pending_)), what_ends())});
      }
      auto more = read_some(deadline, stop);
      if (!more) return tl::unexpected(more.error());
      pending_ += *more;
    }
  }

 private:
  /// Empty: nothing came in a while, the deadline at the latest.
  virtual tl::expected<std::string, Fault> read_some(
      steady_clock::time_point deadline, const std::stop_token& stop) = 0;

  [[nodiscard]] const char* what_ends() const {
    return end_ == '\n' ? "of line" : "of message";
  }
  /// The beginning: evidence, not the whole of a long message.
  [[nodiscard]] static std::string_view shown(std::string_view text) {
    return text.substr(0, kMostShown);
  }

  const char end_;
  const std::size_t longest_;
  std::string pending_;
};

class SerialLines final : public CutLines {
 public:
  explicit SerialLines(SerialPort port) : port_(std::move(port)) {}
  tl::expected<void, Fault> write(std::string_view bytes, nanoseconds timeout) override {
    return port_.write(bytes, timeout);
  }

 private:
  tl::expected<std::string, Fault> read_some(
      steady_clock::time_point deadline, const std::stop_token& stop) override {
    return port_.read_some(deadline, stop);
  }

  SerialPort port_;
};

/// An open socket.
class Socket {
 public:
  explicit Socket(int fd = -1) : fd_(fd) {}
  ~Socket() {
    if (fd_ >= 0) ::close(fd_);
  }
  Socket(Socket&& other) noexcept : fd_(std::exchange(other.fd_, -1)) {}
  Socket& operator=(Socket&& other) noexcept {
    std::swap(fd_, other.fd_);
    return *this;
  }
  [[nodiscard]] int get() const { return fd_; }

 private:
  int fd_;
};

/// What came of waiting: the events, 0 after the deadline.
short wait_for(int fd, short events, steady_clock::time_point deadline) {
  for (;;) {
    const auto left = std::chrono::ceil<milliseconds>(deadline - steady_clock::now());
    pollfd watched{.fd = fd, .events = events, .revents = 0};
    const int ready =
        ::poll(&watched, 1, static_cast<int>(std::max(left, milliseconds{0}).count()));
    if (ready > 0) return watched.revents;
    if (ready == 0 || errno != EINTR) return 0;
  }
}

class SocketLines final : public CutLines {
 public:
  explicit SocketLines(Socket socket) : socket_(std::move(socket)) {}
  SocketLines(Socket socket, char end, std::size_t longest)
      : CutLines(end, longest), socket_(std::move(socket)) {}

  tl::expected<void, Fault> write(std::string_view bytes, nanoseconds timeout) override {
    const auto deadline = steady_clock::now() + timeout;
    while (!bytes.empty()) {
      const ssize_t sent = ::send(socket_.get(), bytes.data(), bytes.size(), MSG_NOSIGNAL);
      if (sent > 0) {
        bytes.remove_prefix(static_cast<std::size_t>(sent));
        continue;
      }
      if (errno == EINTR) continue;
      if (errno != EAGAIN) return tl::unexpected(disconnected(std::strerror(errno)));
      if (wait_for(socket_.get(), POLLOUT, deadline) == 0) {
        return tl::unexpected(Fault{FaultKind::kTimeout, "the line takes no bytes"});
      }
    }
    return {};
  }

 private:
  tl::expected<std::string, Fault> read_some(
      steady_clock::time_point deadline, const std::stop_token& /*stop*/) override {
    if (wait_for(socket_.get(), POLLIN, std::min(deadline, steady_clock::now() + kSlice)) ==
        0) {
      return std::string();
    }
    std::array<char, 512> bytes{};
    const ssize_t got = ::recv(socket_.get(), bytes.data(), bytes.size(), 0);
    if (got > 0) return std::string(bytes.data(), static_cast<std::size_t>(got));
    if (got == 0) {
      return tl::unexpected(disconnected("the other side closed the connection"));
    }
    if (errno == EAGAIN || errno == EINTR) return std::string();
    return tl::unexpected(disconnected(std::strerror(errno)));
  }

  Socket socket_;
};

/// A Unix socket cannot be opened: what to do.
std::string why_not(int error) {
  const std::string words = std::strerror(error);
  switch (error) {
    case ENOENT:
      return words +
             "; start its program, and give the path that this one gives it (a service "
             "with PrivateTmp= has a /tmp of its own)";
    case ECONNREFUSED:
      return words + "; its program has ended: start it";
    case EACCES:
      return words + "; let this user write to the socket, e.g. by its group";
    default:
      return words;
  }
}

/// One address of the host; empty: it does not answer, errno says why.
Socket connected(const addrinfo& to, steady_clock::time_point deadline) {
  Socket socket(
      ::socket(to.ai_family, SOCK_STREAM | SOCK_CLOEXEC | SOCK_NONBLOCK, to.ai_protocol));
  if (socket.get() < 0) return socket;
  const int on = 1;
  ::setsockopt(socket.get(), IPPROTO_TCP, TCP_NODELAY, &on, sizeof on);
  ::setsockopt(socket.get(), SOL_SOCKET, SO_KEEPALIVE, &on, sizeof on);
  if (::connect(socket.get(), to.ai_addr, to.ai_addrlen) == 0) return socket;
  if (errno != EINPROGRESS) return Socket();
  if (wait_for(socket.get(), POLLOUT, deadline) == 0) {
    errno = ETIMEDOUT;
    return Socket();
  }
  int error = 0;
  socklen_t size = sizeof error;
  ::getsockopt(socket.get(), SOL_SOCKET, SO_ERROR, &error, &size);
  if (error == 0) return socket;
  errno = error;
  return Socket();
}

}  // namespace

tl::expected<std::unique_ptr<LineChannel>, Fault> open_tcp_lines(
    const ModbusTcpEndpoint& endpoint, nanoseconds timeout) {
  const auto deadline = steady_clock::now() + timeout;
  const std::string place = name_of(endpoint);
  addrinfo hints{};
  hints.ai_socktype = SOCK_STREAM;
  hints.ai_flags = AI_NUMERICSERV;
  addrinfo* found = nullptr;
  const int trouble = ::getaddrinfo(
      endpoint.host.c_str(), std::to_string(endpoint.port).c_str(), &hints, &found);
  if (trouble != 0) {
    return tl::unexpected(disconnected(fmt::format("{}: {}", place, ::gai_strerror(trouble))));
  }
  const std::unique_ptr<addrinfo, decltype(&::freeaddrinfo)> all(found, &::freeaddrinfo);
  int why = 0;
  for (const addrinfo* each = found; each != nullptr; each = each->ai_next) {
    Socket socket = connected(*each, deadline);
    if (socket.get() >= 0) return std::make_unique<SocketLines>(std::move(socket));
    why = errno;
  }
  return tl::unexpected(disconnected(fmt::format("{}: {}", place, std::strerror(why))));
}

tl::expected<std::unique_ptr<LineChannel>, Fault> open_unix_messages(
    const std::string& path, char end, std::size_t longest, nanoseconds timeout) {
  sockaddr_un where{};
  where.sun_family = AF_UNIX;
  if (path.size() >= sizeof where.sun_path) {
    return tl::unexpected(disconnected(fmt::format(
        "the path has {} bytes, a socket's has at most {}", path.size(),
        sizeof where.sun_path - 1)));
  }
  path.copy(where.sun_path, path.size());
  Socket socket(::socket(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC | SOCK_NONBLOCK, 0));
  const auto deadline = steady_clock::now() + timeout;
  for (;;) {
    if (socket.get() >= 0 &&
        ::connect(socket.get(), reinterpret_cast<const sockaddr*>(&where), sizeof where) == 0) {
      return std::make_unique<SocketLines>(std::move(socket), end, longest);
    }
    // EAGAIN: its queue of callers is full.
    if (errno != EINTR && (errno != EAGAIN || steady_clock::now() >= deadline)) break;
    std::this_thread::sleep_for(milliseconds{5});
  }
  return tl::unexpected(disconnected(why_not(errno)));
}

tl::expected<std::unique_ptr<LineChannel>, Fault> open_serial_lines(
    const std::string& device, const LineSettings& line) {
  auto port = SerialPort::open(device, line);
  if (!port) return tl::unexpected(Fault(port.error()));
  return std::make_unique<SerialLines>(std::move(*port));
}

}  // namespace sixdial::acquisition
