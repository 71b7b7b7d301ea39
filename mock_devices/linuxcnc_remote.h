// A machine that LinuxCNC moves, as the socket of its remote linuxcncrsh sees it: written from
// the manual page linuxcncrsh(1) and from what its source (emcrsh.cc) prints. Degrees or
// millimetres.
#pragma once

#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "mock_devices/axis_track.h"
#include "mock_devices/machine_socket.h"

namespace sixdial::mock_devices {

struct LinuxCncMachine {
  double low = -180.0, high = 180.0;  // travel of each axis
  bool homed = true;
  bool estop = false, on = true;
  int kinematics = 1;        // 1: each axis a joint
  std::string units = "MM";  // or "INCH": of X, Y, Z as it tells them
  double step = 0.0;         // positions are multiples of it; 0: none
  double work_offset = 0.0;  // of G54, each axis
  double begins_s = 0.02;    // an order is acknowledged so long before it begins
  /// Before version 2.10: other line ends, "set_wait" for "wait_mode".
  bool old = false;
  bool waits_done = false;  // another client has set it so
  std::string password = "EMC", enable = "EMCTOO";
  std::vector<double> begins_at{};  // each axis, in the machine's coordinates; empty: 0
};

class LinuxCncRemote final : public SocketMachine {
 public:
  explicit LinuxCncRemote(LinuxCncMachine machine);

  void connected(int client, double time_s) override;
  void receive(int client, std::string_view bytes, double time_s) override;
  [[nodiscard]] std::string due(int client, double time_s) override;
  [[nodiscard]] bool hangs_up(int client) const override;
  void gone(int client) override;

  /// In the machine's coordinates.
  [[nodiscard]] std::vector<double> position(double time_s) const;
  [[nodiscard]] int moves() const { return moves_; }
  void press_estop(double time_s);
  void pause(double time_s);
  /// Another client's order.
  void move_by_hand(const std::vector<double>& to, double speed, double time_s);
  /// Takes control away from whoever has it.
  void take_control() { enabled_ = -1; }

 private:
  struct Client {
    bool linked = false, echo = true, verbose = false, quits = false;
    std::string in{}, out{};
    double busy_until_s = 0.0;  // an order that it waits for
  };
  void line(int id, const std::string& text, double time_s);
  void set(int id, const std::string& name, const std::string& what, double time_s);
  /// False: refused.
  bool order(int id, const std::string& name, const std::string& what, double time_s);
  bool mdi(std::string words, double time_s);
  /// Empty: it knows no such value.
  [[nodiscard]] std::optional<std::string> value(
      int id, const std::string& name, double time_s);
  [[nodiscard]] std::string figures(double time_s, bool in_work_coordinates) const;
  [[nodiscard]] bool runs(double time_s) const;
  void stop(double time_s);

  LinuxCncMachine machine_;
  AxisTrack track_;
  std::string mode_ = "MANUAL";
  std::string error_;
  bool paused_ = false;
  bool inches_ = false;
  double feed_ = 0.0;  // per minute
  double began_s_ = 0.0;
  int moves_ = 0;
  int enabled_ = -1;
  std::map<int, Client> clients_;
};

}  // namespace sixdial::mock_devices
