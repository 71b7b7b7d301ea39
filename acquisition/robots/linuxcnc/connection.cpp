// Connection strings of robots that LinuxCNC moves, by its remote:
//
//   linuxcnc:10.0.0.7:5007?axes=X,Y,Z&feed=1200
//   linuxcnc:cnc.local?password=EMC&enable=EMCTOO
#include <algorithm>
#include <array>
#include <utility>

#include "acquisition/connection_text.h"
#include "acquisition/robot_driver.h"
#include "acquisition/robots/linuxcnc/robot.h"
#include "acquisition/robots/open_robot.h"

namespace sixdial::acquisition {
namespace {

/// One word: it stands between blanks.
std::string password(
    const ConnectionOptions& options, const std::string& key, const std::string& otherwise) {
  std::string word = options.text(key, otherwise);
  const bool good = !word.empty() && word.size() < 16 &&
                    std::ranges::all_of(word, [](char c) { return c > ' ' && c < '\x7f'; });
  if (!good) refuse("{} is no word of up to 15 letters without blanks", key);
  return word;
}

OpenRobot parse(std::string_view rest, std::span<const RobotJoint> joints) {
  static constexpr std::array<std::string_view, 6> kKeys{"axes",       "feed",     "arrived",
                                                         "timeout_ms", "password", "enable"};
  const ConnectionPieces pieces = split(rest);
  const std::string_view place = without_slashes(pieces.place);
  if (place.empty()) refuse("no host is given; write linuxcnc:HOST:{}", kCncPort);
  const ModbusTcpEndpoint endpoint = tcp_endpoint(place, kCncPort);
  const ConnectionOptions options(pieces.query, kKeys);
  AxisSettings settings = axis_settings(options, joints, kCncAxes, name_of(endpoint));
  CncPasswords usual;
  const CncPasswords passwords{
      .connect = password(options, "password", usual.connect),
      .enable = password(options, "enable", usual.enable)};
  const AxisRobot::Open open = [endpoint, timeout = settings.timeout] {
    return open_tcp_lines(endpoint, timeout);
  };
  return opens<LinuxCncRobot>(joints, std::move(settings), passwords, open);
}

}  // namespace

extern constinit const RobotDriver linuxcnc_robot{
    .scheme = "linuxcnc",
    .form = "linuxcnc:HOST:PORT",
    .in_words = "LinuxCNC with trivial kinematics, by its remote linuxcncrsh (port 5007)",
    .options =
        "`axes=X,Y,Z`, `feed` (deg or mm a minute), `arrived`, `timeout_ms`, `password`, "
        "`enable`",
    .parse = parse};

}  // namespace sixdial::acquisition
