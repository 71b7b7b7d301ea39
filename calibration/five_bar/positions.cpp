#include "calibration/five_bar/positions.h"

namespace sixdial::calibration {

PositionObservations PositionObservations::subset(std::span<const int> indices) const {
  PositionObservations result;
  const auto n = static_cast<Eigen::Index>(indices.size());
  result.q_rad.resize(2, n);
  result.p_WE.resize(2, n);
  for (Eigen::Index i = 0; i < n; ++i) {
    const int from = indices[static_cast<std::size_t>(i)];
    const auto k = static_cast<std::size_t>(from);
    result.q_rad.col(i) = q_rad.col(from);
    result.p_WE.col(i) = p_WE.col(from);
    result.assembly.push_back(assembly[k]);
    result.covariance_mm2.push_back(covariance_mm2[k]);
    result.target_mm.push_back(target_mm[k]);
    result.sample.push_back(sample[k]);
    result.point.push_back(point[k]);
    result.repeat.push_back(repeat[k]);
  }
  return result;
}

PositionObservations position_observations(std::span<const simulation::Trial> trials) {
  PositionObservations result;
  std::vector<const simulation::Trial*> used;
  for (const simulation::Trial& trial : trials) {
    const bool planar =
        trial.position_mm && trial.position_mm->size() == 2 && trial.q.size() == 2;
    if (planar && trial.position_mm->allFinite() && trial.q.allFinite()) {
      used.push_back(&trial);
    }
  }
  const auto n = static_cast<Eigen::Index>(used.size());
  result.q_rad.resize(2, n);
  result.p_WE.resize(2, n);
  for (Eigen::Index i = 0; i < n; ++i) {
    const simulation::Trial& trial = *used[static_cast<std::size_t>(i)];
    result.q_rad.col(i) = trial.q;
    result.p_WE.col(i) = *trial.position_mm;
    result.assembly.push_back(trial.assembly);
    result.covariance_mm2.push_back(trial.covariance_or_zero());
    result.target_mm.emplace_back();
    if (trial.target_mm) result.target_mm.back() = *trial.target_mm;
    result.sample.push_back(trial.sample);
    result.point.push_back(trial.point);
    result.repeat.push_back(trial.repeat);
  }
  return result;
}

}  // namespace sixdial::calibration
