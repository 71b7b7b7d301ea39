#include "acquisition/push_check.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <array>
#include <cmath>

#include "session/reason.h"

namespace sixdial::acquisition {
namespace {

constexpr double kMoved_mm = 0.1;   // less is a hand on the table
constexpr double kAlongWith = 0.3;  // of the largest way: this one moved, too
constexpr double kBack = 0.2;       // of its way: let go
constexpr double kWholeWay = 0.5;   // of the travel
constexpr double kMmPerInch = 25.4;
constexpr double kZero_mm = 0.5;  // a free plunger shows less

/// "to the right (+x)".
std::string pointing(const Eigen::Vector2d& axis) {
  constexpr double kAlong = 0.9;
  if (axis.x() > kAlong) return "to the right (+x)";
  if (axis.x() < -kAlong) return "to the left (-x)";
  if (axis.y() > kAlong) return "away from you (+y)";
  if (axis.y() < -kAlong) return "towards you (-y)";
  return fmt::format("along ({:.2f}, {:.2f})", axis.x(), axis.y());
}

}  // namespace

std::string_view to_string(PushVerdict verdict) {
  constexpr std::array<std::string_view, 8> kNames{"open",     "good", "other", "together",
                                                   "reversed", "inch", "short", "skipped"};
  return kNames.at(static_cast<std::size_t>(verdict));
}

std::string describe(const PushedDial& dial, double travel_mm) {
  std::string text;
  switch (dial.verdict) {
    case PushVerdict::kOpen:
      return fmt::format("{}: not pushed yet", dial.id);
    case PushVerdict::kSkipped:
      return fmt::format("{}: left out, so nothing is known of it", dial.id);
    case PushVerdict::kGood:
      text = fmt::format("{}: good, it moved alone by {:+.3f} mm", dial.id, dial.by_mm);
      break;
    case PushVerdict::kOther:
      text = fmt::format(
          "{0}: {1} moved instead. The cables or channels are exchanged: exchange the "
          "connection lines of {0} and {1} in the rig file, or the plugs",
          dial.id, fmt::join(dial.moved, ", "));
      break;
    case PushVerdict::kTogether:
      text = fmt::format(
          "{}: {} moved together. Push one alone; if you did, they read the same dial: look at "
          "channel, index and unit in the rig file",
          dial.id, fmt::join(dial.moved, ", "));
      break;
    case PushVerdict::kReversed:
      text = fmt::format(
          "{}: it counts down when pushed in ({:+.3f} mm). Turn its counting direction round "
          "at "
          "the dial",
          dial.id, dial.by_mm);
      break;
    case PushVerdict::kInch:
      text = fmt::format(
          "{}: it moved by {:.3f} where {:.1f} mm of travel are: it shows inches. Switch it to "
          "mm",
          dial.id, dial.by_mm, travel_mm);
      break;
    case PushVerdict::kShort:
      text = fmt::format(
          "{}: it moved by {:.3f} of {:.1f} mm. Push it all the way in once more; if that was "
          "all, travel_mm in the rig file or the unit is wrong",
          dial.id, dial.by_mm, travel_mm);
      break;
  }
  if (dial.off_zero) {
    text += fmt::format(
        ". With the plunger free it showed {:+.3f} mm: set it to zero there", dial.rest_mm);
  }
  return text;
}

PushCheck::PushCheck(const geometry::Rig& rig) : rig_(rig), ways_(rig.dials.size()) {
  for (const geometry::Dial& dial : rig_.dials) dials_.push_back({.id = dial.id, .moved = {}});
}

double PushCheck::Way::size() const {
  const double up = most_mm - rest_mm;
  const double down = rest_mm - least_mm;
  return up >= down ? up : -down;
}

bool PushCheck::Way::back() const {
  return std::abs(now_mm - rest_mm) <= kBack * std::abs(size());
}

void PushCheck::take(std::span<const Reading> readings) {
  if (done()) return;
  for (std::size_t i = 0; i < readings.size() && i < ways_.size(); ++i) {
    const Reading& reading = readings[i];
    Way& way = ways_[i];
    // A plunger that hangs free shows its zero.
    const bool free = reading.reason == session::reason::kNoContact;
    if (!reading.value_mm && !free) continue;
    way.now_mm = reading.value_mm.value_or(0.0);
    if (!way.known) {
      way = {way.now_mm, way.now_mm, way.now_mm, way.now_mm, true};
    }
    way.least_mm = std::min(way.least_mm, way.now_mm);
    way.most_mm = std::max(way.most_mm, way.now_mm);
  }
  judge();
}

void PushCheck::judge() {
  double largest = 0.0;
  for (const Way& way : ways_) largest = std::max(largest, std::abs(way.size()));
  if (largest < kMoved_mm) return;
  std::vector<std::size_t> moved;
  for (std::size_t i = 0; i < ways_.size(); ++i) {
    if (std::abs(ways_[i].size()) >= std::max(kMoved_mm, kAlongWith * largest)) {
      moved.push_back(i);
    }
  }
  if (!std::ranges::all_of(moved, [&](std::size_t i) { return ways_[i].back(); })) return;
  PushedDial& dial = dials_[asked_];
  dial.moved.clear();
  for (const std::size_t i : moved) dial.moved.push_back(dials_[i].id);
  dial.rest_mm = ways_[asked_].rest_mm;
  dial.off_zero = std::abs(dial.rest_mm) > kZero_mm;
  const bool own = std::ranges::find(moved, asked_) != moved.end();
  const double by_mm = ways_[own ? asked_ : moved.front()].size();
  dial.by_mm = by_mm;
  const double share = std::abs(by_mm) / rig_.dials[asked_].geometry.travel_mm;
  constexpr double kNear = 1.5;  // of an inch dial's share, and not all the way
  if (moved.size() > 1) {
    dial.verdict = PushVerdict::kTogether;
  } else if (!own) {
    dial.verdict = PushVerdict::kOther;
  } else if (by_mm < 0) {
    dial.verdict = PushVerdict::kReversed;
  } else if (share >= kWholeWay) {
    dial.verdict = PushVerdict::kGood;
  } else if (share * kMmPerInch >= kWholeWay && share * kMmPerInch <= kNear) {
    dial.verdict = PushVerdict::kInch;
  } else {
    dial.verdict = PushVerdict::kShort;
    forget_ways();  // asked for once more
    return;
  }
  next();
}

void PushCheck::forget_ways() {
  for (Way& way : ways_) way = {};
}

void PushCheck::next() {
  forget_ways();
  ++asked_;
  while (!done() && dials_[asked_].verdict != PushVerdict::kOpen) ++asked_;
}

void PushCheck::skip() {
  if (done()) return;
  if (dials_[asked_].verdict == PushVerdict::kOpen) {
    dials_[asked_].verdict = PushVerdict::kSkipped;
  }
  next();
}

void PushCheck::again() {
  forget_ways();
  if (!done()) {
    if (asked_ > 0) --asked_;
    dials_[asked_].verdict = PushVerdict::kOpen;
    return;
  }
  for (PushedDial& dial : dials_) {
    if (dial.verdict != PushVerdict::kGood) dial.verdict = PushVerdict::kOpen;
  }
  const auto first = std::ranges::find(dials_, PushVerdict::kOpen, &PushedDial::verdict);
  asked_ = static_cast<std::size_t>(first - dials_.begin());
}

bool PushCheck::good() const {
  return std::ranges::all_of(dials_, [](const PushedDial& dial) {
    return dial.verdict == PushVerdict::kGood && !dial.off_zero;
  });
}

std::string PushCheck::instruction() const {
  if (done()) return "";
  const geometry::Dial& dial = rig_.dials[asked_];
  return fmt::format(
      "Push dial {} with a finger, all the way in, and let go. By the rig file it stands at x "
      "{:.1f}, y {:.1f} mm and points {}.",
      dial.id, dial.geometry.position_mm.x(), dial.geometry.position_mm.y(),
      pointing(dial.geometry.axis));
}

}  // namespace sixdial::acquisition
