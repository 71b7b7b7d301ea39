#include "geometry/instrument_frame.h"

#include <Eigen/Geometry>
#include <Eigen/QR>
#include <cmath>
#include <span>
#include <vector>

#include "geometry/instrument_kind.h"

namespace sixdial::geometry {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::Vector3d;
using Eigen::VectorXd;

constexpr int kPoses = 6;
constexpr double kSame = 1e-9;  // of the readings' own change

/// Some pose, another one for each number; none is special.
Pose<double> some_pose(int number) {
  const double k = number + 1;
  Pose<double> X;
  X.p =
      Vector3d(310 * std::sin(1.3 * k), 270 * std::cos(0.7 * k), 200 + 90 * std::sin(2.1 * k));
  const Vector3d axis(std::cos(k), std::sin(2 * k), std::cos(3 * k));
  X.R = Eigen::AngleAxisd(k, axis.normalized()).toRotationMatrix();
  return X;
}

}  // namespace

bool knows_the_frame(const Rig& rig) {
  if (rig.on_cuboid()) return true;
  const auto instrument = instrument_of(rig);
  std::vector<Index> open;
  for (Index k = 0; k < instrument->parameter_count(); ++k) {
    if (!std::isfinite(instrument->known_to[k])) open.push_back(k);
  }
  if (open.empty()) return true;
  const auto frames = static_cast<Index>(rig.robot.model->frames.size());
  const Index channels = instrument->channel_count();
  const VectorXd& x = instrument->nominal;
  MatrixXd by_x(kPoses * channels, std::ssize(open));
  MatrixXd by_shift = MatrixXd::Zero(kPoses * channels, 3);
  Observation seen;
  for (int pose = 0; pose < kPoses; ++pose) {
    const std::vector<Pose<double>> X(static_cast<std::size_t>(frames), some_pose(pose));
    instrument->kind->observe(
        *instrument, {x.data(), static_cast<std::size_t>(x.size())}, {}, X, false, seen);
    by_x.middleRows(pose * channels, channels) = seen.by_x(Eigen::all, open);
    for (Index frame = 0; frame < frames; ++frame) {
      by_shift.middleRows(pose * channels, channels) += seen.by_frames.middleCols(6 * frame, 3);
    }
  }
  const MatrixXd made_up = by_x.completeOrthogonalDecomposition().solve(by_shift);
  return (by_x * made_up - by_shift).norm() > kSame * by_shift.norm();
}

}  // namespace sixdial::geometry
