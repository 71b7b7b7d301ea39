// Any text as a connection string: accepted, or refused in words.
#include <cstdint>
#include <cstdlib>
#include <string_view>
#include <vector>

#include "acquisition/connection.h"
#include "acquisition/robot_driver.h"

using namespace sixdial::acquisition;

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const std::string_view text(reinterpret_cast<const char*>(data), size);
  const auto dial = parse_dial_connection(text);
  if (!dial && dial.error().empty()) std::abort();
  static const std::vector<RobotJoint> joints{{"theta1", true}, {"slide", false}};
  const auto robot = parse_robot_connection(text, joints);
  if (!robot && robot.error().empty()) std::abort();
  return 0;
}
