#include "calibration/observations.h"

#include <cmath>
#include <limits>
#include <map>

namespace sixdial::calibration {
namespace {

// Repeats arrive within encoder steps of each other; further apart they are different poses.
constexpr double kSamePose_rad = 1e-4;

}  // namespace

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
    if (trial.position_mm && trial.position_mm->allFinite() && trial.q.allFinite()) {
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

Eigen::Matrix2Xd position_residuals(
    const PositionObservations& observations, const geometry::ParameterVector& v) {
  Eigen::Matrix2Xd result(2, observations.size());
  for (int i = 0; i < observations.size(); ++i) {
    const auto pose = geometry::forward(
        v, observations.q_rad.col(i), observations.assembly[static_cast<std::size_t>(i)]);
    if (pose) {
      result.col(i) = observations.p_WE.col(i) - pose->p_WE;
    } else {
      result.col(i).setConstant(std::numeric_limits<double>::quiet_NaN());
    }
  }
  return result;
}

double position_rmse(
    const PositionObservations& observations, const geometry::ParameterVector& v) {
  if (observations.empty()) return 0.0;
  const double sum = position_residuals(observations, v).squaredNorm();
  if (!std::isfinite(sum)) return std::numeric_limits<double>::infinity();
  return std::sqrt(sum / observations.size());
}

std::optional<RepeatNoise> noise_from_repeats(const PositionObservations& observations) {
  std::map<int, std::vector<int>> by_point;
  for (int i = 0; i < observations.size(); ++i) {
    by_point[observations.point[static_cast<std::size_t>(i)]].push_back(i);
  }
  double sum = 0.0;
  int freedom = 0;
  for (const auto& [point, members] : by_point) {
    if (members.size() < 2) continue;
    const Eigen::Vector2d q = observations.q_rad.col(members.front());
    Eigen::Vector2d mean = Eigen::Vector2d::Zero();
    bool same_pose = true;
    for (const int i : members) {
      mean += observations.p_WE.col(i) / static_cast<double>(members.size());
      same_pose &= (observations.q_rad.col(i) - q).cwiseAbs().maxCoeff() < kSamePose_rad;
    }
    if (!same_pose) continue;
    for (const int i : members) sum += (observations.p_WE.col(i) - mean).squaredNorm();
    freedom += 2 * (static_cast<int>(members.size()) - 1);
  }
  if (freedom == 0) return std::nullopt;
  return RepeatNoise{std::sqrt(sum / freedom), freedom};
}

}  // namespace sixdial::calibration
