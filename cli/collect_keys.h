// Which single key commands a running collection in a terminal. A letter may be struck by
// chance: what stops, leaves out or takes back is asked first.
//
// Example:
//   CollectKeys keys;
//   keys.press('q').question;  // -> "Stop collecting? y: yes, any other key: no"
//   keys.press('y').method;    // -> "collect.stop"
#pragma once

#include <string>
#include <string_view>

namespace sixdial::cli {

inline constexpr const char* kKeyHelp =
    "keys: p pause, c continue, r retake, s skip, a accept, m moved, h halt the robot, q stop";

class CollectKeys {
 public:
  struct Answer {
    const char* method = nullptr;  // RPC method to call now
    std::string_view said{};       // what that does, for people
    std::string question{};        // to show; the next key answers it
    bool refused = false;          // a question was answered with no
  };
  /// `key` 0: none was pressed; a question stays open.
  [[nodiscard]] Answer press(char key);

 private:
  char asked_ = 0;  // key whose question is open
};

}  // namespace sixdial::cli
