#include "tests/acquisition/wire.h"

#include <arpa/inet.h>
#include <fcntl.h>
#include <netinet/in.h>
#include <netinet/tcp.h>
#include <poll.h>
#include <pty.h>
#include <sys/socket.h>
#include <termios.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cstdlib>
#include <filesystem>
#include <stdexcept>
#include <utility>

namespace sixdial::test {
namespace {

using std::chrono::milliseconds;
using std::chrono::steady_clock;

constexpr int kSlice_ms = 10;

int open_master(std::string& path) {
  int master = -1;
  int slave = -1;
  std::array<char, 64> name{};
  if (::openpty(&master, &slave, name.data(), nullptr, nullptr) != 0) {
    throw std::runtime_error("no pseudo-terminal");
  }
  termios raw{};
  ::tcgetattr(slave, &raw);
  ::cfmakeraw(&raw);
  ::tcsetattr(slave, TCSANOW, &raw);
  ::close(slave);
  ::fcntl(master, F_SETFD, FD_CLOEXEC);
  path = name.data();
  return master;
}

// Bytes that came within the slice. A master without an opened slave reads EIO: nothing yet.
std::string read_some(int fd) {
  pollfd watched{.fd = fd, .events = POLLIN, .revents = 0};
  ::poll(&watched, 1, kSlice_ms);
  std::array<char, 512> bytes{};
  if ((watched.revents & POLLIN) != 0) {
    const ssize_t count = ::read(fd, bytes.data(), bytes.size());
    if (count > 0) return {bytes.data(), static_cast<std::size_t>(count)};
  }
  if ((watched.revents & POLLHUP) != 0) {
    std::this_thread::sleep_for(milliseconds(2));  // poll does not wait on a hung-up master
  }
  return {};
}

void write_all(int fd, const char* bytes, std::size_t size) {
  while (size > 0) {
    const ssize_t count = ::write(fd, bytes, size);
    if (count <= 0) return;
    bytes += count;
    size -= static_cast<std::size_t>(count);
  }
}

std::uint8_t high(int word) { return static_cast<std::uint8_t>((word >> 8) & 0xff); }
std::uint8_t low(int word) { return static_cast<std::uint8_t>(word & 0xff); }

void nap(int span_ms, const std::stop_token& stop) {
  const auto until = steady_clock::now() + milliseconds(span_ms);
  while (!stop.stop_requested() && steady_clock::now() < until) {
    std::this_thread::sleep_for(milliseconds(1));
  }
}

}  // namespace

TemporaryFolder::TemporaryFolder() {
  std::string name =
      (std::filesystem::temp_directory_path() / "sixdial-").string() + std::string(6, 'X');
  if (::mkdtemp(name.data()) == nullptr) throw std::runtime_error("no temporary folder");
  folder_ = name;
}

TemporaryFolder::~TemporaryFolder() {
  std::error_code ignored;
  std::filesystem::remove_all(folder_, ignored);
}

PtyDevice::PtyDevice(std::string end, Answer answer)
    : master_(open_master(path_)), end_(std::move(end)), answer_(std::move(answer)) {
  thread_ = std::jthread([this](const std::stop_token& stop) {
    std::string pending;
    while (!stop.stop_requested()) {
      pending += read_some(master_);
      for (std::size_t at = pending.find(end_); at != std::string::npos;
           at = pending.find(end_)) {
        const std::string request = pending.substr(0, at + end_.size());
        pending.erase(0, at + end_.size());
        ++requests_;
        say(answer_(request));
      }
    }
  });
}

PtyDevice::~PtyDevice() { hang_up(); }

void PtyDevice::say(const std::string& bytes) const {
  write_all(master_, bytes.data(), bytes.size());
}

void PtyDevice::hang_up() {
  thread_.request_stop();
  if (thread_.joinable()) thread_.join();
  if (master_ >= 0) ::close(std::exchange(master_, -1));
}

void put_int32(Registers& registers, int address, std::int32_t value) {
  const auto bits = std::bit_cast<std::uint32_t>(value);
  registers[address] = static_cast<std::uint16_t>(bits >> 16);
  registers[address + 1] = static_cast<std::uint16_t>(bits & 0xffff);
}

void put_float32(Registers& registers, int address, float value) {
  put_int32(registers, address, std::bit_cast<std::int32_t>(value));
}

void ModbusTable::set(const std::function<void(ModbusTable&)>& change) {
  const std::lock_guard lock(mutex);
  change(*this);
}

std::vector<std::uint8_t> ModbusTable::reply(const std::vector<std::uint8_t>& request) {
  const std::lock_guard lock(mutex);
  const std::uint8_t unit = request[0];
  const std::uint8_t function = request[1];
  const int address = request[2] << 8 | request[3];
  const int count = request[4] << 8 | request[5];
  const auto refuse = [&](std::uint8_t code) {
    return std::vector<std::uint8_t>{unit, static_cast<std::uint8_t>(function | 0x80), code};
  };
  if (function == 16) {
    for (int i = 0; i < count; ++i) {
      const auto at = static_cast<std::size_t>(7 + 2 * i);
      holding[address + i] = static_cast<std::uint16_t>(request[at] << 8 | request[at + 1]);
    }
    if (on_write) on_write(address);
    return {unit, function, high(address), low(address), high(count), low(count)};
  }
  if (function != 3 && function != 4) return refuse(1);
  if (before_read) before_read(address);
  const Registers& registers = function == 3 ? holding : input;
  std::vector<std::uint8_t> reply{unit, function, low(2 * count)};
  for (int i = 0; i < count; ++i) {
    const auto found = registers.find(address + i);
    if (found == registers.end()) return refuse(2);
    reply.push_back(high(found->second));
    reply.push_back(low(found->second));
  }
  return reply;
}

ModbusTcpServer::ModbusTcpServer(ModbusTable& table, int port) : table_(table) {
  listener_ = ::socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0);
  const int on = 1;
  ::setsockopt(listener_, SOL_SOCKET, SO_REUSEADDR, &on, sizeof on);
  sockaddr_in address{};
  address.sin_family = AF_INET;
  address.sin_port = htons(static_cast<std::uint16_t>(port));
  address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
  socklen_t size = sizeof address;
  if (::bind(listener_, reinterpret_cast<sockaddr*>(&address), size) != 0 ||
      ::listen(listener_, 8) != 0 ||
      ::getsockname(listener_, reinterpret_cast<sockaddr*>(&address), &size) != 0) {
    throw std::runtime_error("no listening socket");
  }
  port_ = ntohs(address.sin_port);
  acceptor_ = std::jthread([this](const std::stop_token& stop) {
    while (!stop.stop_requested()) {
      pollfd watched{.fd = listener_, .events = POLLIN, .revents = 0};
      if (::poll(&watched, 1, kSlice_ms) <= 0) continue;
      const int client = ::accept4(listener_, nullptr, nullptr, SOCK_CLOEXEC);
      if (client < 0) continue;
      const int yes = 1;
      ::setsockopt(client, IPPROTO_TCP, TCP_NODELAY, &yes, sizeof yes);
      ++connections_;
      clients_.emplace_back([this, client](const std::stop_token& end) { serve(client, end); });
    }
  });
}

