// What mocks open for their clients: a TCP port, a socket of this machine, a pseudo-terminal.
#pragma once

#include <unistd.h>

#include <cstdint>
#include <filesystem>
#include <string>
#include <utility>

namespace sixdial::mock_devices {

/// An open descriptor.
class Descriptor {
 public:
  explicit Descriptor(int fd = -1) : fd_(fd) {}
  ~Descriptor() {
    if (fd_ >= 0) ::close(fd_);
  }
  Descriptor(Descriptor&& other) noexcept : fd_(std::exchange(other.fd_, -1)) {}
  Descriptor& operator=(Descriptor&& other) noexcept {
    std::swap(fd_, other.fd_);
    return *this;
  }
  [[nodiscard]] int get() const { return fd_; }

 private:
  int fd_;
};

struct Listener {
  Descriptor fd;
  std::uint16_t port = 0;  // 0: a Unix socket
};
/// A TCP port, 0 any free one. Throws std::system_error that names it.
[[nodiscard]] Listener listen_on(const std::string& address, std::uint16_t port);
/// A Unix socket, in the place of what is there. Throws std::system_error that names it, or
/// std::invalid_argument if the path is too long for one.
[[nodiscard]] Listener listen_on(const std::filesystem::path& socket);

/// The device's end of a pseudo-terminal, raw.
class PseudoTerminal {
 public:
  /// `link` leads to the client's end, and goes with the object. Throws std::system_error.
  explicit PseudoTerminal(std::filesystem::path link);
  ~PseudoTerminal();
  PseudoTerminal(const PseudoTerminal&) = delete;
  PseudoTerminal& operator=(const PseudoTerminal&) = delete;

  [[nodiscard]] int descriptor() const { return master_.get(); }

 private:
  const std::filesystem::path link_;
  Descriptor master_;
  Descriptor slave_;  // kept open, so that a client may come and go
};

}  // namespace sixdial::mock_devices
