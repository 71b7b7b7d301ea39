#include "mock_devices/machine_socket.h"

#include <netinet/in.h>
#include <netinet/tcp.h>
#include <poll.h>
#include <sys/socket.h>
#include <unistd.h>

#include <array>
#include <atomic>
#include <cerrno>
#include <chrono>
#include <mutex>
#include <optional>
#include <thread>
#include <vector>

#include "mock_devices/ports.h"

namespace sixdial::mock_devices {
namespace {

using Clock = std::chrono::steady_clock;

constexpr int kSlice_ms = 2;

}  // namespace

class MachineSocket::Loop {
 public:
  Loop(SocketMachine& machine, const MachineSocketOptions& options)
      : machine_(machine),
        speed_(options.speed),
        path_(options.unix_socket),
        listener_(path_.empty() ? listen_on(options.address, options.port) : listen_on(path_)) {
    if (!options.pty_link.empty()) {
      terminal_.emplace(options.pty_link);
      machine_.connected(terminal_->descriptor(), now_s());
    }
    thread_ = std::jthread([this](const std::stop_token& stop) { run(stop); });
  }
  ~Loop() {
    thread_.request_stop();
    thread_.join();
    drop_clients();
    if (terminal_) machine_.gone(terminal_->descriptor());
    std::error_code ignored;
    if (!path_.empty()) std::filesystem::remove(path_, ignored);
  }

  [[nodiscard]] std::uint16_t port() const { return listener_.port; }
  void with(const std::function<void(double)>& change) {
    const std::lock_guard lock(mutex_);
    change(now_s());
  }
  void hang_up() { hang_up_ = true; }
  void fall_silent(bool silent) { silent_ = silent; }
  void cut_next(std::size_t bytes) { cut_ = static_cast<int>(bytes); }
  [[nodiscard]] int connections() const { return connections_; }

 private:
  [[nodiscard]] double now_s() const {
    return speed_ * std::chrono::duration<double>(Clock::now() - began_).count();
  }
  void drop(int fd) {
    ::close(fd);
    const std::lock_guard lock(mutex_);
    machine_.gone(fd);
  }
  void drop_clients() {
    for (const int fd : clients_) drop(fd);
    clients_.clear();
  }
  void take_client() {
    const int fd =
        ::accept4(listener_.fd.get(), nullptr, nullptr, SOCK_CLOEXEC | SOCK_NONBLOCK);
    if (fd < 0) return;
    const int on = 1;
    if (path_.empty()) ::setsockopt(fd, IPPROTO_TCP, TCP_NODELAY, &on, sizeof on);
    const std::lock_guard lock(mutex_);
    machine_.connected(fd, now_s());
    clients_.push_back(fd);
    ++connections_;
  }
  /// False: the connection is to be closed.
  bool serve(int fd) {
    std::array<char, 4096> bytes{};
    const ssize_t got = ::read(fd, bytes.data(), bytes.size());
    if (got == 0 || (got < 0 && errno != EAGAIN && errno != EINTR)) return false;
    std::string out;
    bool closes = false;
    {
      const std::lock_guard lock(mutex_);
      if (got > 0 && !silent_) {
        machine_.receive(fd, {bytes.data(), static_cast<std::size_t>(got)}, now_s());
      }
      out = machine_.due(fd, now_s());
      closes = machine_.hangs_up(fd);
    }
    if (silent_) out.clear();
    if (!out.empty()) {
      if (const int cut = cut_.exchange(-1); cut >= 0)
        out.resize(static_cast<std::size_t>(cut));
      // To whoever reads; a line that is full loses it.
      const bool on_line = terminal_ && fd == terminal_->descriptor();
      [[maybe_unused]] const ssize_t n = on_line
                                             ? ::write(fd, out.data(), out.size())
                                             : ::send(fd, out.data(), out.size(), MSG_NOSIGNAL);
    }
    return !closes;
  }
  void run(const std::stop_token& stop) {
    while (!stop.stop_requested()) {
      std::vector<pollfd> polled{{listener_.fd.get(), POLLIN, 0}};
      if (terminal_) polled.push_back({terminal_->descriptor(), POLLIN, 0});
      for (const int fd : clients_) polled.push_back({fd, POLLIN, 0});
      ::poll(polled.data(), polled.size(), kSlice_ms);
      if (hang_up_.exchange(false)) drop_clients();
      if ((polled[0].revents & POLLIN) != 0) take_client();
      std::erase_if(clients_, [&](int fd) {
        if (serve(fd)) return false;
        drop(fd);
        return true;
      });
      if (terminal_) (void)serve(terminal_->descriptor());
    }
  }

  SocketMachine& machine_;
  const double speed_;
  const std::filesystem::path path_;
  const Listener listener_;
  std::optional<PseudoTerminal> terminal_;
  const Clock::time_point began_ = Clock::now();
  std::mutex mutex_;  // of the machine
  std::vector<int> clients_;
  std::atomic<bool> hang_up_{false};
  std::atomic<bool> silent_{false};
  std::atomic<int> cut_{-1};
  std::atomic<int> connections_{0};
  std::jthread thread_;
};

MachineSocket::MachineSocket(SocketMachine& machine, const MachineSocketOptions& options)
    : loop_(std::make_unique<Loop>(machine, options)) {}
MachineSocket::~MachineSocket() = default;
std::uint16_t MachineSocket::port() const { return loop_->port(); }
void MachineSocket::with(const std::function<void(double time_s)>& change) {
  loop_->with(change);
}
void MachineSocket::hang_up() { loop_->hang_up(); }
void MachineSocket::fall_silent(bool silent) { loop_->fall_silent(silent); }
void MachineSocket::cut_next(std::size_t bytes) { loop_->cut_next(bytes); }
int MachineSocket::connections() const { return loop_->connections(); }

}  // namespace sixdial::mock_devices
