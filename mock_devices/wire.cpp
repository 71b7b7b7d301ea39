#include "mock_devices/wire.h"

#include <fmt/format.h>
#include <netinet/in.h>
#include <netinet/tcp.h>
#include <poll.h>
#include <sys/eventfd.h>
#include <sys/socket.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <cerrno>
#include <deque>
#include <list>
#include <stdexcept>
#include <system_error>
#include <thread>

#include "mock_devices/dials/modbus_rtu.h"
#include "mock_devices/modbus_slave.h"
#include "mock_devices/ports.h"
#include "mock_devices/serial_line.h"

namespace sixdial::mock_devices {
namespace {

using Clock = std::chrono::steady_clock;

constexpr double kLate_s = 1.0;
constexpr double kHungUp_s = 0.5;
constexpr std::size_t kCut = 4;
constexpr std::size_t kMostWaiting = 1 << 16;  // bytes that a client may leave unread
constexpr std::uint8_t kAnyUnit = 255;         // libmodbus's default on TCP

Clock::duration wall(double seconds) {
  return std::chrono::duration_cast<Clock::duration>(std::chrono::duration<double>(seconds));
}

struct Client {
  struct Out {
    Clock::time_point due;
    Bytes bytes;
    std::size_t sent = 0;
  };
  Descriptor fd;
  bool robot;
  Bytes in;
  std::deque<Out> out;
  bool gone = false;
  bool blocked = false;  // its side is full
};

}  // namespace

class Wire::Loop {
 public:
  Loop(Bench& bench, const WireOptions& options)
      : bench_(bench),
        options_(options),
        wake_(::eventfd(0, EFD_CLOEXEC | EFD_NONBLOCK)),
        dials_(listen_on(options.address, options.dial_port)),
        robot_(listen_on(options.address, options.robot_port)),
        panel_(bench.panel(kTcpConnection)),
        robot_map_(bench.robot_port()) {
    if (wake_.get() < 0) throw std::system_error(errno, std::generic_category(), "eventfd");
    if (!options.pty_directory.empty()) open_lines();
    thread_ = std::thread([this] { run(); });
  }

  ~Loop() {
    stop_ = true;
    wake();
    thread_.join();
  }

  void wake() {
    const std::uint64_t one = 1;
    [[maybe_unused]] const ssize_t n = ::write(wake_.get(), &one, sizeof one);
  }

  [[nodiscard]] std::uint16_t dial_port() const { return dials_.port; }
  [[nodiscard]] std::uint16_t robot_port() const { return robot_.port; }
  [[nodiscard]] const std::map<std::string, std::filesystem::path>& serial() const {
    return serial_;
  }

 private:
  void open_lines() {
    std::filesystem::create_directories(options_.pty_directory);
    const std::vector<std::string> dials = bench_.dial_ids();
    for (const std::string& name : options_.dialects) {
      const Dialect* dialect = find_dialect(name);
      if (dialect == nullptr) {
        std::string known;
        for (const Dialect* each : dialects()) known += fmt::format(" {}", each->name);
        throw std::invalid_argument(fmt::format("no dialect '{}'; known are:{}", name, known));
      }
      Dialect spoken = *dialect;
      if (dialect == &kModbusRtu) spoken.line.baud = options_.rtu_baud;
      const std::size_t lines = dialect->shared ? 1 : dials.size();
      for (std::size_t dial = 0; dial < lines; ++dial) {
        const std::string key = dialect->shared ? name : name + "_" + dials[dial];
        const std::filesystem::path link = options_.pty_directory / key;
        lines_.emplace_back(
            spoken, dial, bench_.panel(name), link, options_.speed, bench_.seed());
        serial_[key] = link;
      }
    }
  }

  void run() {
    while (!stop_) {
      wait();
      if (stop_) return;
      const Clock::time_point now = Clock::now();
      take_hang_ups(now);
      for (Client& client : clients_) flush(client, now);
      std::erase_if(clients_, [](const Client& client) { return client.gone; });
      for (SerialLine& line : lines_) line.attend(now);
    }
  }

