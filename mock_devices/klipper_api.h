// A machine that Klipper moves, as the socket of its API server sees it: written from the pages
// docs/API_Server.md and docs/Status_Reference.md of its makers. JSON objects, each ended by
// 0x03. Degrees or millimetres.
#pragma once

#include <deque>
#include <map>
#include <nlohmann/json_fwd.hpp>
#include <string>
#include <string_view>
#include <vector>

#include "mock_devices/axis_track.h"
#include "mock_devices/machine_socket.h"

namespace sixdial::mock_devices {

struct KlipperMachine {
  double low = -180.0, high = 180.0;  // travel of X, Y and Z
  std::string homed = "xyz";
  std::vector<double> offset{0.0, 0.0, 0.0};  // machine less command coordinates
  /// It plans so far ahead: a G1 that would be further away is not taken before.
  double ahead_s = 2.0;
  std::string print_state = "standby";  // of the file that it prints
  std::string state = "ready";
  std::string state_message = "Printer is ready";
  std::vector<double> begins_at{0.0, 0.0, 0.0};  // in the coordinates of commands
};

class KlipperApi final : public SocketMachine {
 public:
  explicit KlipperApi(KlipperMachine machine);

  void connected(int client, double time_s) override;
  void receive(int client, std::string_view bytes, double time_s) override;
  [[nodiscard]] std::string due(int client, double time_s) override;
  void gone(int client) override;

  /// In the coordinates of commands.
  [[nodiscard]] std::vector<double> position(double time_s) const;
  /// G1 that it has taken.
  [[nodiscard]] int moves() const { return moves_; }
  [[nodiscard]] const std::vector<std::string>& scripts() const { return seen_; }
  [[nodiscard]] const std::string& state() const { return machine_.state; }
  void shut_down(const std::string& why, double time_s);
  /// Another client's move.
  void move_by_hand(const std::vector<double>& to, double speed, double time_s);

 private:
  struct Script {
    int client = -1;
    std::string id;  // as JSON
    std::deque<std::string> lines;
  };
  void request(int client, const std::string& text, double time_s);
  /// Scripts go on as far as they can by now.
  void advance(double time_s);
  /// False: it cannot be taken yet. An error is thrown as std::runtime_error.
  bool run_line(const std::string& line, double time_s);
  bool run_move(const std::string& line, double time_s);
  void answer(int client, const std::string& id, const char* kind, const nlohmann::json& what);
  [[nodiscard]] nlohmann::json status(const nlohmann::json& asked, double time_s) const;

  KlipperMachine machine_;
  AxisTrack track_;  // in the machine's coordinates
  bool relative_ = false;
  double feed_ = 1500.0;  // per minute
  int moves_ = 0;
  std::vector<std::string> seen_;
  std::deque<Script> scripts_;
  std::map<int, std::string> in_, out_;  // of each client
};

}  // namespace sixdial::mock_devices
