// Where the joints stood while a session was measured: commands made from its results stay
// there, on the same turns of the joints.
#pragma once

#include <Eigen/Core>
#include <map>
#include <optional>
#include <span>
#include <vector>

#include "geometry/rig.h"
#include "simulation/trial.h"

namespace sixdial::studies {

/// Joint values at which a working mode was measured.
struct MeasuredJoints {
  geometry::WorkingMode mode{};
  Eigen::VectorXd low{}, high{};
};

/// By working mode, in order of appearance.
[[nodiscard]] std::vector<MeasuredJoints> measured_joints_of(
    std::span<const simulation::Trial> trials, const geometry::Rig& rig);

/// The middle of each, for CompensationModel::measured_at; empty of early results.
[[nodiscard]] std::map<int, Eigen::VectorXd> middles_of(
    const std::optional<std::vector<MeasuredJoints>>& measured);

}  // namespace sixdial::studies