  void wait() {
    std::vector<pollfd> polled;
    const auto add = [&](int fd, short events) { polled.push_back({fd, events, 0}); };
    add(wake_.get(), POLLIN);
    add(dials_.fd.get(), POLLIN);
    add(robot_.fd.get(), POLLIN);
    std::optional<Clock::time_point> due;
    const auto sooner = [&](Clock::time_point time) {
      if (!due || time < *due) due = time;
    };
    for (const Client& client : clients_) {
      add(client.fd.get(), static_cast<short>(client.blocked ? POLLIN | POLLOUT : POLLIN));
      if (!client.out.empty() && !client.blocked) sooner(client.out.front().due);
    }
    for (const SerialLine& line : lines_) {
      add(line.descriptor(), POLLIN);  // -1 is passed over
      if (const auto time = line.next_due()) sooner(*time);
    }
    timespec limit{};
    if (due) {
      const auto left = std::max(
          std::chrono::nanoseconds{0},
          std::chrono::duration_cast<std::chrono::nanoseconds>(*due - Clock::now()));
      limit.tv_sec = left.count() / 1'000'000'000;
      limit.tv_nsec = left.count() % 1'000'000'000;
    }
    if (::ppoll(polled.data(), polled.size(), due ? &limit : nullptr, nullptr) <= 0) return;
    std::size_t at = 3;
    for (Client& client : clients_) {
      const short events = polled[at++].revents;
      if ((events & POLLOUT) != 0) client.blocked = false;
      if ((events & (POLLIN | POLLHUP | POLLERR)) != 0) receive(client);
    }
    for (SerialLine& line : lines_) {
      if ((polled[at++].revents & POLLIN) != 0) line.read_and_answer();
    }
    if ((polled[0].revents & POLLIN) != 0) {
      std::uint64_t count = 0;
      [[maybe_unused]] const ssize_t n = ::read(wake_.get(), &count, sizeof count);
    }
    if ((polled[1].revents & POLLIN) != 0) accept_from(dials_, false);
    if ((polled[2].revents & POLLIN) != 0) accept_from(robot_, true);
  }

  void accept_from(const Listener& listener, bool robot) {
    while (true) {
      Descriptor fd(
          ::accept4(listener.fd.get(), nullptr, nullptr, SOCK_CLOEXEC | SOCK_NONBLOCK));
      if (fd.get() < 0) return;
      if (!robot && Clock::now() < hung_up_until_) continue;  // closed at once
      const int on = 1;
      ::setsockopt(fd.get(), IPPROTO_TCP, TCP_NODELAY, &on, sizeof on);
      clients_.push_back(Client{.fd = std::move(fd), .robot = robot, .in = {}, .out = {}});
    }
  }

  void receive(Client& client) {
    std::array<std::uint8_t, 4096> chunk{};
    const ssize_t n = ::recv(client.fd.get(), chunk.data(), chunk.size(), 0);
    if (n < 0 && (errno == EAGAIN || errno == EINTR)) return;
    if (n <= 0) {
      client.gone = true;
      return;
    }
    client.in.insert(client.in.end(), chunk.begin(), chunk.begin() + n);
    while (true) {
      ModbusRequest request;
      const Framing framing = take_tcp_request(client.in, request);
      if (framing == Framing::kNeedMore) return;
      if (framing == Framing::kBroken) {
        client.gone = true;
        return;
      }
      answer(client, request);
    }
  }

