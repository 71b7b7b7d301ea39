// The Unix socket: one service for a path (lock file), a stale socket is taken away only when
// nobody answers on it, one handed over by systemd is never touched. 64 clients, each with the
// operator's name from its peer credentials.
#pragma once

#include <atomic>
#include <chrono>
#include <filesystem>
#include <functional>
#include <memory>
#include <set>
#include <string>

#include "service/socket/connection.h"

namespace sixdial::service {

inline constexpr std::size_t kMaxClients = 64;

/// $XDG_RUNTIME_DIR/sixdial/sixdiald.sock, else /run/sixdial/sixdiald.sock.
[[nodiscard]] std::filesystem::path default_socket_path();
/// "alice (uid 1000)".
[[nodiscard]] std::string operator_of(unsigned uid);

/// Holds `<socket>.lock` as long as it lives. Throws Error wrong_state if another process does.
class SocketLock {
 public:
  explicit SocketLock(const std::filesystem::path& socket_path);
  ~SocketLock();
  SocketLock(const SocketLock&) = delete;
  SocketLock& operator=(const SocketLock&) = delete;

 private:
  int fd_ = -1;
};

struct ServerOptions {
  std::filesystem::path socket_path{};
  bool take_over_from_systemd = false;  // use LISTEN_FDS where set
  bool handle_signals = false;          // SIGTERM and SIGINT end run()
  std::function<void()> going_down{};   // called once, on run()'s thread, before anything ends
  std::chrono::milliseconds slow_client{10'000};
  int socket_buffer_bytes = 0;  // 0: the system's
};

class Server {
 public:
  /// Binds and listens. Throws Error with what to do: path too long, no such directory, in use.
  Server(Service& service, ServerOptions options);
  ~Server();
  Server(const Server&) = delete;
  Server& operator=(const Server&) = delete;

  /// Serves until stop(): then lets the collection finish its point, ends jobs, sends what is
  /// queued, and returns within a second, or what the options say.
  void run();
  /// From any thread.
  void stop();
  /// From any thread.
  [[nodiscard]] std::size_t clients() const { return clients_; }

 private:
  void open();
  asio::awaitable<void> accept_clients();
  asio::awaitable<void> shut_down();
  void welcome(LocalSocket socket);
  void begin_shut_down();

  Service& service_;
  const ServerOptions options_;
  asio::io_context loop_{1};
  asio::thread_pool workers_{2};
  asio::thread_pool file_workers_{4};     // for methods that touch files outside of the store
  asio::thread_pool reading_workers_{2};  // for methods that look at a whole session
  asio::thread_pool long_workers_{3};     // for methods that may take minutes
  asio::steady_timer changed_;
  asio::local::stream_protocol::acceptor acceptor_;
  asio::signal_set signals_;
  std::unique_ptr<SocketLock> lock_;
  bool ours_ = false;  // the socket file is ours to unlink
  bool shutting_down_ = false;
  ConnectionHost host_;
  std::set<std::shared_ptr<Connection>> connections_;
  std::atomic<std::size_t> clients_{0};  // as connections_, for other threads
};

}  // namespace sixdial::service
