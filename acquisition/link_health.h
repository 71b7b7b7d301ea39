// The state of one cable: ok, suspect after an error, down after several or when it is out; and
// when to try again, 0.2 s to 10 s, doubling. Times are device time.
#pragma once

#include <cstdint>
#include <string_view>

#include "acquisition/clock.h"

namespace sixdial::acquisition {

enum class LinkState { kOk, kSuspect, kDown };
[[nodiscard]] std::string_view to_string(LinkState state);

inline constexpr std::chrono::milliseconds kFirstBackOff{200};
inline constexpr std::chrono::milliseconds kLongestBackOff{10'000};
/// This many bad answers in a row take a link from suspect to down.
inline constexpr int kSuspectLimit = 3;

class LinkHealth {
 public:
  /// A good answer.
  void good();
  /// No answer or a bad one, on a line that is there.
  void bad(DeviceTime now);
  /// The line is gone, or could not be opened.
  void lost(DeviceTime now);

  [[nodiscard]] LinkState state() const { return state_; }
  /// Earliest time to try again; in the past while the link is ok.
  [[nodiscard]] DeviceTime next_try() const { return next_try_; }

 private:
  void back_off(DeviceTime now);

  LinkState state_ = LinkState::kDown;
  int bad_in_a_row_ = 0;
  DeviceTime wait_ = kFirstBackOff;
  DeviceTime next_try_{0};
};

}  // namespace sixdial::acquisition
