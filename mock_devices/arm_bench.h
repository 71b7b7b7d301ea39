// A mock arm at work: its controller moves the joints in time, draw wires from its tool to
// anchors on the floor and on stands read through a gauge box, as dials do. What is wrong with
// the arm is that of its ArmWorld. Millimetre, radian, second.
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <deque>
#include <functional>
#include <mutex>
#include <string>
#include <vector>

#include "mock_devices/arm_world.h"
#include "mock_devices/bench.h"
#include "mock_devices/motion.h"

namespace sixdial::mock_devices {

struct ArmSetting {
  ArmWorld world;
  std::vector<Eigen::Vector3d> anchors_mm;  // where the wires begin, in W
  int rows = 150;  // samples that a session will have, for what happens in its middle
  MotionLimits motion{};
};

/// Six anchors around an arm, within reach of wires of 5 m, from the world's seed. The file's
/// base is off by some millimetres, as measured by tape.
[[nodiscard]] ArmSetting drawn_setting(ArmWorld world);

/// Any thread.
class ArmBench final : public Bench {
 public:
  /// `seconds`: the mock time.
  ArmBench(ArmSetting setting, std::function<double()> seconds);

  [[nodiscard]] std::unique_ptr<Panel> panel(std::string connection) override;
  [[nodiscard]] RobotCalls robot_port() override;
  [[nodiscard]] std::vector<std::string> dial_ids() const override;
  [[nodiscard]] std::uint64_t seed() const override { return setting_.world.seed; }

  [[nodiscard]] RobotReport robot() const;
  /// False: out of its range, and it stays where it is.
  bool start_move(const Eigen::VectorXd& q_rad, int speed_percent);
  /// As another controller moves it: there in so many seconds, at constant speed. A move that
  /// is still going on goes on: it counts as one.
  bool follow(const Eigen::VectorXd& q_rad, double seconds);
  void stop();
  /// What nobody may see through the cables: the wire's true length.
  [[nodiscard]] double true_length_mm(std::size_t wire) const;
  /// rig.toml with these connections.
  [[nodiscard]] std::string rig_text(
      const std::string& robot_connection, const std::string& dial_connection) const;

 private:
  class Wires;
  struct Leg {
    Move move;
    Eigen::VectorXd approach;  // of each joint, -1, 0, 1
  };
  /// With the lock held.
  bool set_off(
      const Eigen::VectorXd& target, const MotionLimits& limits, double share, bool goes_on,
      double time_s);
  [[nodiscard]] const Leg& leg_at(double time_s) const;
  [[nodiscard]] Eigen::Vector3d tool(double time_s) const;
  [[nodiscard]] double temperature_c(double time_s) const;
  [[nodiscard]] double shown_mm(std::size_t wire) const;

  const ArmSetting setting_;
  const std::function<double()> seconds_;
  mutable std::mutex mutex_;
  std::deque<Leg> legs_;
  int moves_ = 0;
  RobotFault fault_ = RobotFault::kNone;
};

}  // namespace sixdial::mock_devices
