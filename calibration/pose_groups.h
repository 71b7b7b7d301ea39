// Repeats of one pose belong together wherever something is held out: a repeat of a fitted pose
// is no new pose, and a model that is judged on it is praised for what it has seen.
#pragma once

#include <Eigen/Core>
#include <vector>

namespace sixdial::calibration {

/// Number of each row's pose, from 0 in the order of the rows. Rows are one pose where every
/// joint value is within geometry::kSamePose_rad of a row before (chained: repeats may creep).
/// joints: samples x joints.
[[nodiscard]] std::vector<int> pose_groups(const Eigen::MatrixXd& joints);

/// Rows of each group, rising.
[[nodiscard]] std::vector<std::vector<int>> rows_by_group(const std::vector<int>& groups);

}  // namespace sixdial::calibration
