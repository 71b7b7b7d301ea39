// What speaks against a fit: asked once it is known what is fitted, and to what. The rest of
// plausibility (plausibility.h) is asked before.
#pragma once

#include <optional>
#include <span>
#include <vector>

#include "geometry/rig.h"
#include "simulation/trial.h"
#include "studies/assessment.h"
#include "studies/plausibility.h"

namespace sixdial::studies {

/// Too few different poses for so many free parameters: each shows its coordinates, and its
/// turn where these are fitted.
[[nodiscard]] std::optional<Warning> too_few_poses(
    std::span<const simulation::Trial> fitted, const geometry::Rig& rig, int free_parameters);
/// The same of a request, added to `warnings`. add() below appends `more` to `warnings`.
void add_too_few_poses(
    std::vector<Warning>& warnings, std::span<const simulation::Trial> fitted,
    const geometry::Rig& rig, const std::vector<std::string>& fix,
    const std::vector<std::string>& free);
void add(std::vector<Warning> more, std::vector<Warning>& warnings);

/// Where these poses are too few for all free parameters: the fit of fewer that they determine,
/// with five degrees of freedom to spare, as the parameters to hold. Empty: there is none.
/// `warnings` holds what was found of the poses.
[[nodiscard]] std::optional<Warning> smaller_fit(
    const std::vector<Warning>& warnings, const calibration::ObservationSpace& space,
    const std::vector<char>& fixed);

/// How many of a robot's parameters a request leaves free.
[[nodiscard]] int free_parameters(
    const geometry::RobotModel& robot, const std::vector<std::string>& fix,
    const std::vector<std::string>& free);

/// Why no reading can be accused of being wrong: the session contradicts itself, or leaves
/// nothing over. Empty: they can be judged.
[[nodiscard]] std::optional<std::string> why_no_reading_is_judged(
    const std::vector<Warning>& warnings);

/// What to do first where too little is left to fit, since most of it was set aside as not
/// plausible: more points of the same kind would not help. Empty: little was set aside.
[[nodiscard]] std::optional<std::string> settle_first(
    const session::Session& measured, const session::Session& believed);

/// Lengths that no robot of this kind has, if it is the one that the rig file describes.
[[nodiscard]] std::vector<Warning> implausible_lengths(
    const std::vector<ParameterRow>& parameters, const geometry::RobotModel& robot);

/// Angles of the robot, zeros of its joints among them, that are far from the rig file's.
[[nodiscard]] std::vector<Warning> far_angles(
    const std::vector<ParameterRow>& parameters, const geometry::RobotModel& robot);

/// A best fit, parameters `x`, that leaves more at half of the samples than plausible changes
/// of all parameters make together: no robot like the rig file's gave these data.
[[nodiscard]] std::optional<Warning> fits_nowhere(
    const calibration::ObservationSpace& space, const Eigen::VectorXd& x);

/// All of these of a fit that was made; the last only where `all_free`: what a user holds
/// cannot fit, whatever the data are.
void judge_fitted(
    const std::vector<ParameterRow>& parameters, const geometry::RobotModel& robot,
    const calibration::ObservationSpace& space, const Eigen::VectorXd& best, bool all_free,
    std::vector<Warning>& warnings);

}  // namespace sixdial::studies
