// Single keys without Enter, as long as a command looks at them.
#pragma once

#include <termios.h>

namespace sixdial::cli {

/// Nothing where stdin is no terminal. The terminal is as before when it ends, however it ends.
class Keys {
 public:
  Keys();
  ~Keys();
  Keys(const Keys&) = delete;
  Keys& operator=(const Keys&) = delete;

  [[nodiscard]] bool active() const { return active_; }
  /// 0: none was pressed.
  [[nodiscard]] char pressed() const;

 private:
  termios before_{};
  bool active_;
};

}  // namespace sixdial::cli
