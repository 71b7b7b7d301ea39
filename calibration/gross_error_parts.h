// Shared by the checks of dial readings and of positions.
#pragma once

#include <algorithm>
#include <string>
#include <string_view>
#include <vector>

#include "calibration/gross_errors.h"
#include "calibration/position_judge.h"

namespace sixdial::calibration {

inline constexpr double kFalseAlarms = 0.01;    // of a whole session, for normal noise
inline constexpr double kMostAccidents = 0.15;  // of all readings

[[nodiscard]] inline std::string too_few(int readings, int parameters, std::string_view what) {
  return std::to_string(readings) + " " + std::string(what) + " for " +
         std::to_string(parameters) +
         " parameters: too few to tell a bad one from a robot that is different";
}

/// Too many are not accidents.
inline void judge_number(int readings, GrossErrorCheck& result) {
  const auto count = static_cast<int>(result.found.size());
  if (count <= std::max(3, static_cast<int>(kMostAccidents * readings))) return;
  result.systematic = count;
  result.found.clear();
}

inline void sort(std::vector<GrossError>& found) {
  std::ranges::sort(found, [](const GrossError& a, const GrossError& b) {
    return a.sample != b.sample ? a.sample < b.sample : a.dial < b.dial;
  });
}

[[nodiscard]] GrossErrorCheck check_positions(
    std::span<const simulation::Trial> trials, const geometry::Rig& rig,
    const IdentifySettings& settings);

/// Adds the samples of `space` that cannot be chance.
void list(
    const ObservationSpace& space, const std::vector<PositionJudge::Verdict>& verdicts,
    double chance, GrossErrorCheck& result);

}  // namespace sixdial::calibration
