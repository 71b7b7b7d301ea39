#include "mock_devices/linuxcnc_remote.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cctype>
#include <cmath>
#include <cstdlib>
#include <set>
#include <utility>

namespace sixdial::mock_devices {
namespace {

constexpr std::string_view kAxes = "XYZABC";
constexpr double kInch_mm = 25.4;

std::string upper(std::string text) {
  for (char& c : text) c = static_cast<char>(std::toupper(static_cast<unsigned char>(c)));
  return text;
}

std::string take_word(std::string& text) {
  const std::size_t begin = std::min(text.find_first_not_of(' '), text.size());
  const std::size_t end = std::min(text.find(' ', begin), text.size());
  std::string word = text.substr(begin, end - begin);
  text.erase(0, std::min(text.find_first_not_of(' ', end), text.size()));
  return word;
}

/// Commands that a client without control may give.
bool is_free(const std::string& name) {
  static const std::set<std::string> free{
      "ECHO", "VERBOSE", "ENABLE", "COMM_MODE", "COMM_PROT"};
  return free.contains(name);
}

/// ... and a machine that is switched off takes.
bool is_taken_when_off(const std::string& name) {
  static const std::set<std::string> taken{"WAIT_MODE", "SET_WAIT", "WAIT", "ESTOP", "MACHINE"};
  return is_free(name) || taken.contains(name);
}

}  // namespace

LinuxCncRemote::LinuxCncRemote(LinuxCncMachine machine)
    : machine_(std::move(machine)), track_([this] {
        std::vector<double> at = machine_.begins_at;
        at.resize(kAxes.size(), 0.0);
        return at;
      }()) {}

void LinuxCncRemote::connected(int client, double) { clients_[client] = {}; }
void LinuxCncRemote::gone(int client) {
  clients_.erase(client);
  if (enabled_ == client) enabled_ = -1;
}
bool LinuxCncRemote::hangs_up(int client) const { return clients_.at(client).quits; }

std::vector<double> LinuxCncRemote::position(double time_s) const {
  std::vector<double> at = track_.position(time_s);
  if (machine_.step > 0.0) {
    for (double& value : at) value = std::round(value / machine_.step) * machine_.step;
  }
  return at;
}

bool LinuxCncRemote::runs(double time_s) const {
  return time_s >= began_s_ && track_.moves(time_s);
}

void LinuxCncRemote::stop(double time_s) {
  track_.stop(time_s);
  paused_ = false;
  for (auto& [id, client] : clients_) client.busy_until_s = 0.0;
}

void LinuxCncRemote::press_estop(double time_s) {
  stop(time_s);
  machine_.estop = true;
  machine_.on = false;
}

void LinuxCncRemote::pause(double time_s) {
  track_.stop(time_s);
  paused_ = true;
}

void LinuxCncRemote::move_by_hand(const std::vector<double>& to, double speed, double time_s) {
  began_s_ = time_s;
  track_.append(to, speed, time_s);
}

void LinuxCncRemote::receive(int id, std::string_view bytes, double time_s) {
  Client& client = clients_.at(id);
  if (client.echo && client.linked) client.out += bytes;
  client.in += bytes;
  (void)time_s;
}

// A client whose order is waited for is not heard before it is done.
std::string LinuxCncRemote::due(int id, double time_s) {
  Client& client = clients_.at(id);
  while (!client.quits && time_s >= client.busy_until_s) {
    const std::size_t end = client.in.find_first_of("\r\n");
    if (end == std::string::npos) break;
    const std::string text = client.in.substr(0, end);
    client.in.erase(0, end + 1);
    if (!text.empty()) line(id, text, time_s);
  }
  if (time_s < client.busy_until_s) return {};  // its acknowledgement neither
  return std::exchange(client.out, {});
}

void LinuxCncRemote::line(int id, const std::string& text, double time_s) {
  Client& client = clients_.at(id);
  std::string rest = text;
  const std::string command = upper(take_word(rest));
  if (command == "HELLO") {
    const std::string password = take_word(rest);
    const std::string name = take_word(rest);
    client.linked = password == machine_.password && !name.empty() && !take_word(rest).empty();
    client.out += client.linked ? "HELLO ACK EMCNETSVR 1.1\r\n" : "HELLO NAK\r\n";
  } else if (command == "SET") {
    const std::string name = upper(take_word(rest));
    if (!client.linked || name.empty()) {
      client.out += "SET NAK\r\n";
    } else {
      set(id, name, rest, time_s);
    }
  } else if (command == "GET") {
    const std::string name = upper(take_word(rest));
    const auto told = value(id, name, time_s);
    client.out += told ? name + " " + *told + "\r\n" : fmt::format("GET {} NAK\r\n", name);
    if (!told && machine_.old) client.out += "\r\n";
  } else if (command == "QUIT") {
    client.quits = true;
  }
}

void LinuxCncRemote::set(
    int id, const std::string& name, const std::string& what, double time_s) {
  Client& client = clients_.at(id);
  const bool allowed =
      (is_free(name) || id == enabled_) && (is_taken_when_off(name) || machine_.on);
  const bool done = allowed && order(id, name, what, time_s);
  if (done && !client.verbose) return;
  client.out +=
      fmt::format("SET {} {}{}", name, done ? "ACK" : "NAK", machine_.old ? "\n\r" : "\r\n");
}

bool LinuxCncRemote::order(
    int id, const std::string& name, const std::string& what, double time_s) {
  Client& client = clients_.at(id);
  const std::string word = upper(what);
  const bool on = word == "ON";
  const bool on_off = on || word == "OFF";
  if (name == "ECHO" || name == "VERBOSE") {
    if (on_off) (name == "ECHO" ? client.echo : client.verbose) = on;
    return on_off;
  }
  if (name == "ENABLE") {
    if (what != machine_.enable && word != "OFF") return false;
    enabled_ = word == "OFF" ? -1 : id;
    return true;
  }
  if (name == (machine_.old ? "SET_WAIT" : "WAIT_MODE")) {
    if (word == "RECEIVED" || word == "DONE") machine_.waits_done = word == "DONE";
    return word == "RECEIVED" || word == "DONE";
  }
  if (name == "ESTOP") {
    if (on) press_estop(time_s);
    if (word == "OFF") machine_.estop = false;
    return on_off;
  }
  if (name == "MACHINE") {
    if (on_off) machine_.on = on && !machine_.estop;
    return on_off;
  }
  if (name == "MODE") {
    const bool known = word == "MANUAL" || word == "AUTO" || word == "MDI";
    if (known) mode_ = word;
    return known;
  }
  if (name == "ABORT") {
    stop(time_s);
    return true;
  }
  if (name == "MDI") {
    if (!mdi(upper(what), time_s)) return true;  // received; what is wrong with it is an error
    if (machine_.waits_done) client.busy_until_s = track_.end_s();
    return true;
  }
  return false;
}

bool LinuxCncRemote::mdi(std::string words, double time_s) {
  if (mode_ != "MDI") {
    error_ = "Must be in MDI mode to issue MDI command";
    return false;
  }
  if (!machine_.homed) {
    error_ = "Can't issue MDI command when not homed";
    return false;
  }
  bool straight = false, absolute = false;
  std::vector<std::pair<std::size_t, double>> targets;
  while (!words.empty()) {
    const std::string word = take_word(words);
    const double number = std::strtod(word.c_str() + 1, nullptr);
    if (word == "G20" || word == "G21") inches_ = word == "G20";
    straight = straight || word == "G1";
    absolute = absolute || word == "G53";
    if (word[0] == 'F') feed_ = number;
    if (const std::size_t axis = kAxes.find(word[0]); axis != std::string_view::npos) {
      targets.emplace_back(axis, number);
    }
  }
  if (!straight) return false;
  if (feed_ <= 0.0) {
    error_ = "Cannot do G1 with zero feed rate";
    return false;
  }
  std::vector<double> to = track_.end();
  for (const auto& [axis, number] : targets) {
    to[axis] = number * (inches_ && axis < 3 ? kInch_mm : 1.0) +
               (absolute ? 0.0 : machine_.work_offset);
    if (to[axis] <= machine_.high && to[axis] >= machine_.low) continue;
    error_ = fmt::format(
        "Linear move on line 0 would exceed joint {}'s {} limit", axis,
        to[axis] > machine_.high ? "positive" : "negative");
    return false;
  }
  ++moves_;
  began_s_ = std::max(time_s + machine_.begins_s, track_.end_s());
  track_.append(to, feed_ / 60.0, began_s_);
  return true;
}

std::string LinuxCncRemote::figures(double time_s, bool in_work_coordinates) const {
  std::vector<double> at = position(time_s);
  std::string text;
  for (std::size_t i = 0; i < at.size(); ++i) {
    if (in_work_coordinates) at[i] -= machine_.work_offset;
    if (i < 3 && machine_.units == "INCH") at[i] /= kInch_mm;
    text += fmt::format("{}{:.6f}", i == 0 ? "" : " ", at[i]);
  }
  return text;
}

std::optional<std::string> LinuxCncRemote::value(
    int id, const std::string& name, double time_s) {
  const auto on_off = [](bool on) { return std::string(on ? "ON" : "OFF"); };
  const Client& client = clients_.at(id);
  if (name == "ECHO") return on_off(client.echo);
  if (name == "VERBOSE") return on_off(client.verbose);
  if (name == "ENABLE") return on_off(id == enabled_);
  if (name == "ESTOP") return on_off(machine_.estop);
  if (name == "MACHINE") return on_off(machine_.on);
  if (name == "MODE") return mode_;
  if (name == "KINEMATICS_TYPE") return std::to_string(machine_.kinematics);
  if (name == "USER_LINEAR_UNITS") return machine_.units;
  if (name == "USER_ANGULAR_UNITS") return "DEG";
  if (name == "PROGRAM_STATUS") {
    if (paused_) return "PAUSED";
    return runs(time_s) ? "RUNNING" : "IDLE";
  }
  if (name == "JOINT_HOMED") {
    return machine_.homed ? "YES YES YES YES YES YES" : "NO NO NO NO NO NO";
  }
  if (name == "ABS_ACT_POS" || name == "JOINT_POS") return figures(time_s, false);
  if (name == "REL_ACT_POS") return figures(time_s, true);
  if (name == "ERROR") {
    return error_.empty() ? "OK" : std::exchange(error_, {});
  }
  return std::nullopt;
}

}  // namespace sixdial::mock_devices
