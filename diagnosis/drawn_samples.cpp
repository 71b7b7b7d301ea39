#include "diagnosis/drawn_samples.h"

#include <algorithm>
#include <cmath>

#include "calibration/pose_groups.h"
#include "calibration/random.h"

namespace sixdial::diagnosis {
namespace {

constexpr std::uint32_t kStream = 79;
/// So many repeats of a pose are kept before poses are left out: they tell the noise.
constexpr std::size_t kRepeatsKept = 3;

/// Of the samples of one side, by pose.
void draw(
    const std::vector<std::vector<std::size_t>>& poses, std::size_t most, std::uint64_t seed,
    std::vector<bool>& drawn) {
  if (poses.empty()) return;
  const std::size_t repeats = std::max(kRepeatsKept, most / poses.size());
  std::size_t samples = 0;
  for (const auto& pose : poses) samples += std::min(repeats, pose.size());
  const double mean = static_cast<double>(samples) / static_cast<double>(poses.size());
  // One pose of each stretch of the session.
  const auto wanted = static_cast<std::size_t>(std::ceil(static_cast<double>(most) / mean));
  const std::size_t stretches = std::clamp<std::size_t>(wanted, 1, poses.size());
  for (std::size_t i = 0; i < stretches; ++i) {
    const std::size_t begin = i * poses.size() / stretches;
    const std::size_t end = (i + 1) * poses.size() / stretches;
    const auto words =
        calibration::random_words(seed, static_cast<std::uint32_t>(i), 0, 0, kStream);
    const auto pick = static_cast<std::size_t>(
        calibration::open_unit(words[0]) * static_cast<double>(end - begin));
    const auto& pose = poses[begin + std::min(pick, end - begin - 1)];
    const std::size_t kept = std::min(repeats, pose.size());
    for (std::size_t k = 0; k < kept; ++k) drawn[pose[k * pose.size() / kept]] = true;
  }
}

}  // namespace

std::vector<bool> drawn_samples(
    const std::vector<simulation::Trial>& trials, const std::vector<bool>& held_out,
    std::size_t most, std::uint64_t seed) {
  if (most == 0 || trials.size() <= most) return std::vector<bool>(trials.size(), true);
  std::vector<bool> drawn(trials.size(), false);
  Eigen::MatrixXd joints(std::ssize(trials), trials.front().q.size());
  for (std::size_t t = 0; t < trials.size(); ++t) {
    joints.row(static_cast<Eigen::Index>(t)) = trials[t].q.transpose();
  }
  const auto groups = calibration::rows_by_group(calibration::pose_groups(joints));
  for (const bool side : {false, true}) {
    std::vector<std::vector<std::size_t>> poses;
    std::size_t samples = 0;
    for (const std::vector<int>& rows : groups) {
      std::vector<std::size_t> pose;
      for (const int row : rows) {
        const auto t = static_cast<std::size_t>(row);
        if ((t < held_out.size() && held_out[t]) == side) pose.push_back(t);
      }
      samples += pose.size();
      if (!pose.empty()) poses.push_back(std::move(pose));
    }
    draw(poses, samples * most / trials.size(), seed + (side ? 1 : 0), drawn);
  }
  return drawn;
}

}  // namespace sixdial::diagnosis
