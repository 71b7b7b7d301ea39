// Connection strings of robots that take G-code:
//
//   gcode-serial:/dev/serial/by-id/...?dialect=grbl&axes=X,Y,Z&baud=115200
//   gcode-tcp:10.0.0.7:23?dialect=marlin&axes=X,Y,Z&feed=1200
#include <array>
#include <utility>
#include <vector>

#include "acquisition/connection_text.h"
#include "acquisition/robot_driver.h"
#include "acquisition/robots/gcode_robot.h"
#include "acquisition/robots/open_robot.h"

namespace sixdial::acquisition {
namespace {

using std::chrono::milliseconds;

const GcodeDialect* dialect_of(const ConnectionOptions& options) {
  std::vector<std::string_view> dialects;
  for (const GcodeDialect* dialect : gcode_dialects()) dialects.push_back(dialect->name);
  if (!options.has("dialect")) {
    refuse("no dialect is given; add ?dialect= one of {}", fmt::join(dialects, ", "));
  }
  const std::string name = options.text("dialect", "");
  const GcodeDialect* const dialect = find_gcode_dialect(name);
  if (dialect == nullptr) {
    refuse(
        "unknown dialect '{}'; did you mean '{}'? (known: {})", name, nearest(name, dialects),
        fmt::join(dialects, ", "));
  }
  return dialect;
}

milliseconds boot_of(const ConnectionOptions& options, int usual_ms) {
  return milliseconds(options.whole("boot_ms", usual_ms, 0, 60'000));
}

OpenRobot parse_serial(std::string_view rest, std::span<const RobotJoint> joints) {
  static constexpr std::array<std::string_view, 7> kKeys{
      "dialect", "axes", "feed", "arrived", "timeout_ms", "boot_ms", "baud"};
  const ConnectionPieces pieces = split(rest);
  const std::string device = device_path(pieces.place);
  const ConnectionOptions options(pieces.query, kKeys);
  const GcodeDialect* const dialect = dialect_of(options);
  AxisSettings settings = axis_settings(options, joints, kGcodeAxes, device);
  const milliseconds boot = boot_of(options, 4000);
  const LineSettings line{.baud = options.whole("baud", dialect->baud, 300, 4'000'000)};
  const AxisRobot::Open open = [device, line] { return open_serial_lines(device, line); };
  return opens<GcodeRobot>(joints, std::move(settings), dialect, boot, open);
}

OpenRobot parse_tcp(std::string_view rest, std::span<const RobotJoint> joints) {
  static constexpr std::array<std::string_view, 6> kKeys{"dialect", "axes",       "feed",
                                                         "arrived", "timeout_ms", "boot_ms"};
  const ConnectionPieces pieces = split(rest);
  const std::string_view place = without_slashes(pieces.place);
  const ModbusTcpEndpoint endpoint = tcp_endpoint(place, 0);
  if (endpoint.port == 0) refuse("'{}' has no port; write gcode-tcp:HOST:PORT", place);
  const ConnectionOptions options(pieces.query, kKeys);
  const GcodeDialect* const dialect = dialect_of(options);
  AxisSettings settings = axis_settings(options, joints, kGcodeAxes, name_of(endpoint));
  const milliseconds boot = boot_of(options, 1500);
  const AxisRobot::Open open = [endpoint, timeout = settings.timeout] {
    return open_tcp_lines(endpoint, timeout);
  };
  return opens<GcodeRobot>(joints, std::move(settings), dialect, boot, open);
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
