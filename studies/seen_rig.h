// What a calibration found of the rig, as a table, and back: the rig that its positions are
// computed with (diagnosis/rig_fit.h).
#pragma once

#include <optional>
#include <span>
#include <vector>

#include "calibration/observation_space.h"
#include "diagnosis/rig_fit.h"
#include "diagnosis/rig_seen.h"
#include "simulation/effect.h"
#include "simulation/trial.h"

namespace sixdial::studies {

/// One row for each quantity that the file states with a standard deviation.
[[nodiscard]] std::vector<diagnosis::RigSeen> seen_of(const diagnosis::RigFit& fit);
/// The file's rig with its dials where such a table says; the file's own where it is empty.
[[nodiscard]] geometry::Rig rig_as_seen(
    const geometry::Rig& file, const std::optional<std::vector<diagnosis::RigSeen>>& seen);
/// The same for another session's file. What that file gives another figure for was measured
/// anew: there its figure stands.
[[nodiscard]] geometry::Rig rig_as_seen(
    const geometry::Rig& other, const geometry::Rig& file,
    const std::optional<std::vector<diagnosis::RigSeen>>& seen);
/// Such a table as effects of a model of the file's rig: squareness and centre of the cuboid
/// too, of which a rig cannot say anything.
[[nodiscard]] std::vector<simulation::ActiveEffect> rig_effects(
    const geometry::Rig& file, const std::optional<std::vector<diagnosis::RigSeen>>& seen);
/// A space of the rig as it is seen: what is not known of it is what the fit leaves open.
/// `trials`: of the space.
[[nodiscard]] calibration::ObservationSpace with_rig_as_seen(
    calibration::ObservationSpace space, std::span<const simulation::Trial> trials,
    const std::optional<diagnosis::RigFit>& fit);
/// A root of what the fit leaves open, fit.open = root * root'. For who asks for the space of
/// one sample after the other.
[[nodiscard]] Eigen::MatrixXd root_of_open(const diagnosis::RigFit& fit);
[[nodiscard]] calibration::ObservationSpace with_rig_as_seen(
    calibration::ObservationSpace space, std::span<const simulation::Trial> trials,
    const diagnosis::RigFit& fit, const Eigen::MatrixXd& root);

}  // namespace sixdial::studies
