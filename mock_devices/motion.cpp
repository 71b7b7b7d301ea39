#include "mock_devices/motion.h"

#include <algorithm>
#include <cmath>

namespace sixdial::mock_devices {

MotionLimits limits_of_move(
    const Eigen::VectorXd& from_rad, const Eigen::VectorXd& to_rad, double seconds) {
  constexpr double kShortest_s = 1e-3;
  const double way_rad = (to_rad - from_rad).cwiseAbs().maxCoeff();
  return {
      .speed_rad_s = way_rad / std::max(seconds, kShortest_s),
      .acceleration_rad_s2 = std::numeric_limits<double>::infinity()};
}

Move::Move(
    const Eigen::VectorXd& from_rad, const Eigen::VectorXd& to_rad, double start_s,
    const MotionLimits& limits, double share)
    : from_(from_rad),
      to_(to_rad),
      start_s_(start_s),
      end_s_(start_s),
      way_rad_((to_rad - from_rad).cwiseAbs().maxCoeff()),
      speed_(limits.speed_rad_s * share),
      acceleration_(limits.acceleration_rad_s2),
      ramp_s_(0.0) {
  if (way_rad_ <= 0.0) return;
  // A short way never reaches full speed.
  speed_ = std::min(speed_, std::sqrt(way_rad_ * acceleration_));
  ramp_s_ = std::isinf(acceleration_) ? 0.0 : speed_ / acceleration_;
  end_s_ = start_s + way_rad_ / speed_ + ramp_s_;
}

Eigen::VectorXd Move::at(double asked_s) const {
  const double time_s = std::min(asked_s, stop_s_);
  if (time_s <= start_s_) return from_;
  if (time_s >= end_s_) return to_;
  const double t = time_s - start_s_;
  const double left = end_s_ - time_s;
  double done = 0.0;
  if (t < ramp_s_) {
    done = acceleration_ * t * t / 2;
  } else if (left < ramp_s_) {
    done = way_rad_ - acceleration_ * left * left / 2;
  } else {
    done = speed_ * (t - ramp_s_ / 2);
  }
  return from_ + (to_ - from_) * (done / way_rad_);
}

}  // namespace sixdial::mock_devices
