#include "calibration/pose_groups.h"

#include <algorithm>
#include <numeric>

#include "geometry/same_pose.h"

namespace sixdial::calibration {

std::vector<int> pose_groups(const Eigen::MatrixXd& joints) {
  const auto n = static_cast<std::size_t>(joints.rows());
  std::vector<int> order(n);
  std::iota(order.begin(), order.end(), 0);
  if (joints.cols() > 0) {
    std::ranges::stable_sort(order, {}, [&](int row) { return joints(row, 0); });
  }
  std::vector<int> root(n);
  std::iota(root.begin(), root.end(), 0);
  const auto root_of = [&](int row) {
    while (root[static_cast<std::size_t>(row)] != row)
      row = root[static_cast<std::size_t>(row)];
    return row;
  };
  for (std::size_t i = 0; i < n; ++i) {
    for (std::size_t k = i + 1; k < n; ++k) {
      const auto apart = (joints.row(order[k]) - joints.row(order[i])).cwiseAbs();
      if (apart[0] > geometry::kSamePose_rad) break;
      if (apart.maxCoeff() > geometry::kSamePose_rad) continue;
      const int a = root_of(order[i]);
      const int b = root_of(order[k]);
      root[static_cast<std::size_t>(std::max(a, b))] = std::min(a, b);
    }
  }
  std::vector<int> groups(n);
  std::vector<int> number(n, -1);
  int count = 0;
  for (std::size_t row = 0; row < n; ++row) {
    int& of = number[static_cast<std::size_t>(root_of(static_cast<int>(row)))];
    if (of < 0) of = count++;
    groups[row] = of;
  }
  return groups;
}

std::vector<std::vector<int>> rows_by_group(const std::vector<int>& groups) {
  std::vector<std::vector<int>> rows(
      groups.empty() ? 0 : static_cast<std::size_t>(*std::ranges::max_element(groups)) + 1);
  for (std::size_t i = 0; i < groups.size(); ++i) {
    rows[static_cast<std::size_t>(groups[i])].push_back(static_cast<int>(i));
  }
  return rows;
}

}  // namespace sixdial::calibration
