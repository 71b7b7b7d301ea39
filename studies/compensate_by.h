// What commands the robot: a calibration or a diagnosis gives several models, each by its name.
#pragma once

#include <optional>
#include <string_view>

namespace sixdial::studies {

/// The nominal parameters, the identified ones, these with the learned residual; robot and
/// named causes of a diagnosis (extended_command.h), these with what a residual model learned
/// of the rest.
enum class CompensateBy { kBefore, kKinematics, kFull, kExtended, kExtendedFull };
/// "before", "kinematics", "full", "extended", "extended_full".
[[nodiscard]] std::string_view to_string(CompensateBy by);
[[nodiscard]] std::optional<CompensateBy> compensate_by_from(std::string_view text);
/// Of a diagnosis, not of a calibration.
[[nodiscard]] constexpr bool is_extended(CompensateBy by) {
  return by == CompensateBy::kExtended || by == CompensateBy::kExtendedFull;
}

}  // namespace sixdial::studies
