#include "service/socket/server.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <pwd.h>
#include <spdlog/spdlog.h>
#include <sys/file.h>
#include <sys/socket.h>
#include <sys/stat.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <cstdlib>
#include <system_error>
#include <thread>

#include "service/service.h"
#include "service/socket/request.h"

namespace sixdial::service {
namespace {

using asio::use_awaitable;
using Acceptor = asio::local::stream_protocol::acceptor;

constexpr auto kDrainFor = std::chrono::milliseconds(1000);
constexpr int kFirstHandedOverSocket = 3;        // sd_listen_fds(3)
constexpr std::size_t kLongestSocketPath = 107;  // sun_path of Linux

std::string reason(int error_number) { return std::generic_category().message(error_number); }

bool handed_over_by_systemd() {
  const char* pid = std::getenv("LISTEN_PID");
  const char* count = std::getenv("LISTEN_FDS");
  return pid != nullptr && count != nullptr && std::atol(pid) == getpid() &&
         std::atoi(count) >= 1;
}

bool somebody_answers(const std::filesystem::path& path) {
  asio::io_context loop;
  LocalSocket probe(loop);
  boost::system::error_code trouble;
  probe.connect(asio::local::stream_protocol::endpoint(path.string()), trouble);
  return !trouble;
}

/// A user's own directory: 0600. The system's: the group may talk, 0660.
mode_t socket_mode(const std::filesystem::path& path) {
  return path.string().starts_with("/run/sixdial/") ? 0660 : 0600;
}

void remove_stale(const std::filesystem::path& path) {
  struct stat about {};
  if (::lstat(path.c_str(), &about) != 0) return;
  if (!S_ISSOCK(about.st_mode)) {
    throw Error(
        ErrorCode::kAlreadyExists, fmt::format("{} is there and is no socket", path.string()),
        {{"file", path.string()}}, "Move it away, or choose another path with --socket.");
  }
  if (somebody_answers(path)) {
    throw Error(
        ErrorCode::kWrongState, fmt::format("another service answers on {}", path.string()),
        {{"file", path.string()}}, "Stop it first, or choose another path with --socket.");
  }
  spdlog::info("taking away the stale socket {}", path.string());
  ::unlink(path.c_str());
}

}  // namespace

std::filesystem::path default_socket_path() {
  const char* runtime = std::getenv("XDG_RUNTIME_DIR");
  const std::filesystem::path base = runtime != nullptr && *runtime != '\0' ? runtime : "/run";
  return base / "sixdial" / "sixdiald.sock";
}

std::string operator_of(unsigned uid) {
  std::array<char, 4096> buffer{};
  passwd entry{};
  passwd* found = nullptr;
  if (getpwuid_r(uid, &entry, buffer.data(), buffer.size(), &found) == 0 && found != nullptr) {
    return fmt::format("{} (uid {})", found->pw_name, uid);
  }
  return fmt::format("uid {}", uid);
}

SocketLock::SocketLock(const std::filesystem::path& socket_path) {
  const std::string path = socket_path.string() + ".lock";
  fd_ = ::open(path.c_str(), O_RDWR | O_CREAT | O_CLOEXEC, 0600);
  if (fd_ < 0) {
    throw Error(
        ErrorCode::kFile, fmt::format("cannot open {}: {}", path, reason(errno)),
        {{"file", path}}, "The directory must exist and be writable; or use --socket.");
  }
  if (::flock(fd_, LOCK_EX | LOCK_NB) != 0) {
    ::close(fd_);
    throw Error(
        ErrorCode::kWrongState, fmt::format("another service runs on {}", socket_path.string()),
        {{"file", path}}, "Stop it first, or choose another path with --socket.");
  }
}

SocketLock::~SocketLock() { ::close(fd_); }  // the file stays: removing it would race

Server::Server(Service& service, ServerOptions options)
    : service_(service),
      options_(std::move(options)),
      changed_(loop_),
      acceptor_(loop_),
      signals_(loop_),
      host_{
          .service = service_,
          .workers = workers_,
          .file_workers = file_workers_,
          .reading_workers = reading_workers_,
          .long_workers = long_workers_,
          .changed = changed_,
          .slow_client = options_.slow_client,
          .ended = [this](Connection& connection) {
            connections_.erase(connection.shared_from_this());
            clients_ = connections_.size();
            changed_.cancel();
          }} {
  changed_.expires_at(asio::steady_timer::time_point::max());
  open();
}

Server::~Server() {
  service_.set_listeners({}, {}, {});
  if (ours_) ::unlink(options_.socket_path.c_str());
}

void Server::open() {
  if (options_.take_over_from_systemd && handed_over_by_systemd()) {
    acceptor_.assign(asio::local::stream_protocol(), kFirstHandedOverSocket);
    spdlog::info("listening on the socket that systemd handed over");
    return;
  }
  const std::string path = options_.socket_path.string();
  if (path.size() > kLongestSocketPath) {
    throw Error(
        ErrorCode::kFile,
        fmt::format(
            "the socket path has {} bytes, {} are possible: {}", path.size(),
            kLongestSocketPath, path),
        {{"file", path}}, "Choose a shorter one with --socket.");
  }
  std::error_code ignored;  // a failure shows when the lock is opened
  std::filesystem::create_directory(options_.socket_path.parent_path(), ignored);
  lock_ = std::make_unique<SocketLock>(options_.socket_path);
  remove_stale(options_.socket_path);
  acceptor_.open(asio::local::stream_protocol());
  ::fchmod(acceptor_.native_handle(), socket_mode(options_.socket_path));  // before it is seen
  boost::system::error_code trouble;
  acceptor_.bind(asio::local::stream_protocol::endpoint(path), trouble);
  if (!trouble) ours_ = ::chmod(path.c_str(), socket_mode(options_.socket_path)) == 0;
  if (!trouble) acceptor_.listen(Acceptor::max_listen_connections, trouble);
  if (trouble) {
    throw Error(
        ErrorCode::kFile, fmt::format("cannot listen on {}: {}", path, trouble.message()),
        {{"file", path}});
  }
  spdlog::info("listening on {}", path);
}

void Server::run() {
  service_.set_listeners(
      [this](const EventPtr& event) {
        asio::post(loop_, [this, event] {
          for (const auto& connection : connections_) connection->deliver(event);
        });
      },
      [this] { asio::post(loop_, [this] { changed_.cancel(); }); }, [this] { stop(); });
  if (options_.handle_signals) {
    signals_.add(SIGTERM);
    signals_.add(SIGINT);
    signals_.async_wait([this](const boost::system::error_code& error, int number) {
      if (error) return;
      spdlog::info("signal {}: going down", number);
      begin_shut_down();
    });
  }
  asio::co_spawn(loop_, accept_clients(), asio::detached);
  loop_.run();
  workers_.join();
  file_workers_.join();
  reading_workers_.join();
  long_workers_.join();
  service_.set_listeners({}, {}, {});
}

void Server::stop() {
  asio::post(loop_, [this] { begin_shut_down(); });
}

void Server::begin_shut_down() {
  if (std::exchange(shutting_down_, true)) return;
  if (options_.going_down) options_.going_down();
  asio::co_spawn(loop_, shut_down(), asio::detached);
}

asio::awaitable<void> Server::accept_clients() {
  while (acceptor_.is_open()) {
    boost::system::error_code trouble;
    LocalSocket socket =
        co_await acceptor_.async_accept(asio::redirect_error(use_awaitable, trouble));
    if (!trouble) {
      welcome(std::move(socket));
    } else if (trouble != asio::error::operation_aborted) {
      // Out of descriptors, say: the clients there are go on; a pause keeps the loop free.
      spdlog::warn("a client could not be accepted: {}", trouble.message());
      asio::steady_timer pause(loop_, std::chrono::milliseconds(100));
      co_await pause.async_wait(use_awaitable);
    }
  }
}

void Server::welcome(LocalSocket socket) {
  boost::system::error_code ignored;
  if (connections_.size() >= kMaxClients) {
    socket.non_blocking(true, ignored);
    const std::string line =
        to_line(error_reply(
            nullptr, to_error_object(std::make_exception_ptr(Error(
                         ErrorCode::kTooManyClients,
                         fmt::format("{} clients are connected", connections_.size())))))) +
        '\n';
    socket.write_some(asio::buffer(line), ignored);
    return;
  }
  if (options_.socket_buffer_bytes > 0) {
    socket.set_option(
        asio::socket_base::send_buffer_size(options_.socket_buffer_bytes), ignored);
  }
  ucred peer{};
  socklen_t size = sizeof(peer);
  Caller caller;
  if (::getsockopt(socket.native_handle(), SOL_SOCKET, SO_PEERCRED, &peer, &size) == 0) {
    caller = {
        .operator_name = operator_of(peer.uid),
        .uid = static_cast<int>(peer.uid),
        .pid = peer.pid};
  }
  const auto connection =
      std::make_shared<Connection>(std::move(socket), std::move(caller), host_);
  connections_.insert(connection);
  clients_ = connections_.size();
  connection->start();
}

asio::awaitable<void> Server::shut_down() {
  boost::system::error_code ignored;
  acceptor_.close(ignored);
  signals_.cancel(ignored);
  // On a worker: it waits for the point in hand and for the jobs.
  co_await asio::co_spawn(
      workers_, [this]() -> asio::awaitable<void> { co_return service_.stop(); },
      use_awaitable);
  changed_.cancel();  // waiting requests answer now
  asio::steady_timer turn(loop_, std::chrono::milliseconds(0));
  co_await turn.async_wait(use_awaitable);
  for (const auto& connection : connections_) connection->finish();
  asio::steady_timer over(loop_, kDrainFor);
  over.async_wait([this](const boost::system::error_code& error) {
    if (!error) changed_.cancel();
  });
  const auto end = std::chrono::steady_clock::now() + kDrainFor;
  while (!connections_.empty() && std::chrono::steady_clock::now() < end) {
    co_await changed_.async_wait(asio::redirect_error(use_awaitable, ignored));
  }
  for (const auto& connection : std::set(connections_)) connection->close();
}

}  // namespace sixdial::service
