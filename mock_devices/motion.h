// Point-to-point moves of any number of joints: trapezoid of speed, all joints start and end
// together.
#pragma once

#include <Eigen/Core>
#include <algorithm>
#include <limits>

namespace sixdial::mock_devices {

struct MotionLimits {
  double speed_rad_s = 0.8;
  double acceleration_rad_s2 = 4.0;  // infinite gives constant speed
};
/// A move that takes so many seconds, at constant speed, as a machine makes that takes G-code.
[[nodiscard]] MotionLimits limits_of_move(
    const Eigen::VectorXd& from_rad, const Eigen::VectorXd& to_rad, double seconds);

class Move {
 public:
  /// `share` of full speed, in (0, 1].
  Move(
      const Eigen::VectorXd& from_rad, const Eigen::VectorXd& to_rad, double start_s,
      const MotionLimits& limits, double share);

  [[nodiscard]] double start_s() const { return start_s_; }
  [[nodiscard]] double end_s() const { return std::min(end_s_, stop_s_); }
  [[nodiscard]] const Eigen::VectorXd& from_rad() const { return from_; }
  [[nodiscard]] const Eigen::VectorXd& to_rad() const { return to_; }
  [[nodiscard]] Eigen::VectorXd at(double time_s) const;
  /// Stops the joints where they are at that time.
  void cut(double time_s) { stop_s_ = std::min(stop_s_, time_s); }

 private:
  Eigen::VectorXd from_, to_;
  double start_s_, end_s_;
  double stop_s_ = std::numeric_limits<double>::infinity();
  double way_rad_;  // of the joint that goes further
  double speed_, acceleration_, ramp_s_;
};

}  // namespace sixdial::mock_devices
