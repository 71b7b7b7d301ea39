// A service on a socket of its own, in this process, and a client that talks lines to it.
#pragma once

#include <sys/socket.h>
#include <sys/un.h>
#include <unistd.h>

#include <chrono>
#include <cstdlib>
#include <filesystem>
#include <functional>
#include <memory>
#include <optional>
#include <stdexcept>
#include <string>
#include <thread>
#include <utility>

#include "service/service.h"
#include "service/socket/server.h"

namespace sixdial::testing {

/// How long a test waits for something that must happen: long, for a loaded machine; reached
/// only by a failing test.
#ifdef SIXDIAL_SANITIZED
inline constexpr auto kPatience = std::chrono::seconds(300);
#else
inline constexpr auto kPatience = std::chrono::seconds(60);
#endif

/// A directory that goes away with its owner.
class TempDirectory {
 public:
  TempDirectory() {
    std::string name = (std::filesystem::temp_directory_path() / "sixdial-").string();
    name.append(6, 'X');  // mkdtemp's
    if (::mkdtemp(name.data()) == nullptr) throw std::runtime_error("no temporary directory");
    path_ = name;
  }
  ~TempDirectory() {
    std::error_code ignored;
    std::filesystem::remove_all(path_, ignored);
  }
  TempDirectory(const TempDirectory&) = delete;
  TempDirectory& operator=(const TempDirectory&) = delete;
  [[nodiscard]] const std::filesystem::path& path() const { return path_; }

 private:
  std::filesystem::path path_;
};

/// Plain socket calls, so that nothing of the service's own client is trusted here.
class LineClient {
 public:
  explicit LineClient(const std::filesystem::path& socket_path) {
    fd_ = ::socket(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC, 0);
    sockaddr_un address{};
    address.sun_family = AF_UNIX;
    socket_path.string().copy(address.sun_path, sizeof(address.sun_path) - 1);
    const timeval patience{.tv_sec = kPatience.count(), .tv_usec = 0};
    ::setsockopt(fd_, SOL_SOCKET, SO_RCVTIMEO, &patience, sizeof(patience));
    ::setsockopt(fd_, SOL_SOCKET, SO_SNDTIMEO, &patience, sizeof(patience));
    if (::connect(fd_, reinterpret_cast<sockaddr*>(&address), sizeof(address)) != 0) {
      ::close(fd_);
      throw std::runtime_error("cannot connect to " + socket_path.string());
    }
  }
  ~LineClient() {
    if (fd_ >= 0) ::close(fd_);
  }
  LineClient(const LineClient&) = delete;
  LineClient& operator=(const LineClient&) = delete;
  LineClient(LineClient&& other) noexcept
      : fd_(std::exchange(other.fd_, -1)), buffer_(std::move(other.buffer_)) {}

  /// False if the other end is gone.
  bool send(std::string_view text) {
    while (!text.empty()) {
      const ssize_t sent = ::send(fd_, text.data(), text.size(), MSG_NOSIGNAL);
      if (sent <= 0) return false;
      text.remove_prefix(static_cast<std::size_t>(sent));
    }
    return true;
  }
  void finish_sending() { ::shutdown(fd_, SHUT_WR); }
  /// Something to read is there already, or the other end is gone.
  [[nodiscard]] bool has_answer() const {
    char byte = 0;
    return !buffer_.empty() || ::recv(fd_, &byte, 1, MSG_PEEK | MSG_DONTWAIT) >= 0;
  }

  /// The next line; empty at the end of the connection.
  std::optional<std::string> read_line() {
    for (;;) {
      const std::size_t end = buffer_.find('\n');
      if (end != std::string::npos) {
        std::string line = buffer_.substr(0, end);
        buffer_.erase(0, end + 1);
        return line;
      }
      std::string chunk(65536, '\0');
      const ssize_t size = ::recv(fd_, chunk.data(), chunk.size(), 0);
      if (size <= 0) return std::nullopt;
      buffer_.append(chunk, 0, static_cast<std::size_t>(size));
    }
  }
  Json read() {
    const auto line = read_line();
    if (!line) throw std::runtime_error("the connection ended");
    return Json::parse(*line);
  }
  /// Sends a line and reads one back.
  Json ask(const std::string& line) {
    send(line + "\n");
    return read();
  }
  /// Calls a method and passes over events until its answer comes.
  Json call(const std::string& method, const Json& params = Json::object()) {
    const int id = ++last_id_;
    send(
        Json{{"jsonrpc", "2.0"}, {"id", id}, {"method", method}, {"params", params}}.dump() +
        "\n");
    for (;;) {
      Json reply = read();
      if (reply.value("id", Json{}) == id) return reply;
    }
  }

 private:
  int fd_ = -1;
  int last_id_ = 0;
  std::string buffer_;
};

/// Waits for a condition that another thread brings about.
inline bool eventually(const std::function<bool()>& condition) {
  const auto end = std::chrono::steady_clock::now() + kPatience;
  while (!condition()) {
    if (std::chrono::steady_clock::now() > end) return false;
    std::this_thread::sleep_for(std::chrono::milliseconds(2));
  }
  return true;
}

/// A service and its server in a thread of this process.
class RunningService {
 public:
  explicit RunningService(
      service::ServerOptions options = {}, service::ServiceOptions service_options = {}) {
    options.socket_path = socket_path();
    if (service_options.database.empty()) {
      service_options.database = directory_.path() / "sixdial.db";
    }
    service_ = std::make_unique<service::Service>(std::move(service_options));
    server_ = std::make_unique<service::Server>(*service_, std::move(options));
    thread_ = std::thread([this] { server_->run(); });
  }
  ~RunningService() { stop(); }

  void stop() {
    if (!thread_.joinable()) return;
    server_->stop();
    thread_.join();
  }
  [[nodiscard]] std::filesystem::path socket_path() const { return directory_.path() / "s"; }
  [[nodiscard]] const std::filesystem::path& directory() const { return directory_.path(); }
  [[nodiscard]] LineClient client() const { return LineClient(socket_path()); }
  [[nodiscard]] service::Service& service() { return *service_; }
  [[nodiscard]] service::Server& server() { return *server_; }

 private:
  TempDirectory directory_;
  std::unique_ptr<service::Service> service_;
  std::unique_ptr<service::Server> server_;
  std::thread thread_;
};

/// error.data.code of a reply, or "" where it is no error.
inline std::string error_code_of(const Json& reply) {
  return reply.contains("error") ? reply["error"]["data"]["code"].get<std::string>() : "";
}

}  // namespace sixdial::testing
