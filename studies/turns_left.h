// How far the tool is turned from where a robot's parameters say, sample by sample.
//
//   for (const TurnLeft& each : turns_left(session, trials, v)) show(each.rad);
#pragma once

#include <Eigen/Core>
#include <span>
#include <vector>

#include "session/session.h"
#include "simulation/trial.h"

namespace sixdial::studies {

struct TurnLeft {
  int sample = 0;    // row of the session
  double rad = 0.0;  // angle between the measured and the modelled frame of the tool
};

/// Of each turn that `trials` of the session measured, by the robot with parameters v. Poses
/// that the robot cannot take are skipped.
[[nodiscard]] std::vector<TurnLeft> turns_left(
    const session::Session& session, std::span<const simulation::Trial> trials,
    const Eigen::VectorXd& v);

}  // namespace sixdial::studies
