#include "studies/position_noise.h"

#include <cmath>

#include "session/trials.h"

namespace sixdial::studies {

std::optional<double> position_noise_mm(const session::Session& session) {
  double sum_mm2 = 0.0;
  int count = 0;
  for (const session::Sample& sample : session.samples) {
    if (sample.left_out) continue;
    const simulation::Trial trial = session::trial_of(session.rig, sample);
    if (!trial.position_mm || trial.position_channels.empty()) continue;
    sum_mm2 += trial.position_covariance.trace();
    ++count;
  }
  if (count == 0) return std::nullopt;
  return std::sqrt(sum_mm2 / count);
}

}  // namespace sixdial::studies
