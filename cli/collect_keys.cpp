#include "cli/collect_keys.h"

#include <algorithm>
#include <array>
#include <string_view>
#include <utility>

namespace sixdial::cli {
namespace {

struct Key {
  char letter;
  const char* method;
  std::string_view said;
  std::string_view question{};  // empty: does it at once
};

constexpr std::array kKeys{
    Key{'p', "collect.pause", "pausing after this point"},
    Key{'c', "collect.resume", "going on with the plan"},
    Key{'a', "collect.accept", "stored with the fault"},
    Key{'h', "robot.stop", "the robot is told to stop; the collection pauses"},
    Key{'m', "collect.moved", "the robot is there"},
    Key{'r', "collect.retake", "measuring it again",
        "Withdraw this sample and measure it again?"},
    Key{'s', "collect.skip", "leaving this point out", "Leave this point out?"},
    Key{'q', "collect.stop", "stopping; what is stored stays", "Stop collecting?"}};

}  // namespace

CollectKeys::Answer CollectKeys::press(char key) {
  if (key == 0) return {};
  const char asked = std::exchange(asked_, '\0');
  if (asked != 0 && key != 'y') return {.refused = true};
  const auto* found = std::ranges::find(kKeys, asked != 0 ? asked : key, &Key::letter);
  if (found == kKeys.end()) return {};
  if (asked != 0 || found->question.empty()) {
    return {.method = found->method, .said = found->said};
  }
  asked_ = key;
  return {.question = std::string(found->question) + " y: yes, any other key: no"};
}

}  // namespace sixdial::cli
