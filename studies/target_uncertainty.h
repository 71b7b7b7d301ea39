// How well a model knows where it puts the tool and how it turns it: what a fit leaves open of
// its parameters, carried to one pose. It is no repeatability: a robot that arrives elsewhere
// each time does so beside this.
//
//   const auto known = target_uncertainty(calibrated, rig, commanded);
//   if (known) show(known->position_sd_mm, known->turn_sd_rad);
#pragma once

#include <Eigen/Core>
#include <optional>

#include "geometry/instrument_kind.h"
#include "geometry/rig.h"

namespace sixdial::studies {

struct CalibrationResult;
struct CommandedTarget;

/// Standard uncertainties (k = 1): root of the sum of the variances of the coordinates, and of
/// the three parts of the rotation vector.
struct TargetUncertainty {
  double position_sd_mm = 0.0;
  std::optional<double> turn_sd_rad{};  // empty: no turn was asked for
};

/// Adds smooth errors that a model lacks, `sd_mm` at each coordinate, to a covariance of
/// (position [mm], turn [rad]), 6 x 6: turns err as what they move at the instrument's lever.
void add_smooth_errors(
    double sd_mm, const geometry::InstrumentModel& instrument, Eigen::MatrixXd& twist);

/// Of a covariance of (position [mm], turn in W [rad]), 6 x 6.
[[nodiscard]] TargetUncertainty uncertainty_of(const Eigen::MatrixXd& twist, bool with_turn);

/// Of the identified parameters at the commanded joint values, smooth errors that the
/// parameters leave included. Empty for a robot in the plane, for the nominal robot, and where
/// the covariance is not known.
[[nodiscard]] std::optional<TargetUncertainty> target_uncertainty(
    const CalibrationResult& result, const geometry::Rig& rig,
    const CommandedTarget& commanded);

}  // namespace sixdial::studies
