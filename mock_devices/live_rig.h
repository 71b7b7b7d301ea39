// The true rig in time: a controller that moves the joints, and dials that follow, settle, hold
// their last value at their own rate and lag behind fast moves. Time is handed in by the caller
// and must not run backwards by more than a dial's hold; one thread at a time.
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <deque>
#include <optional>
#include <vector>

#include "mock_devices/motion.h"
#include "mock_devices/world.h"

namespace sixdial::mock_devices {

enum class MotionState : std::uint16_t { kIdle = 0, kMoving = 1, kInPosition = 2, kFault = 3 };
enum class RobotFault : std::uint16_t { kNone = 0, kOutOfReach = 1, kStopped = 2 };

struct RobotReport {
  MotionState state = MotionState::kIdle;
  RobotFault fault = RobotFault::kNone;
  Eigen::VectorXd q_rad = Eigen::VectorXd::Zero(2);  // by the encoders
  std::uint16_t moves_started = 0;
  double temperature_c = 20.0;
  std::uint16_t cycles = 0;
};

/// What a dial's display shows.
struct DialFace {
  double value_mm = 0.0;
  bool in_contact = false;
  bool at_travel_end = false;
  bool moving_fast = false;
};

struct LiveRigHabits {
  MotionLimits motion;
  double encoder_step_rad = 2.0 * 3.14159265358979323846 / 4194304.0;  // 22 bit
  double cycle_s = 0.004;
  /// Above this speed of its plunger a dial has no valid value.
  double fast_mm_s = 15.0;
  double hysteresis_play_mm = 0.002;  // a reversal shorter than this keeps the direction
};

class LiveRig {
 public:
  explicit LiveRig(const World& world, const LiveRigHabits& habits = {});

  /// False: refused, out of reach on the way or at the target; the robot stays where it is.
  /// A move into another working mode passes singular poses: an operator helps the legs across,
  /// so only its end must be in reach, and the tool ends on the dials' side of the elbows.
  bool start_move(const Eigen::Vector2d& q_rad, int speed_percent, double time_s);
  /// As another controller moves it: there in so many seconds, at constant speed. A move that
  /// is still going on goes on: it counts as one. False as start_move.
  bool follow(const Eigen::Vector2d& q_rad, double seconds, double time_s);
  void stop(double time_s);
  [[nodiscard]] RobotReport robot(double time_s) const;
  [[nodiscard]] DialFace dial(std::size_t name, double time_s);

  /// Tool, cuboid and plungers as they truly are. Throws std::logic_error in the middle of a
  /// change of working mode, where the links may be open.
  [[nodiscard]] TruePose true_pose(double time_s) const;
  [[nodiscard]] const WorldModel& model() const { return model_; }
  /// Readings a second and settling time constant [s] of a dial.
  [[nodiscard]] double rate_hz(std::size_t dial) const { return dials_[dial].rate_hz; }
  [[nodiscard]] double settling_s(std::size_t dial) const { return dials_[dial].tau_s; }

 private:
  struct Dial {
    double rate_hz, phase, tau_s;
    std::int64_t tick = -1;
    double plunger_mm = 0.0;  // follows the true displacement
    double turning_mm = 0.0;  // furthest point in the present direction
    int direction = 0;
    DialFace face;
    double before_move_mm = 0.0;
  };

  bool set_off(
      const Eigen::Vector2d& target, const MotionLimits& limits, double share, bool goes_on,
      double time_s);
  [[nodiscard]] Moment moment(double time_s) const;
  /// Direction in W of the tool's last real move, zero before the first.
  [[nodiscard]] Eigen::Vector2d last_travel(const Moment& now) const;
  struct Leg {
    Move move;
    geometry::Assembly assembly;
    bool changes_mode;
  };
  [[nodiscard]] const Leg& leg_at(double time_s) const;
  [[nodiscard]] geometry::Assembly assembly_for(const Eigen::Vector2d& q_rad) const;
  void advance(double time_s);
  void advance(std::size_t index, double time_s);
  void follow(Dial& dial, std::size_t index, double from_s, double to_s, bool at_rest);

  WorldModel model_;
  LiveRigHabits habits_;
  std::deque<Leg> legs_;
  std::vector<Dial> dials_;
  MotionState resting_state_ = MotionState::kIdle;
  RobotFault fault_ = RobotFault::kNone;
  std::int64_t moves_started_ = 0;
  std::array<int, 2> approach_{0, 0};
};

}  // namespace sixdial::mock_devices
