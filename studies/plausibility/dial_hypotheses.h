// Which dial each column of readings really shows, and in which unit: every hypothesis is held
// against the nominal robot by one linear, robust fit of all parameters, so that links which
// are a millimetre off speak neither for nor against it.
#pragma once

#include <Eigen/Core>
#include <optional>
#include <string_view>
#include <vector>

#include "session/session.h"

namespace sixdial::studies::plausibility {

/// A dial that counts the other way has this for mm_per_unit.
inline constexpr double kReversed = -1.0;

/// What column k holds: readings of dial shows[k], mm_per_unit[k] for one of its units, plus
/// offset_mm[k], which is 0 unless it counts the other way.
struct DialHypothesis {
  std::vector<int> shows;
  std::vector<double> mm_per_unit, offset_mm;
  [[nodiscard]] bool exchanged() const;
};

struct DialJudgement {
  DialHypothesis best;
  /// Typical distance from what the fitted robot would show, by column [mm]: as the file has
  /// it, and under the best hypothesis.
  std::vector<double> as_is_mm, best_mm;
};

/// Empty: too few readings to judge by, or what the file says is as good as anything else.
[[nodiscard]] std::optional<DialJudgement> judge_dials(const session::Session& session);

/// "inches" of 25.4; empty: no unit that dials come in.
[[nodiscard]] std::string_view unit_of(double mm_per_unit);

}  // namespace sixdial::studies::plausibility
