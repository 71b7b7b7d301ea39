// A robot's controller as the collector sees it: go there, tell when there, tell where.
// ModbusRobot speaks to a controller (doc/devices.md), ManualRobot asks a person.
#pragma once

#include <Eigen/Core>
#include <atomic>
#include <chrono>
#include <functional>
#include <mutex>
#include <optional>
#include <stop_token>
#include <string>
#include <string_view>
#include <tl/expected.hpp>

#include "acquisition/clock.h"
#include "acquisition/modbus_link.h"

namespace sixdial::acquisition {

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

/// Angles on the wire are int32 of 1e-8 rad; what does not fit is refused as unreachable.
inline constexpr double kRadPerCount = 1e-8;

/// The controller of two joints of doc/devices.md. Any thread: one exchange at a time.
class ModbusRobot final : public RobotPort {
 public:
  /// `clock` must outlive the robot.
  ModbusRobot(const ModbusConnection& connection, Clock& clock);
  [[nodiscard]] tl::expected<RobotState, RobotFault> state(
      const std::stop_token& stop) override;
  [[nodiscard]] tl::expected<RobotState, RobotFault> move_to(
      const Eigen::VectorXd& q, std::chrono::milliseconds timeout,
      const std::stop_token& stop) override;
  [[nodiscard]] tl::expected<std::optional<int>, RobotFault> speed(
      const std::stop_token& stop) override;
  [[nodiscard]] tl::expected<void, RobotFault> set_speed(
      int percent, const std::stop_token& stop) override;
  [[nodiscard]] tl::expected<void, RobotFault> halt(const std::stop_token& stop) override;
  [[nodiscard]] std::chrono::milliseconds silent_for() const override;
  [[nodiscard]] LinkState link_state() const;

 private:
  tl::expected<Words, Fault> read(
      int function, int address, int count, const std::stop_token& stop);
  tl::expected<void, Fault> write(int address, const Words& words, const std::stop_token& stop);
  tl::expected<void, RobotFault> start(
      const Eigen::VectorXd& q, std::uint16_t moves_before, const std::stop_token& stop);
  tl::expected<RobotState, RobotFault> wait_in_position(
      std::uint16_t moves_before, DeviceTime deadline, const std::stop_token& stop);

  void note_answer(bool came, DeviceTime asked);

  int unit_;
  Clock& clock_;
  mutable std::mutex mutex_;
  ModbusLink link_;
  std::atomic<DeviceTime::rep> silent_since_{0};  // 0: it answers
};

/// What a person says after moving the robot.
struct ManualAnswer {
  bool done = true;                  // false: this point cannot be reached
  std::optional<Eigen::VectorXd> q;  // as shown by the encoders; else as asked for
  std::optional<double> temperature_c;
};

class ManualRobot final : public RobotPort {
 public:
  /// Asks a person to bring the joints to q and comes back with the answer; empty if
  /// stopped or timed out. Called from the collector's thread.
  using Ask = std::function<std::optional<ManualAnswer>(
      const Eigen::VectorXd& q, const std::stop_token& stop)>;
  explicit ManualRobot(Ask ask) : ask_(std::move(ask)) {}
  [[nodiscard]] tl::expected<RobotState, RobotFault> state(
      const std::stop_token& stop) override;
  /// No time limit: people take the time they need.
  [[nodiscard]] tl::expected<RobotState, RobotFault> move_to(
      const Eigen::VectorXd& q, std::chrono::milliseconds timeout,
      const std::stop_token& stop) override;
  [[nodiscard]] bool by_hand() const override { return true; }
  void announce_approach(const std::optional<Eigen::VectorXd>& from) override {
    approach_from_ = from;
  }
  /// Where the person said last that it is; empty: nobody has.
  [[nodiscard]] std::optional<Eigen::VectorXd> stands_at() const {
    return state_.q.size() > 0 ? std::optional(state_.q) : std::nullopt;
  }
  /// For what asks: from its call on.
  [[nodiscard]] const std::optional<Eigen::VectorXd>& approach_from() const {
    return approach_from_;
  }

 private:
  Ask ask_;
  RobotState state_;
  std::optional<Eigen::VectorXd> approach_from_;
};

}  // namespace sixdial::acquisition
