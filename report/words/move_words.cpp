#include "report/words/move_words.h"

#include <fmt/format.h>

#include <array>
#include <cmath>
#include <string_view>

namespace sixdial::report {
namespace {

constexpr double kStays_deg_mm = 0.0005;  // as it is shown: nothing to do

/// "counter-clockwise by 12.300 to 73.904 deg".
std::string one_joint(const JointByHand& joint) {
  const bool turns = joint.unit == "deg";
  if (!joint.from) {
    return fmt::format(
        "{} {} to {:.3f} {}", turns ? "turn" : "slide", joint.joint, joint.to, joint.unit);
  }
  const double by = joint.to - *joint.from;
  if (std::abs(by) < kStays_deg_mm) {
    return fmt::format("leave {} at {:.3f} {}", joint.joint, joint.to, joint.unit);
  }
  const std::string_view way =
      turns ? (by > 0 ? "counter-clockwise" : "clockwise") : (by > 0 ? "outwards" : "inwards");
  return fmt::format(
      "{} {} {} by {:.3f} to {:.3f} {}", turns ? "turn" : "slide", joint.joint, way,
      std::abs(by), joint.to, joint.unit);
}

}  // namespace

std::string move_words(const MoveByHand& move) {
  std::string text;
  if (move.target_mm) {
    constexpr std::array<std::string_view, 3> kXyz{"x", "y", "z"};
    text = "Move the tool to ";
    for (Eigen::Index i = 0; i < move.target_mm->size(); ++i) {
      text += fmt::format(
          "{}{} {:.3f}", i == 0 ? "" : ", ", kXyz.at(static_cast<std::size_t>(i)),
          (*move.target_mm)[i]);
    }
    text += " mm: ";
  }
  std::string via;
  for (std::size_t i = 0; i < move.joints.size(); ++i) {
    const JointByHand& joint = move.joints[i];
    text += (i == 0 ? "" : ", ") + one_joint(joint);
    if (!joint.first || std::abs(*joint.first - joint.to) < kStays_deg_mm) continue;
    via += fmt::format(
        "{}{} to {:.2f} {} and from there {} to the end", via.empty() ? "" : ", ", joint.joint,
        *joint.first, joint.unit,
        joint.unit == "deg" ? (joint.to > *joint.first ? "counter-clockwise" : "clockwise")
                            : (joint.to > *joint.first ? "outwards" : "inwards"));
  }
  text += '.';
  if (!via.empty()) {
    text += fmt::format(
        " On the way first {}, without turning back: gears and bearings lie on one side then. "
        "Gone too far? Back to that place, and once more.",
        via);
  }
  return text;
}

}  // namespace sixdial::report
