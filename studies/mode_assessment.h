// A session measured in several working modes: how well each would determine the parameters by
// itself, beside all pooled.
#pragma once

#include <optional>
#include <span>
#include <vector>

#include "calibration/least_squares.h"
#include "calibration/observation_space.h"
#include "geometry/rig.h"
#include "simulation/trial.h"

namespace sixdial::studies {

struct WorkingModeRow {
  geometry::WorkingMode mode{};
  int samples = 0;
  /// Condition number of the scaled Jacobian's rows of this mode, at the fit's result; empty
  /// where they leave a direction open.
  std::optional<double> condition{};
};

/// In order of appearance, one row for a session in one mode. `trials` must hold the samples of
/// the space.
[[nodiscard]] std::vector<WorkingModeRow> working_modes_of(
    const calibration::ObservationSpace& space, const calibration::LeastSquaresFit& fit,
    std::span<const simulation::Trial> trials, const geometry::Rig& rig);

}  // namespace sixdial::studies
