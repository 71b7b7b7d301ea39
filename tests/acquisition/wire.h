// Devices at the other end of the wire, written byte by byte for these tests: dials on
// pseudo-terminals, gauge boxes on Modbus TCP and RTU. They share nothing with the drivers.
#pragma once

#include <atomic>
#include <chrono>
#include <cstdint>
#include <functional>
#include <map>
#include <mutex>
#include <string>
#include <thread>
#include <vector>

namespace sixdial::test {

/// A file name in a temporary folder of this process, removed with the object.
class TemporaryFolder {
 public:
  TemporaryFolder();
  ~TemporaryFolder();
  TemporaryFolder(const TemporaryFolder&) = delete;
  TemporaryFolder& operator=(const TemporaryFolder&) = delete;
  [[nodiscard]] std::string path(const std::string& name) const { return folder_ + "/" + name; }

 private:
  std::string folder_;
};

/// The device side of a pseudo-terminal. Each request up to `end` goes to `answer`, what that
/// returns goes back; it may sleep to be late.
class PtyDevice {
 public:
  using Answer = std::function<std::string(const std::string& request)>;
  PtyDevice(std::string end, Answer answer);
  ~PtyDevice();
  PtyDevice(const PtyDevice&) = delete;
  PtyDevice& operator=(const PtyDevice&) = delete;

  [[nodiscard]] const std::string& path() const { return path_; }
  [[nodiscard]] int requests() const { return requests_; }
  /// Unasked bytes.
  void say(const std::string& bytes) const;
  /// As when the adapter is pulled out.
  void hang_up();

 private:
  std::string path_;
  int master_ = -1;
  std::string end_;
  Answer answer_;
  std::atomic<int> requests_{0};
  std::jthread thread_;
};

using Registers = std::map<int, std::uint16_t>;
void put_int32(Registers& registers, int address, std::int32_t value);
void put_float32(Registers& registers, int address, float value);

/// Modbus functions 3, 4 and 16 on a table of registers; exception 2 for what is not in it.
class ModbusTable {
 public:
  Registers input;                               // function 4
  Registers holding;                             // functions 3 and 16
  std::function<void(int address)> on_write;     // with the table's mutex held
  std::function<void(int address)> before_read;  // likewise
  mutable std::mutex mutex;

  /// unit, function, data -> the same of the reply.
  [[nodiscard]] std::vector<std::uint8_t> reply(const std::vector<std::uint8_t>& request);
  void set(const std::function<void(ModbusTable&)>& change);
};

/// On 127.0.0.1 and a free port. The k-th request can be answered late or spoilt.
class ModbusTcpServer {
 public:
  explicit ModbusTcpServer(ModbusTable& table, int port = 0);
  ~ModbusTcpServer();
  ModbusTcpServer(const ModbusTcpServer&) = delete;
  ModbusTcpServer& operator=(const ModbusTcpServer&) = delete;
  [[nodiscard]] int port() const { return port_; }
  [[nodiscard]] int requests() const { return requests_; }
  [[nodiscard]] int connections() const { return connections_; }

  using Spoil = std::function<void(int k, std::vector<std::uint8_t>& frame)>;
  void set_delay(std::function<int(int k)> delay_ms);
  void set_spoil(Spoil spoil);

 private:
  void serve(int socket, const std::stop_token& stop);

  ModbusTable& table_;
  std::mutex mutex_;  // of the next two
  std::function<int(int k)> delay_ms_ = [](int) { return 0; };
  Spoil spoil_ = [](int, std::vector<std::uint8_t>&) {};
  int listener_ = -1;
  int port_ = 0;
  std::atomic<int> requests_{0};
  std::atomic<int> connections_{0};
  std::vector<std::jthread> clients_;
  std::jthread acceptor_;
};

/// The same on a pseudo-terminal.
class ModbusRtuServer {
 public:
  ModbusRtuServer(
      ModbusTable& table, int unit, std::function<int(int k)> delay_ms = [](int) { return 0; });
  ~ModbusRtuServer();
  ModbusRtuServer(const ModbusRtuServer&) = delete;
  ModbusRtuServer& operator=(const ModbusRtuServer&) = delete;
  [[nodiscard]] const std::string& path() const { return path_; }
  [[nodiscard]] int requests() const { return requests_; }

 private:
  ModbusTable& table_;
  std::function<int(int k)> delay_ms_;
  int unit_;
  std::string path_;
  int master_ = -1;
  std::atomic<int> requests_{0};
  std::jthread thread_;
};

[[nodiscard]] std::uint16_t modbus_crc(const std::vector<std::uint8_t>& bytes);

/// How long a test waits for what must happen: long, for a loaded machine under a sanitizer;
/// only a failing test waits so long.
inline constexpr std::chrono::seconds kPatience{60};
/// Within which a thing must end that could take a minute or for ever if it were wrong.
inline constexpr std::chrono::seconds kInTime{20};

/// Waits until `condition`; whether it came true within `most`.
bool eventually(
    const std::function<bool()>& condition, std::chrono::milliseconds most = kPatience);

}  // namespace sixdial::test
