#include "session/reason_words.h"

#include <algorithm>
#include <array>

#include "session/reason.h"

namespace sixdial::session {
namespace {

struct Words {
  std::string_view reason, brief, sentence;
};
constexpr std::array kWords{
    Words{reason::kTimeout, "no answer", "the dial does not answer in time"},
    Words{reason::kDisconnected, "cable out", "the port or the connection is gone"},
    Words{reason::kBadFrame, "unreadable", "what the dial sends cannot be read"},
    Words{reason::kWrongChannel, "other dial", "another dial answers than was asked"},
    Words{reason::kRange, "out of range", "the value is outside of the dial's travel"},
    Words{reason::kUnit, "in inches", "the dial shows inches"},
    Words{reason::kDevice, "dial's error", "the dial reports an error of its own"},
    Words{reason::kNoDial, "no data", "no dial is there, or it has no value to give"},
    Words{reason::kBusy, "busy", "the dial is busy"},
    Words{reason::kWrongDial, "replaced", "another dial is on this cable than before"},
    Words{reason::kStale, "old value", "the newest value is too old"},
    Words{reason::kNoContact, "no contact", "the plunger touches nothing"},
    Words{reason::kUnsettled, "unsettled", "the reading did not come to rest"},
    Words{reason::kLowBattery, "low battery", "the dial asks for a new battery"},
    Words{
        reason::kImplausible, "implausible", "the value is far from where the robot should be"},
    Words{reason::kFrozen, "frozen", "the value has not moved though the robot has"}};

const Words* words_of(std::string_view reason) {
  const auto* found = std::ranges::find(kWords, reason, &Words::reason);
  return found == kWords.end() ? nullptr : found;
}

}  // namespace

std::string_view brief_words(std::string_view reason) {
  const Words* words = words_of(reason);
  return words == nullptr ? reason : words->brief;
}

std::string_view reason_words(std::string_view reason) {
  const Words* words = words_of(reason);
  return words == nullptr ? reason : words->sentence;
}

}  // namespace sixdial::session
