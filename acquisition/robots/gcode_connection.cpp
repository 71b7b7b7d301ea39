// Connection strings of robots that take G-code:
//
//   gcode-serial:/dev/serial/by-id/...?dialect=grbl&axes=X,Y,Z&baud=115200
//   gcode-tcp:10.0.0.7:23?dialect=marlin&axes=X,Y,Z&feed=1200
#include <array>
#include <vector>

#include "acquisition/connection_text.h"
#include "acquisition/robot_driver.h"
#include "acquisition/robots/axis_robot.h"
#include "acquisition/robots/gcode_robot.h"

namespace sixdial::acquisition {
namespace {

using std::chrono::milliseconds;

GcodeSettings settings_of(
    const ConnectionOptions& options, std::span<const RobotJoint> joints, milliseconds boot) {
  std::vector<std::string_view> dialects;
  for (const GcodeDialect* dialect : gcode_dialects()) dialects.push_back(dialect->name);
  if (!options.has("dialect")) {
    refuse("no dialect is given; add ?dialect= one of {}", fmt::join(dialects, ", "));
  }
  const std::string name = options.text("dialect", "");
  GcodeSettings settings{
      .dialect = find_gcode_dialect(name), .axes = axis_letters(options, joints, kGcodeAxes)};
  if (settings.dialect == nullptr) {
    refuse(
        "unknown dialect '{}'; did you mean '{}'? (known: {})", name, nearest(name, dialects),
        fmt::join(dialects, ", "));
  }
  settings.feed = options.number("feed", settings.feed);
  settings.arrived = options.number("arrived", settings.arrived);
  if (settings.feed < 0) refuse("feed={} is not above 0", settings.feed);
  if (settings.arrived < 0) refuse("arrived={} is not above 0", settings.arrived);
  settings.timeout = milliseconds(options.whole("timeout_ms", 2000, 100, 60'000));
  settings.boot =
      milliseconds(options.whole("boot_ms", static_cast<int>(boot.count()), 0, 60'000));
  return settings;
}

OpenRobot made(
    GcodeSettings settings, std::span<const RobotJoint> joints, GcodeRobot::Open open) {
  return [settings = std::move(settings), own = std::vector(joints.begin(), joints.end()),
          open = std::move(open)](const RobotSite& site) {
    return std::make_unique<GcodeRobot>(settings, own, open, site.clock);
  };
}

OpenRobot parse_serial(std::string_view rest, std::span<const RobotJoint> joints) {
  static constexpr std::array<std::string_view, 7> kKeys{
      "dialect", "axes", "feed", "arrived", "timeout_ms", "boot_ms", "baud"};
  const ConnectionPieces pieces = split(rest);
  const std::string device = device_path(pieces.place);
  const ConnectionOptions options(pieces.query, kKeys);
  GcodeSettings settings = settings_of(options, joints, milliseconds(4000));
  settings.place = device;
  const LineSettings line{
      .baud = options.whole("baud", settings.dialect->baud, 300, 4'000'000)};
  return made(
      std::move(settings), joints, [device, line] { return open_serial_lines(device, line); });
}

OpenRobot parse_tcp(std::string_view rest, std::span<const RobotJoint> joints) {
  static constexpr std::array<std::string_view, 6> kKeys{"dialect", "axes",       "feed",
                                                         "arrived", "timeout_ms", "boot_ms"};
  ConnectionPieces pieces = split(rest);
  if (pieces.place.starts_with("//")) pieces.place.remove_prefix(2);
  const std::size_t host_end = pieces.place.find(']');  // of [v6]:port
  if (pieces.place.find(':', host_end == std::string_view::npos ? 0 : host_end) ==
      std::string_view::npos) {
    refuse("'{}' has no port; write gcode-tcp:HOST:PORT", pieces.place);
  }
  const ModbusTcpEndpoint endpoint = tcp_endpoint(pieces.place);
  const ConnectionOptions options(pieces.query, kKeys);
  GcodeSettings settings = settings_of(options, joints, milliseconds(1500));
  settings.place = name_of(endpoint);
  const auto timeout = settings.timeout;
  return made(std::move(settings), joints, [endpoint, timeout] {
    return open_tcp_lines(endpoint, timeout);
  });
}

constexpr std::string_view kOptions =
    "`dialect` (needed), `axes=X,Y,Z`, `feed` (deg or mm a minute), `arrived`, `timeout_ms`, "
    "`boot_ms`";
constexpr std::string_view kSerialOptions =
    "`dialect` (needed), `axes=X,Y,Z`, `feed` (deg or mm a minute), `arrived`, `timeout_ms`, "
    "`boot_ms`, `baud`";

}  // namespace

extern constinit const RobotDriver gcode_serial_robot{
    .scheme = "gcode-serial",
    .form = "gcode-serial:DEVICE?dialect=DIALECT",
    .in_words = "a controller that takes G-code, on a serial line",
    .options = kSerialOptions,
    .parse = parse_serial};

extern constinit const RobotDriver gcode_tcp_robot{
    .scheme = "gcode-tcp",
    .form = "gcode-tcp:HOST:PORT?dialect=DIALECT",
    .in_words = "the same on a TCP port (a serial server, grblHAL, FluidNC)",
    .options = kOptions,
    .parse = parse_tcp};

}  // namespace sixdial::acquisition
