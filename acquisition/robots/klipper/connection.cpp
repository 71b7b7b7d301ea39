// Connection strings of robots that Klipper moves, by the socket of its API server:
//
//   klipper:/home/pi/printer_data/comms/klippy.sock?axes=X,Y,Z&feed=1200
#include <array>
#include <utility>

#include "acquisition/connection_text.h"
#include "acquisition/robot_driver.h"
#include "acquisition/robots/klipper/robot.h"
#include "acquisition/robots/open_robot.h"

namespace sixdial::acquisition {
namespace {

OpenRobot parse(std::string_view rest, std::span<const RobotJoint> joints) {
  static constexpr std::array<std::string_view, 4> kKeys{
      "axes", "feed", "arrived", "timeout_ms"};
  const ConnectionPieces pieces = split(rest);
  if (!pieces.place.starts_with('/')) {
    refuse(
        "'{}' is not the whole path of a socket; write klipper:/run/klipper/klippy.sock, as "
        "given to klippy.py -a",
        pieces.place);
  }
  const std::string path(pieces.place);
  const ConnectionOptions options(pieces.query, kKeys);
  AxisSettings settings = axis_settings(options, joints, kKlipperAxes, path);
  const AxisRobot::Open open = [path, timeout = settings.timeout] {
    return open_unix_messages(path, kKlipperEnd, kLongestKlipperMessage, timeout);
  };
  return opens<KlipperRobot>(joints, std::move(settings), open);
}

}  // namespace

extern constinit const RobotDriver klipper_robot{
    .scheme = "klipper",
    .form = "klipper:SOCKET",
    .in_words = "Klipper, by the socket of its API server (klippy.sock, klippy_uds)",
    .options = "`axes=X,Y,Z`, `feed` (deg or mm a minute), `arrived`, `timeout_ms`",
    .parse = parse};

}  // namespace sixdial::acquisition
