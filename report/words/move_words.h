// What a person is to do who moves the robot by hand, in a sentence.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "geometry/pose.h"

namespace sixdial::report {

/// Figures as people read them: degrees, or mm of a joint that slides.
struct JointByHand {
  std::string joint;
  std::string unit;  // "deg" or "mm"
  double to = 0.0;
  std::optional<double> from{};   // where it stands; empty: nobody knows
  std::optional<double> first{};  // where it is brought before, to arrive from one side
};
struct MoveByHand {
  std::optional<geometry::Position> target_mm{};
  std::vector<JointByHand> joints;
};

/// "Move the tool to x 28.000, y 48.000 mm: turn shoulder counter-clockwise by 12.30 to 73.904
/// deg, ...".
[[nodiscard]] std::string move_words(const MoveByHand& move);

}  // namespace sixdial::report
