#include "acquisition/port_rights.h"

#include <fmt/format.h>
#include <grp.h>
#include <pwd.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <vector>

namespace sixdial::acquisition {
namespace {

constexpr mode_t kReadAndWrite = S_IRGRP | S_IWGRP;
constexpr const char* kUsualGroup = "dialout";

bool user_is_in_group(gid_t wanted) {
  const passwd* user = ::getpwuid(::getuid());
  if (user == nullptr) return false;
  std::vector<gid_t> groups(256);
  int count = static_cast<int>(groups.size());
  if (::getgrouplist(user->pw_name, user->pw_gid, groups.data(), &count) < 0) return false;
  groups.resize(static_cast<std::size_t>(count));
  return std::ranges::find(groups, wanted) != groups.end();
}

}  // namespace

PortGroup group_of_port(const std::string& device) {
  PortGroup found;
  struct stat about {};
  if (::stat(device.c_str(), &about) != 0) return found;
  const group* entry = ::getgrgid(about.st_gid);
  if (entry != nullptr) found.name = entry->gr_name;
  found.is_root = about.st_gid == 0;
  found.may_open = (about.st_mode & kReadAndWrite) == kReadAndWrite;
  found.user_is_in = user_is_in_group(about.st_gid);
  return found;
}

std::string rights_advice(const PortGroup& group) {
  constexpr const char* kService =
      "the user of the service needs the same (systemctl cat sixdiald shows who that is)";
  if (group.may_open && !group.is_root && !group.name.empty()) {
    if (group.user_is_in) {
      return fmt::format(
          "you are in the group {} since your last login: log out and in again (or: newgrp "
          "{}); "
          "start the service again, too",
          group.name, group.name);
    }
    return fmt::format(
        "sudo usermod -aG {} $USER, then log out and in again; {}", group.name, kService);
  }
  // Nobody should be made a member of root's group for a dial.
  return fmt::format(
      "give serial ports to the group {0}: echo 'SUBSYSTEM==\"tty\", GROUP=\"{0}\", "
      "MODE=\"0660\"' | sudo tee /etc/udev/rules.d/70-sixdial.rules; sudo udevadm control "
      "--reload; sudo udevadm trigger; then sudo usermod -aG {0} $USER, log out and in again; "
      "{1}",
      kUsualGroup, kService);
}

std::string rights_advice(const std::string& device) {
  return rights_advice(group_of_port(device));
}

}  // namespace sixdial::acquisition
