// A robot's controller as the collector sees it: go there, tell when there, tell where. How it
// is spoken to is a row of robot_driver.h and a file in robots/.
#pragma once

#include <Eigen/Core>
#include <chrono>
#include <cstdint>
#include <optional>
#include <stop_token>
#include <string>
#include <string_view>
#include <tl/expected.hpp>

#include "acquisition/clock.h"

namespace sixdial::acquisition {

/// A joint as a controller knows it.
struct RobotJoint {
  std::string name;   // "q1"
  bool turns = true;  // its value is an angle [rad]; else a length [mm]
  friend bool operator==(const RobotJoint&, const RobotJoint&) = default;
};

enum class RobotFaultKind {
  kLink,         // the controller does not answer, or not well
  kUnreachable,  // refused: target out of reach
  kHalted,       // stopped on its way by someone else
  kNotThere,     // not in position in time
  kController,   // another fault code
  kCancelled,    // we were asked to stop
};
struct RobotFault {
  RobotFaultKind kind = RobotFaultKind::kLink;
  std::string detail;
};
[[nodiscard]] std::string_view describe(RobotFaultKind kind);

enum class Motion { kIdle = 0, kMoving = 1, kInPosition = 2, kFault = 3 };

struct RobotState {
  Eigen::VectorXd q;  // encoder value of each joint [rad, mm]; empty: not known
  Motion motion = Motion::kIdle;
  int fault_code = 0;
  std::optional<double> temperature_c;
  std::uint16_t moves = 0;  // started, modulo 65536
  std::uint16_t cycle = 0;  // control cycles, modulo 65536: stands still if the controller does
};

class RobotPort {
 public:
  virtual ~RobotPort() = default;
  [[nodiscard]] virtual tl::expected<RobotState, RobotFault> state(
      const std::stop_token& stop) = 0;
  /// Starts the move and waits for it to end [device time]. When stopped, the robot is halted.
  [[nodiscard]] virtual tl::expected<RobotState, RobotFault> move_to(
      const Eigen::VectorXd& q, std::chrono::milliseconds timeout,
      const std::stop_token& stop) = 0;
  /// Stops the robot where it is. Any thread, also while another moves it. An error: it could
  /// not be told, and may be moving on.
  [[nodiscard]] virtual tl::expected<void, RobotFault> halt(const std::stop_token&) {
    return tl::unexpected(RobotFault{
        RobotFaultKind::kController, "this robot has no controller that could stop it"});
  }
  /// How long the controller has not answered [device time]; 0: it does, or there is none.
  [[nodiscard]] virtual std::chrono::milliseconds silent_for() const {
    return std::chrono::milliseconds(0);
  }
  /// Percent of full speed, 1..100; empty where there is no controller.
  [[nodiscard]] virtual tl::expected<std::optional<int>, RobotFault> speed(
      const std::stop_token&) {
    return std::optional<int>();
  }
  [[nodiscard]] virtual tl::expected<void, RobotFault> set_speed(
      int /*percent*/, const std::stop_token&) {
    return {};
  }
  /// A person moves it, who is asked; see ManualRobot.
  [[nodiscard]] virtual bool by_hand() const { return false; }
  /// Of a robot moved by hand, before move_to(): where each joint is brought first, so that it
  /// arrives from the side that is asked for; empty: as it comes.
  virtual void announce_approach(const std::optional<Eigen::VectorXd>& /*from*/) {}
};

}  // namespace sixdial::acquisition
