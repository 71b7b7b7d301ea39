// Many logarithms at once, for the random numbers of a swarm.
#pragma once

#include <Eigen/Core>

namespace sixdial::calibration {

/// u becomes -ln(u), for count values in (0, 1]; count is a multiple of kLanes.
void minus_logarithms(double* u, Eigen::Index count);

}  // namespace sixdial::calibration
