// What a stated gain is worth: the same fits judged on many other held-out poses.
#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "diagnosis/diagnosis.h"

namespace sixdial::blind {

/// Sessions with other held-out poses that the gain's truth is made of.
inline constexpr std::uint64_t kOtherSessions = 16;

struct StatedGain {
  /// Mean position error of the extended model less that of the calibrated robot: its interval.
  double low_mm = 0.0, high_mm = 0.0;
  diagnosis::JointFit calibrated, extended;  // on G1
};

/// As a diagnosis states it. Empty where nothing is named, or dials are exchanged.
[[nodiscard]] std::optional<StatedGain> stated_gain(
    const diagnosis::Diagnosis& found, const std::vector<bool>& held_out);

/// The same difference for each held-out trial of another session.
[[nodiscard]] std::vector<double> differences_on(
    const StatedGain& stated, std::vector<simulation::Trial> trials,
    const std::vector<bool>& held_out, const simulation::ForwardModel& model);

}  // namespace sixdial::blind
