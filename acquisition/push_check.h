// "Push each dial with a finger": whether the right letter moves, the right way and by
// millimetres. Takes the readings as they come; who shows it tells the person which dial is
// asked for. The cuboid is away from the dials meanwhile.
#pragma once

#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "acquisition/reading.h"
#include "geometry/rig.h"

namespace sixdial::acquisition {

enum class PushVerdict {
  kOpen,      // not pushed yet
  kGood,      // it moved alone, inwards is positive, by about its travel
  kOther,     // another letter moved: exchanged cables or channels
  kTogether,  // several moved: not one finger, or one value under several letters
  kReversed,  // inwards counts down
  kInch,      // by a 25th of its travel: it shows inches
  kShort,     // by less than half of its travel: once more, all the way
  kSkipped,
};
[[nodiscard]] std::string_view to_string(PushVerdict verdict);

struct PushedDial {
  std::string id;
  PushVerdict verdict = PushVerdict::kOpen;
  std::vector<std::string> moved;  // letters that moved when it was asked for
  double by_mm = 0.0;              // the largest way of these, with its sign
  double rest_mm = 0.0;            // what it showed before
  bool off_zero = false;           // ... which is no zero of a free plunger
};
/// "dial B moved when A was pushed: ..."; what to do is part of it.
[[nodiscard]] std::string describe(const PushedDial& dial, double travel_mm);

class PushCheck {
 public:
  explicit PushCheck(const geometry::Rig& rig);
  /// The newest reading of each dial, in the rig's order; as often as there are new ones.
  void take(std::span<const Reading> readings);
  [[nodiscard]] bool done() const { return asked_ >= dials_.size(); }
  /// Every dial is good.
  [[nodiscard]] bool good() const;
  /// What the person is to do now: which dial, where it stands, which way it points.
  [[nodiscard]] std::string instruction() const;
  /// Index of the dial that is asked for; as many as there are dials when it is done.
  [[nodiscard]] std::size_t asked() const { return asked_; }
  [[nodiscard]] std::span<const PushedDial> dials() const { return dials_; }
  /// Leaves the dial out that is asked for.
  void skip();
  /// Asks for the one before once more, or after the end for every dial that is not good.
  void again();

 private:
  struct Way {
    double rest_mm = 0.0, least_mm = 0.0, most_mm = 0.0, now_mm = 0.0;
    bool known = false;
    [[nodiscard]] double size() const;  // with the sign of the larger side
    [[nodiscard]] bool back() const;
  };
  void forget_ways();
  void judge();
  void next();

  const geometry::Rig rig_;
  std::vector<PushedDial> dials_;
  std::vector<Way> ways_;
  std::size_t asked_ = 0;
};

}  // namespace sixdial::acquisition
