#include "cli/keys.h"

#include <poll.h>
#include <unistd.h>

#include "service/socket/interruption.h"

namespace sixdial::cli {

Keys::Keys()
    : active_(::isatty(STDIN_FILENO) != 0 && ::tcgetattr(STDIN_FILENO, &before_) == 0) {
  if (!active_) return;
  termios raw = before_;
  raw.c_lflag &= ~static_cast<tcflag_t>(ICANON | ECHO);
  service::restore_terminal_at_end(&before_);
  ::tcsetattr(STDIN_FILENO, TCSANOW, &raw);
}

Keys::~Keys() {
  if (!active_) return;
  ::tcsetattr(STDIN_FILENO, TCSANOW, &before_);
  service::restore_terminal_at_end(nullptr);
}

char Keys::pressed() const {
  pollfd ready{.fd = STDIN_FILENO, .events = POLLIN, .revents = 0};
  char key = 0;
  if (!active_ || ::poll(&ready, 1, 0) <= 0 || ::read(STDIN_FILENO, &key, 1) != 1) return 0;
  return key;
}

}  // namespace sixdial::cli