ModbusTcpServer::~ModbusTcpServer() {
  acceptor_.request_stop();
  acceptor_.join();
  for (std::jthread& client : clients_) client.request_stop();
  clients_.clear();
  ::close(listener_);
}

void ModbusTcpServer::set_delay(std::function<int(int k)> delay_ms) {
  const std::lock_guard lock(mutex_);
  delay_ms_ = std::move(delay_ms);
}

void ModbusTcpServer::set_spoil(Spoil spoil) {
  const std::lock_guard lock(mutex_);
  spoil_ = std::move(spoil);
}

void ModbusTcpServer::serve(int socket, const std::stop_token& stop) {
  std::string pending;
  while (!stop.stop_requested()) {
    pollfd watched{.fd = socket, .events = POLLIN, .revents = 0};
    if (::poll(&watched, 1, kSlice_ms) <= 0) continue;
    std::array<char, 512> bytes{};
    const ssize_t got = ::read(socket, bytes.data(), bytes.size());
    if (got <= 0) break;
    pending.append(bytes.data(), static_cast<std::size_t>(got));
    while (pending.size() >= 7) {
      const std::vector<std::uint8_t> head(pending.begin(), pending.begin() + 6);
      const auto length = static_cast<std::size_t>(head[4] << 8 | head[5]);
      if (pending.size() < 6 + length) break;
      const std::vector<std::uint8_t> request(
          pending.begin() + 6, pending.begin() + 6 + static_cast<std::ptrdiff_t>(length));
      pending.erase(0, 6 + length);
      const int k = requests_++;
      std::function<int(int)> delay_ms;
      Spoil spoil;
      {
        const std::lock_guard lock(mutex_);
        delay_ms = delay_ms_;
        spoil = spoil_;
      }
      nap(delay_ms(k), stop);
      const std::vector<std::uint8_t> reply = table_.reply(request);
      const int size = static_cast<int>(reply.size());
      std::vector<std::uint8_t> frame(6 + reply.size());
      frame[0] = head[0];
      frame[1] = head[1];
      frame[4] = high(size);
      frame[5] = low(size);
      std::copy(reply.begin(), reply.end(), frame.begin() + 6);
      spoil(k, frame);
      ::send(socket, frame.data(), frame.size(), MSG_NOSIGNAL);
    }
  }
  ::close(socket);
}

