// The cables of a mock controller that speaks to several clients: TCP or a Unix socket, and a
// pseudo-terminal, served by one thread. Mock time runs `speed` times as fast as the wall's.
#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <memory>
#include <string>
#include <string_view>

namespace sixdial::mock_devices {

/// A controller as its socket sees it. One thread at a time; times do not run backwards.
class SocketMachine {
 public:
  virtual ~SocketMachine() = default;
  virtual void connected(int client, double time_s) = 0;
  virtual void receive(int client, std::string_view bytes, double time_s) = 0;
  /// What is to be sent to the client by now.
  [[nodiscard]] virtual std::string due(int client, double time_s) = 0;
  /// It closes the client's connection.
  [[nodiscard]] virtual bool hangs_up(int /*client*/) const { return false; }
  virtual void gone(int client) = 0;
};

struct MachineSocketOptions {
  std::string address = "127.0.0.1";
  std::uint16_t port = 0;               // 0: any free one
  std::filesystem::path unix_socket{};  // instead of TCP, unless empty
  /// Leads to a pseudo-terminal, which is a client that is always there; empty: none.
  std::filesystem::path pty_link{};
  double speed = 1.0;
};

/// Any thread.
class MachineSocket {
 public:
  /// Throws std::system_error if a port cannot be opened. The machine must outlive it.
  MachineSocket(SocketMachine& machine, const MachineSocketOptions& options);
  ~MachineSocket();
  MachineSocket(const MachineSocket&) = delete;
  MachineSocket& operator=(const MachineSocket&) = delete;

  [[nodiscard]] std::uint16_t port() const;
  /// Looks at or changes the machine at mock time `time_s`.
  void with(const std::function<void(double time_s)>& change);
  /// Closes every client's connection to the socket.
  void hang_up();
  /// Takes connections and bytes, and says nothing more.
  void fall_silent(bool silent);
  /// Of what is sent next, only so many bytes go out.
  void cut_next(std::size_t bytes);
  /// To the socket, since it was opened.
  [[nodiscard]] int connections() const;

 private:
  class Loop;
  std::unique_ptr<Loop> loop_;
};

}  // namespace sixdial::mock_devices
