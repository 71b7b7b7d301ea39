// What a calibration found of the rig, as a table, and back: the rig that its positions are
// computed with (calibration/rig_fit.h).
#pragma once

#include <optional>
#include <vector>

#include "calibration/observation_space.h"
#include "calibration/rig_fit.h"
#include "diagnosis/rig_seen.h"

namespace sixdial::studies {

/// One row for each quantity that the file states with a standard deviation.
[[nodiscard]] std::vector<diagnosis::RigSeen> seen_of(const calibration::RigFit& fit);
/// The file's rig with its dials where such a table says; the file's own where it is empty.
[[nodiscard]] geometry::Rig rig_as_seen(
    const geometry::Rig& file, const std::optional<std::vector<diagnosis::RigSeen>>& seen);
/// A space of the rig as it is seen: what is not known of it is what the fit leaves open.
[[nodiscard]] calibration::ObservationSpace with_rig_as_seen(
    calibration::ObservationSpace space, const std::optional<calibration::RigFit>& fit);

}  // namespace sixdial::studies
