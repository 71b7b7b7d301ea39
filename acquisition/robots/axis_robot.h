// What robots share whose controllers take G-code, whatever it is carried in: each joint an
// axis with a letter, a turning joint in degrees, a linear one in mm; one channel, silence,
// speed.
//
//   axis_letters(options, joints, "XYZ")                     -> "XYZ"
//   AxisRobot::move_words({57.29578, -11.45916}, 600.0)      -> "G1 X57.29578 Y-11.45916 F600"
#pragma once

#include <atomic>
#include <functional>
#include <memory>
#include <mutex>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "acquisition/line_channel.h"
#include "acquisition/longest_silence.h"
#include "acquisition/robot.h"

namespace sixdial::acquisition {

class ConnectionOptions;

/// axes=X,Y,Z or axes=XYZ: a letter of `known` for each joint, the first ones if it is not
/// given. Throws Refused.
[[nodiscard]] std::string axis_letters(
    const ConnectionOptions& options, std::span<const RobotJoint> joints,
    std::string_view known);

/// As commands say it: "57.29578", "-3", "0".
[[nodiscard]] std::string figure_text(double value);

struct AxisSettings {
  std::string axes{};                       // the letter of each joint, in the rig's order
  double feed = 600.0;                      // at full speed, deg or mm a minute
  double arrived = 0.05;                    // how far from its target a joint may end [deg, mm]
  std::chrono::milliseconds timeout{2000};  // for an answer that needs no move [device time]
  std::string place{};                      // for messages: "/dev/ttyUSB0", "10.0.0.7:5007"
};
/// axes, feed, arrived, timeout_ms of a connection string. Throws Refused.
[[nodiscard]] AxisSettings axis_settings(
    const ConnectionOptions& options, std::span<const RobotJoint> joints,
    std::string_view known, std::string place);

/// Any thread; one exchange at a time, but halt() goes through at once.
class AxisRobot : public RobotPort {
 public:
  using Open = std::function<tl::expected<std::unique_ptr<LineChannel>, Fault>()>;
  [[nodiscard]] tl::expected<RobotState, RobotFault> state(const std::stop_token& stop) final;
  [[nodiscard]] tl::expected<RobotState, RobotFault> move_to(
      const Eigen::VectorXd& q, std::chrono::milliseconds timeout,
      const std::stop_token& stop) final;
  [[nodiscard]] std::chrono::milliseconds silent_for() const final {
    return silence_.lasts(clock_);
  }
  [[nodiscard]] tl::expected<std::optional<int>, RobotFault> speed(
      const std::stop_token& stop) final;
  [[nodiscard]] tl::expected<void, RobotFault> set_speed(
      int percent, const std::stop_token& stop) final;

 protected:
  template <typename T>
  using OrFault = tl::expected<T, RobotFault>;
  using WallTime = std::chrono::steady_clock::time_point;

  /// `clock` must outlive the robot.
  AxisRobot(AxisSettings settings, Open open, Clock& clock, std::span<const RobotJoint> joints);

  /// state(), in its turn.
  virtual OrFault<RobotState> state_now(const std::stop_token& stop) = 0;
  /// move_to(), in its turn; `target` [deg, mm] to the digits of commands, in the order of the
  /// axes.
  virtual OrFault<RobotState> go_to(
      const std::vector<double>& target, std::chrono::milliseconds timeout,
      const std::stop_token& stop) = 0;
  /// An exchange was broken off: half a message may be out, or an answer still to come. The
  /// next exchange begins with a new connection, unless it can come into step on this one.
  virtual void lose_step() { close_channel(); }

