// What is said between the service and linuxcncrsh: greeting, questions, orders.
#include <fmt/format.h>

#include <algorithm>

#include "acquisition/robots/linuxcnc/robot.h"

namespace sixdial::acquisition {
namespace {

std::string upper(std::string_view text) {
  std::string result(text);
  for (char& c : result) {
    if (c >= 'a' && c <= 'z') c = static_cast<char>(c - 'a' + 'A');
  }
  return result;
}

RobotFault controller(std::string words) {
  return {RobotFaultKind::kController, std::move(words)};
}

}  // namespace

tl::expected<CncLine, RobotFault> LinuxCncRobot::line_by(
    WallTime deadline, std::string_view asked, const std::stop_token& stop) {
  auto line =
      hear(deadline, stop, parse_linuxcnc, "line of linuxcncrsh: look at host and port");
  if (!line) return tl::unexpected(line.error());
  if (!*line) return tl::unexpected(silent(asked));
  return **std::move(line);
}

tl::expected<void, RobotFault> LinuxCncRobot::set(
    std::string_view name, std::string_view what, const std::stop_token& stop) {
  const std::string asked =
      what.empty() ? fmt::format("set {}", name) : fmt::format("set {} {}", name, what);
  in_step_ = false;
  if (const auto told = tell(asked + "\n"); !told) return told;
  // Nobody needs to read a password in a log.
  const std::string shown = name == "enable" ? "set enable" : asked;
  const std::string answer = upper(name);
  const auto deadline = answer_by();
  for (;;) {
    const auto line = line_by(deadline, shown, stop);
    if (!line) return tl::unexpected(line.error());
    const bool ack = line->kind == CncLineKind::kAck && line->name == answer;
    const bool is_error = line->kind == CncLineKind::kError;
    const bool nak =
        line->kind == CncLineKind::kNak && (line->name == answer || line->name.empty());
    if (!ack && !nak && !is_error) continue;
    in_step_ = true;
    if (ack) return {};
    return tl::unexpected(controller(
        nak ? fmt::format("{} is refused (NAK)", shown)
            : fmt::format("{} is answered with error: {}", shown, line->rest)));
  }
}

tl::expected<LinuxCncRobot::Values, RobotFault> LinuxCncRobot::get(
    std::span<const std::string_view> names, const std::stop_token& stop) {
  std::string asked;
  for (const std::string_view name : names) asked += fmt::format("get {}\n", name);
  in_step_ = false;
  if (const auto told = tell(asked); !told) return tl::unexpected(told.error());
  const auto deadline = answer_by();
  Values values;
  while (values.size() < names.size()) {
    const std::string next = fmt::format("get {}", names[values.size()]);
    auto line = line_by(deadline, next, stop);
    if (!line) return tl::unexpected(line.error());
    const std::string wanted = upper(names[values.size()]);
    if (line->kind == CncLineKind::kValue && line->name == wanted) {
      values[wanted] = std::move(line->rest);
    } else if (line->kind == CncLineKind::kNak && line->name == wanted) {
      close_channel();  // the other answers are still under way
      return tl::unexpected(controller(next + " is refused (NAK)"));
    } else if (line->kind == CncLineKind::kError) {
      close_channel();
      return tl::unexpected(
          controller(fmt::format("{} is answered with error: {}", next, line->rest)));
    }
  }
  in_step_ = true;
  return values;
}

// After an exchange that was broken off: "get echo" is asked here only, and what comes before
// its answer is old.
tl::expected<void, RobotFault> LinuxCncRobot::come_into_step(const std::stop_token& stop) {
  static constexpr std::array<std::string_view, 1> kNames{"echo"};
  const auto values = get(kNames, stop);
  if (!values) return tl::unexpected(values.error());
  return {};
}

tl::expected<void, RobotFault> LinuxCncRobot::hello(const std::stop_token& stop) {
  if (const auto told = tell(fmt::format("hello {} Sixdial 1.0\n", passwords_.connect));
      !told) {
    return told;
  }
  const auto deadline = answer_by();
  for (;;) {
    const auto line = line_by(deadline, "hello", stop);
    if (!line) return tl::unexpected(line.error());
    if (line->name != "HELLO") continue;
    if (line->kind == CncLineKind::kAck) break;
    return tl::unexpected(controller(
        "linuxcncrsh refuses the connection (HELLO NAK): give its --connectpw as password="));
  }
  // Without echoes, and with an answer to each order.
  if (const auto told = tell("set echo off\n"); !told) return told;
  if (const auto done = set("verbose", "on", stop); !done) return done;
  if (const auto done = set("enable", passwords_.enable, stop); !done) {
    if (done.error().kind != RobotFaultKind::kController) return done;
    return tl::unexpected(controller(
        done.error().detail + ": give linuxcncrsh's --enablepw as enable= in the rig file"));
  }
  // Orders are acknowledged once they are taken, so that a move can be looked at and stopped.
  auto taken = set("wait_mode", "received", stop);
  if (!taken && taken.error().kind == RobotFaultKind::kController) {
    taken = set("set_wait", "received", stop);  // its name before version 2.10
  }
  return taken;
}

tl::expected<void, RobotFault> LinuxCncRobot::learn_units(const std::stop_token& stop) {
  static constexpr std::array<std::string_view, 3> kNames{
      "kinematics_type", "user_linear_units", "user_angular_units"};
  const auto values = get(kNames, stop);
  if (!values) return tl::unexpected(values.error());
  const std::string& kinematics = values->at("KINEMATICS_TYPE");
  if (kinematics != "1") {
    return tl::unexpected(controller(fmt::format(
        "its kinematics are of type {}, so that X, Y, Z are no joints: joint values can be "
        "commanded with trivkins only (KINEMATICS in the section [KINS] of its INI file)",
        kinematics)));
  }
  const auto linear = cnc_unit(values->at("USER_LINEAR_UNITS"));
  const auto angular = cnc_unit(values->at("USER_ANGULAR_UNITS"));
  if (!linear || !angular) {
    return tl::unexpected(controller(fmt::format(
        "its units are {} and {}: set LINEAR_UNITS and ANGULAR_UNITS in the section [TRAJ] of "
        "its INI file to mm and degree",
        values->at("USER_LINEAR_UNITS"), values->at("USER_ANGULAR_UNITS"))));
  }
  linear_ = *linear;
  angular_ = *angular;
  return {};
}

tl::expected<void, RobotFault> LinuxCncRobot::ready(const std::stop_token& stop) {
  const auto fresh = open_channel();
  if (!fresh) return tl::unexpected(fresh.error());
  if (!*fresh) return in_step_ ? OrFault<void>() : come_into_step(stop);
  auto met = hello(stop).and_then([&] { return learn_units(stop); });
  if (!met) close_channel();  // from the beginning the next time
  return met;
}

tl::expected<std::vector<double>, RobotFault> LinuxCncRobot::stands_at(
    const std::string& text) {
  const auto figures = cnc_figures(text);
  if (!figures || figures->size() < kCncAxes.size()) {
    return tl::unexpected(stranger("ABS_ACT_POS " + text, "position of six axes"));
  }
  std::vector<double> values;
  for (const char letter : settings_.axes) {
    const std::size_t i = kCncAxes.find(letter);
    values.push_back((*figures)[i] * (i < 3 ? linear_ : angular_));
  }
  return values;
}

std::optional<RobotFault> LinuxCncRobot::locked(const Values& values) const {
  if (values.at("ESTOP") != "OFF") {
    return controller(
        "its emergency stop is on: look at the machine, then release it and switch the machine "
        "on (F1, F2, or: set estop off, set machine on)");
  }
  if (values.at("MACHINE") != "ON") {
    return controller(
        "it is switched off: look at the machine, then switch it on (F2, or: set machine on)");
  }
  const std::vector<std::string> homed = cnc_words(values.at("JOINT_HOMED"));
  for (std::size_t j = 0; j < joints_.size(); ++j) {
    const std::string word = j < homed.size() ? upper(homed[j]) : "not told";
    if (word == "YES" || word == "HOMED") continue;
    return controller(fmt::format("its joint {} is not homed: home the machine", j));
  }
  return std::nullopt;
}

tl::expected<LinuxCncRobot::Look, RobotFault> LinuxCncRobot::look(const std::stop_token& stop) {
  static constexpr std::array<std::string_view, 6> kNames{
      "estop", "machine", "joint_homed", "program_status", "abs_act_pos", "error"};
  const auto values = get(kNames, stop);
  if (!values) return tl::unexpected(values.error());
  auto stands = stands_at(values->at("ABS_ACT_POS"));
  if (!stands) return tl::unexpected(stands.error());
  Look seen{.stands = *std::move(stands)};
  const std::string& program = values->at("PROGRAM_STATUS");
  if (program == "RUNNING") {
    seen.program = Program::kRunning;
  } else if (program == "PAUSED") {
    seen.program = Program::kPaused;
  } else if (program != "IDLE") {
    return tl::unexpected(stranger("PROGRAM_STATUS " + program, "state of a program"));
  }
  seen.locked = locked(*values);
  if (values->at("ERROR") != "OK") seen.error = values->at("ERROR");
  return seen;
}

}  // namespace sixdial::acquisition
