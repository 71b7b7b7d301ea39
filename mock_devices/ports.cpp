#include "mock_devices/ports.h"

#include <arpa/inet.h>
#include <fcntl.h>
#include <fmt/format.h>
#include <netinet/in.h>
#include <sys/socket.h>
#include <sys/un.h>
#include <termios.h>

#include <array>
#include <cerrno>
#include <cstdlib>
#include <stdexcept>
#include <system_error>

namespace sixdial::mock_devices {
namespace {

std::system_error failure(const std::string& what) {
  return {errno, std::generic_category(), what};
}

}  // namespace

Listener listen_on(const std::string& address, std::uint16_t port) {
  const auto fail = [&](const char* what) {
    return failure(fmt::format("{} {}:{}", what, address, port));
  };
  Descriptor fd(::socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC | SOCK_NONBLOCK, 0));
  if (fd.get() < 0) throw fail("socket for");
  const int on = 1;
  ::setsockopt(fd.get(), SOL_SOCKET, SO_REUSEADDR, &on, sizeof on);
  sockaddr_in where{};
  where.sin_family = AF_INET;
  where.sin_port = htons(port);
  if (::inet_pton(AF_INET, address.c_str(), &where.sin_addr) != 1) {
    throw std::invalid_argument(fmt::format("'{}' is not an IPv4 address", address));
  }
  socklen_t size = sizeof where;
  if (::bind(fd.get(), reinterpret_cast<const sockaddr*>(&where), size) != 0) {
    throw fail("cannot bind");
  }
  if (::listen(fd.get(), 64) != 0) throw fail("cannot listen on");
  if (::getsockname(fd.get(), reinterpret_cast<sockaddr*>(&where), &size) != 0) {
    throw fail("getsockname of");
  }
  return {std::move(fd), ntohs(where.sin_port)};
}

Listener listen_on(const std::filesystem::path& socket) {
  sockaddr_un where{};
  where.sun_family = AF_UNIX;
  const std::string name = socket.string();
  if (name.size() >= sizeof where.sun_path) {
    throw std::invalid_argument(fmt::format("{} is too long for a socket", name));
  }
  name.copy(where.sun_path, name.size());
  std::error_code ignored;
  std::filesystem::remove(socket, ignored);
  Descriptor fd(::socket(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC | SOCK_NONBLOCK, 0));
  if (fd.get() < 0 ||
      ::bind(fd.get(), reinterpret_cast<const sockaddr*>(&where), sizeof where) != 0 ||
      ::listen(fd.get(), 64) != 0) {
    throw failure(fmt::format("cannot listen on {}", name));
  }
  return {std::move(fd), 0};
}

PseudoTerminal::PseudoTerminal(std::filesystem::path link) : link_(std::move(link)) {
  const auto fail = [&](const char* what) {
    return failure(fmt::format("{} for {}", what, link_.string()));
  };
  master_ = Descriptor(::posix_openpt(O_RDWR | O_NOCTTY | O_NONBLOCK | O_CLOEXEC));
  if (master_.get() < 0) throw fail("posix_openpt");
  if (::grantpt(master_.get()) != 0 || ::unlockpt(master_.get()) != 0) throw fail("unlockpt");
  std::array<char, 128> name{};
  if (::ptsname_r(master_.get(), name.data(), name.size()) != 0) throw fail("ptsname");
  slave_ = Descriptor(::open(name.data(), O_RDWR | O_NOCTTY | O_CLOEXEC));
  if (slave_.get() < 0) throw fail("open of the pseudo-terminal");
  termios raw{};
  if (::tcgetattr(slave_.get(), &raw) != 0) throw fail("tcgetattr");
  ::cfmakeraw(&raw);
  if (::tcsetattr(slave_.get(), TCSANOW, &raw) != 0) throw fail("tcsetattr");
  // Made beside and renamed, so that nobody sees the link missing or half made.
  const std::filesystem::path fresh = link_.string() + ".new";
  std::error_code ignored;
  std::filesystem::remove(fresh, ignored);
  std::filesystem::create_symlink(name.data(), fresh);
  std::filesystem::rename(fresh, link_);
}

PseudoTerminal::~PseudoTerminal() {
  std::error_code ignored;
  std::filesystem::remove(link_, ignored);
}

}  // namespace sixdial::mock_devices
