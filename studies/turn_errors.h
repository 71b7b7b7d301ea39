// How far the tool is turned from where a robot's parameters say, set by set: what an
// instrument of poses shows beside errors of position.
//
//   for (const TurnErrors& each : turn_errors(session, nominal, identified))
//   show(each.mean_rad);
#pragma once

#include <Eigen/Core>
#include <string>
#include <vector>

#include "session/session.h"

namespace sixdial::studies {

struct TurnErrors {
  std::string set{};
  int poses = 0;
  // Angle between the measured and the modelled frame of the tool [rad].
  // By the nominal robot: its tool's frame, and its base, set first as they were measured
  // (`tool_turn_registered`, `base_registered`).
  double before_mean_rad = 0.0, before_max_rad = 0.0;
  double mean_rad = 0.0, max_rad = 0.0;  // by the identified one
};

/// Whether turns were fitted: G1 has some, and only those are. Else the figures show what a fit
/// to positions alone leaves of them.
[[nodiscard]] bool turns_were_fitted(const std::vector<TurnErrors>& errors);

/// Of G1 and of G2, as far as they have turns; none where the rig's robot cannot explain them.
/// `nominal`, `identified`: the robot's parameters.
[[nodiscard]] std::vector<TurnErrors> turn_errors(
    const session::Session& session, const Eigen::VectorXd& nominal,
    const Eigen::VectorXd& identified);

}  // namespace sixdial::studies
