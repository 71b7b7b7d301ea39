#include "geometry/base_and_tool.h"

#include <Eigen/QR>
#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

#include "geometry/rotation.h"

namespace sixdial::geometry {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::Vector3d;
using Eigen::VectorXd;

constexpr Index kFewest = 6;
constexpr Index kMostPoints = 200;  // a few per direction are enough for a start
constexpr int kSteps = 20;
constexpr double kKept = 0.8;  // of the points: gross rows lie further away
constexpr double kSettled_mm = 1e-9;
constexpr double kOpen = 1e-9;  // a direction in which the tool does not show
// Tools to start from: none, and a hand's and an arm's length in all directions.
constexpr std::array kLengths_mm{100.0, 400.0};

class Search {
 public:
  Search(std::span<const Pose<double>> poses, const MatrixXd& measured_mm) {
    const auto n = static_cast<Index>(poses.size());
    const Index every = std::max<Index>(1, n / kMostPoints);
    for (Index i = 0; i < n; i += every) {
      poses_.push_back(poses[static_cast<std::size_t>(i)]);
      measured_.push_back(measured_mm.col(i));
    }
  }

  [[nodiscard]] std::optional<BaseAndTool> from(const Vector3d& tool_mm) const {
    BaseAndTool at{Similarity::identity(3), tool_mm, 0.0};
    MatrixXd nominal(3, std::ssize(poses_));
    MatrixXd seen(3, std::ssize(poses_));
    for (Index i = 0; i < nominal.cols(); ++i) {
      const Pose<double>& X = poses_[static_cast<std::size_t>(i)];
      nominal.col(i) = X.p + X.R * tool_mm;
      seen.col(i) = measured_[static_cast<std::size_t>(i)];
    }
    const auto start = register_points(nominal, seen);
    if (!start) return std::nullopt;
    at.base = start->X;
    at.median = median(at);
    for (int step = 0; step < kSteps; ++step) {
      const BaseAndTool next = improved(at);
      if (!(next.median < at.median - kSettled_mm)) break;
      at = next;
    }
    return at;
  }

 private:
  [[nodiscard]] Vector3d miss(const BaseAndTool& at, std::size_t i) const {
    return measured_[i] - at.base(poses_[i].p + poses_[i].R * at.tool_mm);
  }

  [[nodiscard]] double median(const BaseAndTool& at) const {
    std::vector<double> sizes;
    for (std::size_t i = 0; i < poses_.size(); ++i) sizes.push_back(miss(at, i).norm());
    return median_of(std::move(sizes));
  }

  /// One step over the points that lie nearest.
  [[nodiscard]] BaseAndTool improved(const BaseAndTool& at) const {
    std::vector<std::pair<double, std::size_t>> order;
    for (std::size_t i = 0; i < poses_.size(); ++i) order.emplace_back(miss(at, i).norm(), i);
    std::ranges::sort(order);
    const auto kept =
        static_cast<std::size_t>(std::ceil(kKept * static_cast<double>(order.size())));
    MatrixXd A(3 * static_cast<Index>(kept), 9);
    VectorXd b(A.rows());
    for (std::size_t k = 0; k < kept; ++k) {
      const std::size_t i = order[k].second;
      const auto row = static_cast<Index>(3 * k);
      const Vector3d lever = at.base.R * (poses_[i].p + poses_[i].R * at.tool_mm);
      A.block<3, 3>(row, 0) = -skew<double>(lever);
      A.block<3, 3>(row, 3).setIdentity();
      A.block<3, 3>(row, 6) = at.base.R * poses_[i].R;
      b.segment<3>(row) = miss(at, i);
    }
    // Turns count as lengths at the points' distance.
    const double size = std::max(A.leftCols<3>().norm() / A.middleCols<3>(3).norm(), 1e-9);
    A.leftCols<3>() /= size;
    Eigen::CompleteOrthogonalDecomposition<MatrixXd> solver;
    solver.setThreshold(kOpen);
    solver.compute(A);
    const VectorXd step = solver.solve(b);
    BaseAndTool next = at;
    next.base.R =
        turned_by<double>(Vector3d(step.head<3>() / size)) * Eigen::Matrix3d(at.base.R);
    next.base.t = at.base.t + step.segment<3>(3);
    next.tool_mm = at.tool_mm + step.tail<3>();
    next.median = median(next);
    return next;
  }

  std::vector<Pose<double>> poses_;
  std::vector<Vector3d> measured_;
};

}  // namespace

std::optional<BaseAndTool> register_base_and_tool(
    std::span<const Pose<double>> poses, const MatrixXd& measured_mm) {
  const auto n = static_cast<Index>(poses.size());
  if (n < kFewest || measured_mm.rows() != 3 || measured_mm.cols() != n) return std::nullopt;
  const Search search(poses, measured_mm);
  std::optional<BaseAndTool> best;
  const auto take = [&](const Vector3d& tool_mm) {
    const auto found = search.from(tool_mm);
    if (found && (!best || found->median < best->median)) best = found;
  };
  take(Vector3d::Zero());
  for (const double length_mm : kLengths_mm) {
    for (int direction = 0; direction < 27; ++direction) {
      const int x = direction % 3 - 1;
      const int y = direction / 3 % 3 - 1;
      const int z = direction / 9 - 1;
      const Vector3d along(x, y, z);
      if (along.isZero()) continue;
      take(length_mm * along.normalized());
    }
  }
  return best;
}

}  // namespace sixdial::geometry