  void answer(Client& client, const ModbusRequest& request) {
    if (request.unit != options_.unit && request.unit != kAnyUnit) {
      const auto code = static_cast<std::uint8_t>(ModbusException::kGatewayNoTarget);
      queue(
          client,
          tcp_frame(request.transaction, request.unit, exception_pdu(request.pdu[0], code)),
          Clock::now());
      return;
    }
    if (client.robot) {
      const Bytes pdu = answer_pdu(request.pdu, robot_map_);
      queue(client, tcp_frame(request.transaction, request.unit, pdu), Clock::now());
      return;
    }
    const GaugeBoxReply reply = gauge_box_answer(request.pdu, *panel_);
    Bytes frame = tcp_frame(
        static_cast<std::uint16_t>(request.transaction + (reply.damaged ? 1 : 0)),
        static_cast<std::uint8_t>(request.unit + (reply.wrong_unit ? 1 : 0)), reply.pdu);
    Clock::time_point due = Clock::now();
    for (std::size_t dial = 0; dial < panel_->dial_count(); ++dial) {
      if (panel_->take(dial, Fault::kSilent)) frame.clear();
      if (const auto late = panel_->take(dial, Fault::kLate)) {
        due += wall(late->amount.value_or(kLate_s));
      }
      if (panel_->take(dial, Fault::kTruncated)) {
        frame.resize(frame.size() - std::min(kCut, frame.size()));
      }
      if (!frame.empty() && panel_->take(dial, Fault::kNoiseByte)) frame.back() ^= 0x55U;
      if (panel_->take(dial, Fault::kStrayLf)) frame.push_back('\n');
    }
    if (!frame.empty()) queue(client, std::move(frame), due);
  }

  static void queue(Client& client, Bytes frame, Clock::time_point due) {
    // In the order of the questions, as one device answers them.
    if (!client.out.empty()) due = std::max(due, client.out.back().due);
    std::size_t waiting = 0;
    for (const Client::Out& out : client.out) waiting += out.bytes.size();
    if (waiting > kMostWaiting) {
      client.gone = true;
      return;
    }
    client.out.push_back({due, std::move(frame), 0});
  }

  static void flush(Client& client, Clock::time_point now) {
    while (!client.gone && !client.blocked && !client.out.empty() &&
           client.out.front().due <= now) {
      Client::Out& out = client.out.front();
      const ssize_t n = ::send(
          client.fd.get(), out.bytes.data() + out.sent, out.bytes.size() - out.sent,
          MSG_NOSIGNAL);
      if (n < 0) {
        if (errno == EAGAIN) {
          client.blocked = true;
        } else if (errno != EINTR) {
          client.gone = true;
        }
        continue;
      }
      out.sent += static_cast<std::size_t>(n);
      if (out.sent == out.bytes.size()) client.out.pop_front();
    }
  }

  void take_hang_ups(Clock::time_point now) {
    for (std::size_t dial = 0; dial < panel_->dial_count(); ++dial) {
      if (const auto order = panel_->take(dial, Fault::kHangUp)) {
        hung_up_until_ = now + wall(order->amount.value_or(kHungUp_s));
        for (Client& client : clients_) client.gone = client.gone || !client.robot;
      }
    }
  }

  Bench& bench_;
  const WireOptions options_;
  Descriptor wake_;
  Listener dials_;
  Listener robot_;
  std::unique_ptr<Panel> panel_;
  RobotRegisterMap robot_map_;
  std::list<Client> clients_;
  std::list<SerialLine> lines_;
  std::map<std::string, std::filesystem::path> serial_;
  Clock::time_point hung_up_until_{};
  std::atomic<bool> stop_{false};
  std::thread thread_;
};

Wire::Wire(Bench& bench, const WireOptions& options)
    : loop_(std::make_unique<Loop>(bench, options)) {}
Wire::~Wire() = default;
std::uint16_t Wire::dial_port() const { return loop_->dial_port(); }
std::uint16_t Wire::robot_port() const { return loop_->robot_port(); }
const std::map<std::string, std::filesystem::path>& Wire::serial() const {
  return loop_->serial();
}
void Wire::wake() { loop_->wake(); }

}  // namespace sixdial::mock_devices
