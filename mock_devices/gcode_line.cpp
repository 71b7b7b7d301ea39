#include "mock_devices/gcode_line.h"

#include <arpa/inet.h>
#include <fcntl.h>
#include <fmt/format.h>
#include <netinet/in.h>
#include <netinet/tcp.h>
#include <poll.h>
#include <sys/socket.h>
#include <termios.h>
#include <unistd.h>

#include <array>
#include <atomic>
#include <cerrno>
#include <chrono>
#include <cstdlib>
#include <mutex>
#include <system_error>
#include <thread>

namespace sixdial::mock_devices {
namespace {

using Clock = std::chrono::steady_clock;

constexpr int kSlice_ms = 5;

[[noreturn]] void fail(const std::string& what) {
  throw std::system_error(errno, std::generic_category(), what);
}

int listener(const std::string& address, std::uint16_t& port) {
  const int fd = ::socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC | SOCK_NONBLOCK, 0);
  if (fd < 0) fail("socket");
  const int on = 1;
  ::setsockopt(fd, SOL_SOCKET, SO_REUSEADDR, &on, sizeof on);
  sockaddr_in where{};
  where.sin_family = AF_INET;
  where.sin_port = htons(port);
  ::inet_pton(AF_INET, address.c_str(), &where.sin_addr);
  socklen_t size = sizeof where;
  if (::bind(fd, reinterpret_cast<const sockaddr*>(&where), size) != 0 ||
      ::listen(fd, 8) != 0 ||
      ::getsockname(fd, reinterpret_cast<sockaddr*>(&where), &size) != 0) {
    const int why = errno;
    ::close(fd);
    errno = why;
    fail(fmt::format("cannot listen on {}:{}", address, port));
  }
  port = ntohs(where.sin_port);
  return fd;
}

}  // namespace

class GcodeLineServer::Loop {
 public:
  Loop(const GcodeMachine& machine, const GcodeLineOptions& options)
      : speed_(options.speed), link_(options.pty_link), port_(options.port), machine_(machine) {
    listener_ = listener(options.address, port_);
    if (!link_.empty()) open_pty();
    thread_ = std::jthread([this](const std::stop_token& stop) { run(stop); });
  }
  ~Loop() {
    thread_.request_stop();
    thread_.join();
    drop_clients();
    for (const int fd : {listener_, master_, slave_}) {
      if (fd >= 0) ::close(fd);
    }
    std::error_code ignored;
    if (!link_.empty()) std::filesystem::remove(link_, ignored);
  }

  [[nodiscard]] std::uint16_t port() const { return port_; }
  [[nodiscard]] double now_s() const {
    return speed_ * std::chrono::duration<double>(Clock::now() - began_).count();
  }
  void with(const std::function<void(GcodeController&, double)>& change) {
    const std::lock_guard lock(mutex_);
    change(machine_, now_s());
  }
  void hang_up() { hang_up_ = true; }

 private:
  void open_pty() {
    master_ = ::posix_openpt(O_RDWR | O_NOCTTY | O_CLOEXEC | O_NONBLOCK);
    if (master_ < 0 || ::grantpt(master_) != 0 || ::unlockpt(master_) != 0) fail("openpt");
    std::array<char, 128> name{};
    if (::ptsname_r(master_, name.data(), name.size()) != 0) fail("ptsname");
    // Kept open, so that a client may come and go.
    slave_ = ::open(name.data(), O_RDWR | O_NOCTTY | O_CLOEXEC);
    if (slave_ < 0) fail(name.data());
    termios raw{};
    ::tcgetattr(slave_, &raw);
    ::cfmakeraw(&raw);
    ::tcsetattr(slave_, TCSANOW, &raw);
    std::error_code ignored;
    std::filesystem::remove(link_, ignored);
    std::filesystem::create_symlink(name.data(), link_);
  }
  void drop_clients() {
    for (const int fd : clients_) ::close(fd);
    clients_.clear();
  }

  /// False: the other side is gone.
  bool read_from(int fd) {
    std::array<char, 1024> bytes{};
    const ssize_t got = ::read(fd, bytes.data(), bytes.size());
    if (got > 0) {
      const std::lock_guard lock(mutex_);
      machine_.receive({bytes.data(), static_cast<std::size_t>(got)}, now_s());
      return true;
    }
    return got < 0 && (errno == EAGAIN || errno == EINTR || fd == master_);
  }

  void run(const std::stop_token& stop) {
    while (!stop.stop_requested()) {
      std::vector<pollfd> polled{{listener_, POLLIN, 0}};
      if (master_ >= 0) polled.push_back({master_, POLLIN, 0});
      for (const int fd : clients_) polled.push_back({fd, POLLIN, 0});
      ::poll(polled.data(), polled.size(), kSlice_ms);
      if (hang_up_.exchange(false)) drop_clients();
      if ((polled[0].revents & POLLIN) != 0) {
        const int fd = ::accept4(listener_, nullptr, nullptr, SOCK_CLOEXEC | SOCK_NONBLOCK);
        const int on = 1;
        if (fd >= 0) {
          ::setsockopt(fd, IPPROTO_TCP, TCP_NODELAY, &on, sizeof on);
          clients_.push_back(fd);
        }
      }
      if (master_ >= 0) (void)read_from(master_);
      std::erase_if(clients_, [&](int fd) {
        if (read_from(fd)) return false;
        ::close(fd);
        return true;
      });
      std::string out;
      {
        const std::lock_guard lock(mutex_);
        out = machine_.due(now_s());
      }
      if (out.empty()) continue;
      // To whoever listens; nobody reading is as on a real line: lost.
      for (const int fd : clients_) {
        [[maybe_unused]] const ssize_t n = ::send(fd, out.data(), out.size(), MSG_NOSIGNAL);
      }
      if (master_ >= 0) {
        [[maybe_unused]] const ssize_t n = ::write(master_, out.data(), out.size());
      }
    }
  }

  const double speed_;
  const std::filesystem::path link_;
  std::uint16_t port_;
  const Clock::time_point began_ = Clock::now();
  std::mutex mutex_;  // of the machine
  GcodeController machine_;
  int listener_ = -1, master_ = -1, slave_ = -1;
  std::vector<int> clients_;
  std::atomic<bool> hang_up_{false};
  std::jthread thread_;
};

GcodeLineServer::GcodeLineServer(const GcodeMachine& machine, const GcodeLineOptions& options)
    : loop_(std::make_unique<Loop>(machine, options)) {}
GcodeLineServer::~GcodeLineServer() = default;
std::uint16_t GcodeLineServer::port() const { return loop_->port(); }

std::vector<double> GcodeLineServer::position() const {
  std::vector<double> at;
  loop_->with([&](GcodeController& machine, double time_s) { at = machine.position(time_s); });
  return at;
}

int GcodeLineServer::moves() const {
  int count = 0;
  loop_->with([&](GcodeController& machine, double) { count = machine.moves(); });
  return count;
}

void GcodeLineServer::with(
    const std::function<void(GcodeController& machine, double time_s)>& change) {
  loop_->with(change);
}
void GcodeLineServer::hang_up() { loop_->hang_up(); }

}  // namespace sixdial::mock_devices