  [[nodiscard]] std::string move_words(std::span<const double> values, double feed) const;
  /// Feed of the next move [deg, mm a minute].
  [[nodiscard]] double feed() const { return settings_.feed * percent_ / 100.0; }
  /// When a move that begins now has to have ended.
  [[nodiscard]] WallTime ends_by(std::chrono::milliseconds timeout) const;
  /// Standing there [deg, mm]; one that rests is in position, or idle if it never moved.
  [[nodiscard]] RobotState state_of(std::span<const double> stands, Motion motion) const;
  /// Empty: every axis stands within `arrived` of its target.
  [[nodiscard]] std::optional<RobotFault> not_there(
      std::span<const double> stands, std::span<const double> target) const;

  static constexpr std::chrono::milliseconds kTurn{5};  // between two looks whose turn it is
  /// The turn of a halt() that found no move; empty: one began meanwhile, it is told to stop.
  [[nodiscard]] std::unique_lock<std::mutex> turn_of_halt();

  [[nodiscard]] RobotFault link_fault(const Fault& fault) const;
  [[nodiscard]] WallTime answer_by() const;
  /// Waits for no answer longer than this: it is silent then.
  [[nodiscard]] std::chrono::nanoseconds longest_wait() const;
  [[nodiscard]] bool is_open();
  /// Opens the channel if there is none; whether it is a new one.
  OrFault<bool> open_channel();
  OrFault<void> tell(std::string_view bytes);
  /// From any thread, whoever exchanges meanwhile. False: there is no channel.
  OrFault<bool> tell_meanwhile(std::string_view bytes);
  /// Empty: nothing whole came by then; what came of it is kept. After an error but kCancelled
  /// the exchange is broken off.
  OrFault<std::optional<std::string>> hear(WallTime deadline, const std::stop_token& stop);
  /// The same as `parse` reads it, a function from a text to an optional; empty likewise.
  /// `form`: what it takes, for people.
  template <typename Parse>
  auto hear(
      WallTime deadline, const std::stop_token& stop, const Parse& parse, std::string_view form)
      -> OrFault<decltype(parse(std::string_view()))>;
  /// The controller does not answer: noted, and in words.
  RobotFault silent(std::string_view asked);
  /// It says what is none of its messages.
  RobotFault stranger(std::string_view text, std::string_view what_it_should_be);
  void close_channel();

  const AxisSettings settings_;
  const std::vector<RobotJoint> joints_;
  Clock& clock_;
  std::mutex mutex_;                     // an exchange
  std::atomic<bool> moving_{false};      // move_to() is at it, or waits for its turn
  std::atomic<bool> stop_asked_{false};  // of this move, by halt()
  std::atomic<bool> halted_{false};      // the last move was ended on its way
  std::uint16_t moves_ = 0;

 private:
  /// Of a move: as long as it lives, halt() is about this move.
  class Moving;

  /// Empty: it can be sent there as far as this program knows.
  [[nodiscard]] std::optional<RobotFault> bad_target(const Eigen::VectorXd& q) const;
  /// To the digits of commands [deg, mm], in the order of the axes.
  [[nodiscard]] std::vector<double> commanded(const Eigen::VectorXd& q) const;
  void note_answer(bool came) { silence_.note(came, clock_.monotonic()); }
  /// False: there is no channel.
  tl::expected<bool, Fault> write(std::string_view bytes);
  /// Noted, and in words.
  RobotFault broken_off(const Fault& fault);

  const Open open_;
  std::mutex write_mutex_;  // bytes out, and channel_; taken after mutex_
  std::unique_ptr<LineChannel> channel_;
  std::string waits_with_;  // what of an answer has come, for people
  std::atomic<int> percent_{100};
  Silence silence_;
};

template <typename Parse>
auto AxisRobot::hear(
    WallTime deadline, const std::stop_token& stop, const Parse& parse, std::string_view form)
    -> OrFault<decltype(parse(std::string_view()))> {
  const auto text = hear(deadline, stop);
  if (!text) return tl::unexpected(text.error());
  if (!*text) return decltype(parse(std::string_view()))();
  auto message = parse(**text);
  if (!message) return tl::unexpected(stranger(**text, form));
  note_answer(true);
  return message;
}

}  // namespace sixdial::acquisition
