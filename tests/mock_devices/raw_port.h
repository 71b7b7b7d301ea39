// The test's own end of the cables: sockets and terminals without any of the project's drivers.
#pragma once

#include <arpa/inet.h>
#include <fcntl.h>
#include <gtest/gtest.h>
#include <netinet/in.h>
#include <poll.h>
#include <sys/socket.h>
#include <unistd.h>

#include <array>
#include <chrono>
#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <string>
#include <thread>
#include <vector>

#include "mock_devices/mock_rig.h"
#include "mock_devices/modbus_slave.h"

namespace sixdial::mock_devices {

using Clock = std::chrono::steady_clock;
using Eigen::Vector2d;

inline constexpr int kPatience_ms = 60'000;  // of a test on a loaded machine
inline constexpr int kSilence_ms = 300;      // how long "no answer" is waited for
inline constexpr double kNoise_mm =
    0.02;  // noise, curve, hysteresis and quantum, ten times over

class Port {
 public:
  explicit Port(int fd) : fd_(fd) { EXPECT_GE(fd, 0); }
  ~Port() { ::close(fd_); }
  Port(const Port&) = delete;
  Port& operator=(const Port&) = delete;

  static int tcp(std::uint16_t port) {
    const int fd = ::socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0);
    sockaddr_in where{};
    where.sin_family = AF_INET;
    where.sin_port = htons(port);
    where.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
    if (::connect(fd, reinterpret_cast<const sockaddr*>(&where), sizeof where) == 0) return fd;
    ::close(fd);
    return -1;
  }
  static int serial(const std::filesystem::path& path) {
    return ::open(path.c_str(), O_RDWR | O_NOCTTY | O_NONBLOCK | O_CLOEXEC);
  }

  void send(const std::string& bytes) const {
    EXPECT_EQ(::write(fd_, bytes.data(), bytes.size()), static_cast<ssize_t>(bytes.size()));
  }
  void send(const Bytes& bytes) const { send(std::string(bytes.begin(), bytes.end())); }

  /// For lines that may just have been closed at the other end.
  void send_if_open(const Bytes& bytes) const {
    [[maybe_unused]] const ssize_t n = ::send(fd_, bytes.data(), bytes.size(), MSG_NOSIGNAL);
  }

  /// Reads until `done(what came)`; what came so far if it takes too long or the line ends.
  template <typename Done>
  std::string read_until(Done done, int patience_ms = kPatience_ms) {
    std::string got;
    const auto limit = Clock::now() + std::chrono::milliseconds(patience_ms);
    while (!done(got)) {
      const auto left =
          std::chrono::duration_cast<std::chrono::milliseconds>(limit - Clock::now()).count();
      pollfd polled{fd_, POLLIN, 0};
      if (left <= 0 || ::poll(&polled, 1, static_cast<int>(left)) <= 0) return got;
      std::array<char, 256> chunk{};
      const ssize_t n = ::read(fd_, chunk.data(), chunk.size());
      if (n <= 0) {
        ended = true;
        return got;
      }
      got.append(chunk.data(), static_cast<std::size_t>(n));
    }
    return got;
  }
  std::string line() {
    return read_until([](const std::string& got) { return got.ends_with('\r'); });
  }
  std::string nothing() {
    return read_until([](const std::string& got) { return !got.empty(); }, kSilence_ms);
  }
  Bytes bytes(std::size_t count) {
    const std::string got =
        read_until([&](const std::string& so_far) { return so_far.size() >= count; });
    return {got.begin(), got.end()};
  }

  bool ended = false;

 private:
  int fd_;
};

inline const Bytes kReadSix{0x00, 0x01, 0x00, 0x00, 0x00, 0x06,
                            0x01, 0x04, 0x00, 0x00, 0x00, 0x0C};

inline std::vector<double> millimetres(const Bytes& reply) {
  std::vector<double> result;
  for (std::size_t i = 9; i + 4 <= reply.size(); i += 4) {
    const std::uint32_t bits = static_cast<std::uint32_t>(reply[i]) << 24 |
                               static_cast<std::uint32_t>(reply[i + 1]) << 16 |
                               static_cast<std::uint32_t>(reply[i + 2]) << 8 | reply[i + 3];
    result.push_back(static_cast<std::int32_t>(bits) / 1000.0);
  }
  return result;
}

inline std::vector<double> read_six(Port& port) {
  port.send(kReadSix);
  return millimetres(port.bytes(9 + 24));
}

inline void append(Bytes& bytes, std::int32_t value) {
  const auto bits = static_cast<std::uint32_t>(value);
  for (const int shift : {24, 16, 8, 0}) {
    bytes.push_back(static_cast<std::uint8_t>(bits >> shift & 0xFF));
  }
}

/// Targets, command 1 and speed in one write of function 16.
inline Bytes start_request(const Vector2d& q_rad) {
  Bytes request{0, 9, 0, 0, 0, 19, 1, 0x10, 0, 0, 0, 6, 12};
  append(request, static_cast<std::int32_t>(std::lround(q_rad[0] * 1e8)));
  append(request, static_cast<std::int32_t>(std::lround(q_rad[1] * 1e8)));
  request.insert(request.end(), {0, 1, 0, 100});
  return request;
}

inline std::uint16_t robot_input(Port& port, std::uint8_t address) {
  port.send(Bytes{0, 2, 0, 0, 0, 6, 1, 4, 0, address, 0, 1});
  const Bytes reply = port.bytes(11);
  return reply.size() == 11 ? static_cast<std::uint16_t>(reply[9] << 8 | reply[10]) : 0xFFFF;
}

/// Waits for the condition, boundedly.
template <typename Condition>
bool eventually(Condition condition) {
  const auto limit = Clock::now() + std::chrono::milliseconds(kPatience_ms);
  while (!condition()) {
    if (Clock::now() > limit) return false;
    std::this_thread::yield();
  }
  return true;
}

class MockRigTest : public testing::Test {
 protected:
  MockRigTest() {
    const std::string pattern =
        (std::filesystem::temp_directory_path() / "sixdial_mock_XXXXXX").string();
    std::vector<char> name(pattern.begin(), pattern.end());
    name.push_back('\0');
    folder_ = ::mkdtemp(name.data());
  }
  ~MockRigTest() override { std::filesystem::remove_all(folder_); }

  MockRigOptions options(double speed = 50.0) const {
    MockRigOptions options;
    options.world.robot = drawn_robot(options.world.rig, 21);
    options.clock_speed = speed;
    options.pty_directory = folder_;
    options.dialects = {"mux10", "sylvac", "mahr", "mw", "modbus_rtu"};
    return options;
  }
  static Vector2d angles(const MockRig& rig, const Vector2d& target_mm) {
    const geometry::Robot& robot = rig.world().rig.robot;
    return geometry::inverse(robot.nominal, target_mm, robot.working_mode, Vector2d(1.3, 3.0))
        .value();
  }

  std::filesystem::path folder_;
};

}  // namespace sixdial::mock_devices
