#include "acquisition/line_channel.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <netdb.h>
#include <netinet/in.h>
#include <netinet/tcp.h>
#include <poll.h>
#include <sys/socket.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstring>
#include <utility>

#include "acquisition/serial_port.h"

namespace sixdial::acquisition {
namespace {

using std::chrono::milliseconds;
using std::chrono::nanoseconds;
using std::chrono::steady_clock;

constexpr milliseconds kSlice{50};  // a stop is seen within this

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
  tl::expected<std::string, Fault> read_line(
      steady_clock::time_point deadline, const std::stop_token& stop) final {
    for (;;) {
      if (const std::size_t end = pending_.find('\n'); end != std::string::npos) {
        std::string line = pending_.substr(0, end);
        pending_.erase(0, end + 1);
        return without_end(std::move(line));
      }
      if (pending_.size() > kLongestLine) {
        const std::size_t size = pending_.size();
        pending_.clear();
        return tl::unexpected(
            Fault{FaultKind::kBadFrame, fmt::format("{} bytes without an end of line", size)});
      }
      if (stop.stop_requested() || steady_clock::now() >= deadline) {
        return tl::unexpected(Fault{
            FaultKind::kTimeout,
            pending_.empty() ? "no answer"
                             : fmt::format("{} has no end of line", printable(pending_))});
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

class TcpLines final : public CutLines {
 public:
  explicit TcpLines(Socket socket) : socket_(std::move(socket)) {}

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
    if (socket.get() >= 0) return std::make_unique<TcpLines>(std::move(socket));
    why = errno;
  }
  return tl::unexpected(disconnected(fmt::format("{}: {}", place, std::strerror(why))));
}

tl::expected<std::unique_ptr<LineChannel>, Fault> open_serial_lines(
    const std::string& device, const LineSettings& line) {
  auto port = SerialPort::open(device, line);
  if (!port) return tl::unexpected(Fault(port.error()));
  return std::make_unique<SerialLines>(std::move(*port));
}

}  // namespace sixdial::acquisition