std::uint16_t modbus_crc(const std::vector<std::uint8_t>& bytes) {
  unsigned int crc = 0xffff;
  for (const std::uint8_t byte : bytes) {
    crc ^= byte;
    for (int bit = 0; bit < 8; ++bit) crc = (crc & 1) != 0 ? (crc >> 1) ^ 0xa001u : crc >> 1;
  }
  return static_cast<std::uint16_t>(crc);
}

ModbusRtuServer::ModbusRtuServer(
    ModbusTable& table, int unit, std::function<int(int k)> delay_ms)
    : table_(table), delay_ms_(std::move(delay_ms)), unit_(unit), master_(open_master(path_)) {
  thread_ = std::jthread([this](const std::stop_token& stop) {
    std::string pending;
    while (!stop.stop_requested()) {
      pending += read_some(master_);
      while (pending.size() >= 8) {
        const bool write = pending[1] == 16;
        const std::size_t size = write ? 9u + static_cast<std::uint8_t>(pending[6]) : 8u;
        if (pending.size() < size) break;
        std::vector<std::uint8_t> request(
            pending.begin(), pending.begin() + static_cast<std::ptrdiff_t>(size - 2));
        pending.erase(0, size);
        const int k = requests_++;
        if (request[0] != unit_) continue;
        nap(delay_ms_(k), stop);
        std::vector<std::uint8_t> reply = table_.reply(request);
        const std::uint16_t crc = modbus_crc(reply);
        reply.push_back(low(crc));
        reply.push_back(high(crc));
        write_all(master_, reinterpret_cast<const char*>(reply.data()), reply.size());
      }
    }
  });
}

ModbusRtuServer::~ModbusRtuServer() {
  thread_.request_stop();
  thread_.join();
  ::close(master_);
}

bool eventually(const std::function<bool()>& condition, milliseconds most) {
  const auto deadline = steady_clock::now() + most;
  while (!condition()) {
    if (steady_clock::now() > deadline) return false;
    std::this_thread::sleep_for(milliseconds(2));
  }
  return true;
}

}  // namespace sixdial::test
