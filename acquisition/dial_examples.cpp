#include "acquisition/dial_examples.h"

#include <fmt/format.h>

#include "geometry/rig.h"

namespace sixdial::acquisition {
namespace {

char letter(Parity parity) {
  switch (parity) {
    case Parity::kNone:
      return 'N';
    case Parity::kEven:
      return 'E';
    case Parity::kOdd:
      return 'O';
  }
  return '?';
}

constexpr const char* kRobot = R"(
[robot]
model = "five_bar"
working_mode = "++"        # elbow side of leg 1 and leg 2: "+" turns the proximal link counter-clockwise from the line base joint -> end-effector
assembly = 1               # beta: +1 takes the intersection to the left of the vector O3 -> O4
)";

/// The robot's parameters by their keys, a line each.
std::string parameter_lines(const geometry::Robot& robot) {
  std::string text;
  for (std::size_t i = 0; i < robot.model->parameters.size(); ++i) {
    const geometry::ParameterInfo& info = robot.model->parameters[i];
    text += fmt::format(
        "{} = {:.1f}\n", info.rig_key,
        robot.nominal[static_cast<Eigen::Index>(i)] * info.shown_per_unit);
  }
  return text;
}

constexpr const char* kCuboidAndDials = R"(
[cuboid]
side_mm = 80.0
mount = "distal2"          # turns with the distal link of leg 2; gamma = 0 at reference_pose
reference_pose_mm = [28.0, 48.0]
side_sd_mm = 0.005         # how well it is known, as a standard deviation: doc/manual/mounting.md
squareness_sd_deg = 0.02
offset_sd_mm = 0.02

[dials]
position_sd_mm = [0.03, 0.1] # how well their places are known: along the axis, across it
axis_sd_deg = 0.1
travel_mm = 50.8
resolution_mm = 0.001
accuracy_mm = 0.006          # largest error by its maker
repeatability_mm = 0.002     # standard deviation of one reading at rest
tip_radius_mm = 1.5
force_n = 1.0              # measuring force at zero displacement
spring_n_per_mm = 0.03
)";

/// Where the `number`-th dial is, counted from 0: a cable of its own, or a channel.
std::string connection_of(const DialProtocol& protocol, int number) {
  const int serial = protocol.example_serial + (protocol.channels == 0 ? number : 0);
  std::string text = fmt::format(
      "serial:/dev/serial/by-id/usb-{}_{}-if00-port0?dialect={}", protocol.example_port, serial,
      protocol.name);
  if (protocol.channels > 0) text += fmt::format("&channel={}", number + 1);
  return text;
}

/// Lines of text as lines of a comment.
std::string commented(std::string_view text) {
  std::string out;
  while (!text.empty()) {
    const std::size_t end = text.find('\n');
    out += fmt::format("# {}\n", text.substr(0, end));
    text.remove_prefix(end == std::string_view::npos ? text.size() : end + 1);
  }
  return out;
}

/// A control character as people write it.
std::string escaped(std::string_view text) {
  std::string out;
  for (const char c : text) {
    if (c == '\r') {
      out += "\\r";
    } else if (c == '\n') {
      out += "\\n";
    } else {
      out += c;
    }
  }
  return out;
}

}  // namespace

std::string in_words(const LineSettings& line) {
  return fmt::format(
      "{} baud {}{}{}", line.baud, line.data_bits, letter(line.parity), line.stop_bits);
}

std::string example_rig(const DialProtocol& protocol) {
  const bool by_hand = protocol.channels == 0;
  std::string text = fmt::format(
      "# Six {} ({}, {}){}.\n", protocol.wiring, protocol.maker, in_words(protocol.line),
      by_hand ? ", the robot moved by hand" : "");
  text += commented(protocol.advice);
  text += "# Lengths in mm, angles in degrees. Try it: sixdial rig scan --rig THIS_FILE\n";
  text += fmt::format("name = \"five-bar rig, {}\"\n", protocol.name);
  const geometry::Rig rig = geometry::default_rig();
  text += kRobot + parameter_lines(rig.robot);
  text += by_hand ? "connection = \"manual\"   # a person moves it and confirms\n"
                  : "connection = \"modbus-tcp://192.0.2.20:502?unit=1\"   # its controller: "
                    "doc/devices.md\n";
  text += kCuboidAndDials;
  for (std::size_t i = 0; i < rig.dials.size(); ++i) {
    const geometry::DialGeometry& dial = rig.dials[i].geometry;
    text += fmt::format(
        "\n[[dial]]\nid = \"{}\"\nconnection = \"{}\"\nposition_mm = [{}, {}]   # front of the "
        "tip at zero displacement\naxis = [{}, {}]              # from the dial towards the "
        "cuboid; displacement > 0 is pushed in\n",
        rig.dials[i].id, connection_of(protocol, static_cast<int>(i)), dial.position_mm.x(),
        dial.position_mm.y(), dial.axis.x(), dial.axis.y());
  }
  return text;
}

std::string dial_table() {
  std::string text =
      "| dialect | dials | line | asks | answers end with | example "
      "|\n|---|---|---|---|---|---|\n";
  for (const DialProtocol* each : dial_protocols()) {
    text += fmt::format(
        "| `{0}` | {1}: {2} | {3} | `{4}` | `{5}` | [{0}.toml](../examples/rigs/{0}.toml) |\n",
        each->name, each->maker, each->wiring, in_words(each->line),
        escaped(each->request(each->channels > 0 ? 1 : 0)), escaped(each->frame_end));
  }
  return text;
}

}  // namespace sixdial::acquisition
