// Who may open a serial port, and what to do where this user may not. Independent of how the
// program was installed: a port's group is asked of the system, and where the group could not
// help (root's, or one without rights) a rule for udev gives the ports to a group that can.
#pragma once

#include <string>

namespace sixdial::acquisition {

/// What the system says about a port's group.
struct PortGroup {
  std::string name;       // "dialout"; empty: it has no name
  bool may_open = false;  // the group has the rights to read and write
  bool is_root = false;
  bool user_is_in = false;  // by the system's list, if perhaps not since the last login
};
[[nodiscard]] PortGroup group_of_port(const std::string& device);
/// What to do, as commands.
[[nodiscard]] std::string rights_advice(const PortGroup& group);
[[nodiscard]] std::string rights_advice(const std::string& device);

}  // namespace sixdial::acquisition
