// Runs a plan: for each point move, wait until the readings settle, read all dials with times
// and quality, check them against the nominal robot, have them stored, next.
//
// Nothing is dropped in silence: a dial without a good reading is stored as such, a point that
// could not be measured is in the result with its reason, and a rig that does not answer at all
// pauses the run with a message.
#pragma once

#include <chrono>
#include <condition_variable>
#include <deque>
#include <functional>
#include <mutex>
#include <optional>
#include <stdexcept>
#include <stop_token>
#include <string>
#include <string_view>
#include <tl/expected.hpp>
#include <utility>
#include <vector>

#include "acquisition/clock.h"
#include "acquisition/plausibility.h"
#include "acquisition/reading.h"
#include "acquisition/robot.h"
#include "acquisition/settling.h"
#include "geometry/rig.h"
#include "session/plan.h"
#include "session/session.h"

namespace sixdial::acquisition {

enum class OnDialFault {
  kStore,  // store the point with that dial marked bad, go on
  kPause,  // pause until a person says resume (measure again), accept or skip
};

/// Where the next point is in another working mode or assembly: a singular pose lies between,
/// and the cuboid would sweep over the dials.
enum class OnBranchChange {
  kPause,  // until a person has brought the legs over and says resume
  kGo,     // the controller (a simulated rig's) does it by itself
};

/// Times are device time.
struct CollectorSettings {
  /// Settled: at least this many readings of a dial, over at least this long, within the
  /// spread.
  int settle_readings = 3;
  std::chrono::milliseconds settle_window{150};
  double settle_spread_mm = 0.0;  // 0: six times the dial's repeatability, at least 0.005
  std::chrono::milliseconds settle_timeout{10'000};
  int fault_retries = 3;  // more readings asked of a dial that did not answer well
  std::chrono::milliseconds retry_pause{200};
  OnDialFault on_dial_fault = OnDialFault::kStore;
  std::chrono::milliseconds move_timeout{60'000};
  int robot_retries = 2;
  double approach_rad = 0.01;   // from how far a joint comes when its side is asked for
  double approach_mm = 1.0;     // ... a linear one
  double implausible_mm = 5.0;  // from the nominal robot
  OnBranchChange on_branch_change = OnBranchChange::kPause;
  /// The robot is halted, and the run paused, where two dials that surely touch the cuboid on a
  /// move lose it at once.
  bool halt_on_lost_contact = true;
};

enum class CollectorStage {
  kMoving,
  kSettling,
  kStored,
  kSkipped,
  kFailed,  // this point cannot be measured; the run goes on
  kPaused,
  kFinished,
  kStopped,
};
[[nodiscard]] std::string_view to_string(CollectorStage stage);

/// Why a run is paused.
enum class PauseReason {
  kAsked,         // by pause()
  kDialFault,     // a dial gave no good reading: resume(), accept() or skip()
  kBranchChange,  // a person has to bring the legs over
  kRobot,         // the robot's controller does not answer well
  kStore,         // the sample cannot be stored now
  kFirstMove,     // a person has to look before anything moves
  kLostContact,   // dials that should touch the cuboid do not: the robot was halted
};
[[nodiscard]] std::string_view to_string(PauseReason reason);

struct CollectorProgress {
  CollectorStage stage = CollectorStage::kMoving;
  std::size_t done = 0;      // stored, also before this run, skipped, failed or left out
  std::size_t total = 0;     // points of the plan
  std::size_t left_out = 0;  // not wanted any more, in `done` too
  std::optional<std::size_t> plan_index;
  std::optional<double> eta_s;  // on the wall
  std::string message;          // what is wrong, or worth knowing
  /// While the stage is kPaused: why, and what is wrong without the advice in `message`.
  std::optional<PauseReason> pause;
  std::string trouble;
  std::vector<Reading> readings;
  std::vector<DialSettling> settling;  // by dial; empty where nobody waits for them to rest
};

struct CollectedSample {
  session::Sample sample;
  std::size_t plan_index = 0;
  int attempt = 1;                   // above 1: a retake in this run
  std::vector<std::string> remarks;  // "dial C: timeout, no answer"
};

struct CollectorResult {
  struct Point {
    std::size_t plan_index = 0;
    std::string why;
  };
  bool complete = false;  // false: stopped
  std::size_t stored = 0;
  std::size_t already_done = 0;
  std::vector<Point> skipped;
  std::vector<Point> failed;
  std::size_t left_out = 0;  // not wanted any more
};

/// Thrown by the store callback if the sample can be stored once something is put right, such
/// as a full disk. The run pauses with this message, and resume() tries the same sample again.
class StoreLater : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

class Collector {
 public:
  struct Callbacks {
    /// Stores the sample; it must be on the disk when this returns. Any exception but
    /// StoreLater ends the run and is thrown by run().
    std::function<void(const CollectedSample&)> store;
    std::function<void(const CollectorProgress&)> progress;  // may be empty
    std::function<bool(const session::PlanPoint&)>
        done;  // stored in an earlier run; may be empty
    /// Asked before each point: false leaves it out, as enough is known. May be empty.
    std::function<bool(const session::PlanPoint&)> wanted = {};
  };

  /// Robot, dials and clock must outlive the collector. Throws std::invalid_argument if there
  /// is nothing to store with, or the dials are not the rig's.
  Collector(
      geometry::Rig rig, session::Plan plan, RobotPort& robot, DialSource& dials, Clock& clock,
      Callbacks callbacks, CollectorSettings settings = {});

  /// Before run(): what a person has to see to before the first move, which waits for resume().
  void ask_before_first_move(std::string what) { before_first_move_ = std::move(what); }
  /// Blocks until done or stopped. Callbacks come from this thread. Once.
  CollectorResult run(const std::stop_token& stop);

  // From any thread, also from the callbacks. Each but pause() also ends a pause.
  void pause();   // after the point in hand
  void resume();  // goes on; with the same point if it was the reason for the pause
  void skip();    // the point in hand; while paused, the next one
  /// Measures again: the point in hand from its start; between points, or while paused there,
  /// the one stored last, as a new row.
  void retake();
  void retake(std::size_t plan_index);  // that point, as the next one
  void accept();  // while paused for a dial fault: store the point as it is

 private:
  enum class Wish { kNone, kSkip, kRetake, kAccept };
  enum class Outcome { kStored, kSkipped, kFailed, kAgain, kStopped };
  struct Measured {
    std::vector<Reading> readings;
    std::vector<std::size_t> faulty;
  };
  template <typename T>
  using OrOutcome = tl::expected<T, Outcome>;

  std::optional<std::size_t> next_point();
  Outcome point(std::size_t index, const std::stop_token& stop);
  Outcome measure(std::size_t index, const std::stop_token& here, const std::stop_token& stop);
  OrOutcome<RobotState> go(
      std::size_t index, const std::stop_token& here, const std::stop_token& stop);
  tl::expected<RobotState, RobotFault> move(
      const Eigen::VectorXd& q, const std::stop_token& here);
  /// robot_.move_to, with an eye on the dials that surely touch all the way.
  tl::expected<RobotState, RobotFault> guarded_move(
      const Eigen::VectorXd& q, const std::stop_token& here);
  [[nodiscard]] std::vector<std::size_t> sure_contacts(const Eigen::VectorXd& q) const;
  Outcome lost_contact(std::size_t index, const std::stop_token& stop);
  bool asked_before_first_move(const std::stop_token& stop);
  [[nodiscard]] std::optional<Eigen::VectorXd> pre_position(
      const session::PlanPoint& point) const;
  std::optional<Outcome> change_branch(
      std::size_t index, const std::stop_token& here, const std::stop_token& stop);
  [[nodiscard]] session::Branch branch_now(const std::stop_token& here);
  /// Empty: store what was measured, its faults among the remarks.
  std::optional<Outcome> judge_faults(
      std::size_t index, const Measured& measured, const std::stop_token& stop);
  OrOutcome<Measured> settle(
      std::size_t index, const std::stop_token& here, const std::stop_token& stop);
  Outcome store(
      std::size_t index, const RobotState& state, std::vector<Reading> readings,
      const std::stop_token& stop);
  /// Empty: the sample is stored.
  std::optional<Outcome> keep(const CollectedSample& collected, const std::stop_token& stop);
  Outcome robot_trouble(
      std::size_t index, const RobotFault& fault, const std::stop_token& stop);
  Outcome skipped(std::size_t index, const std::string& why);
  Outcome interrupted(std::size_t index, const std::stop_token& stop);
  Wish wait_paused(
      std::optional<std::size_t> index, PauseReason reason, const std::string& trouble,
      const std::string& advice, const std::stop_token& stop);
  Wish take_wish();
  void wish(Wish wish);
  [[nodiscard]] CollectorProgress progress_at(
      CollectorStage stage, std::optional<std::size_t> index) const;
  void report(
      CollectorStage stage, std::optional<std::size_t> index, std::string message = {},
      std::vector<Reading> readings = {});
  [[nodiscard]] std::optional<double> eta_s() const;

  geometry::Rig rig_;
  session::Plan plan_;
  RobotPort& robot_;
  DialSource& dials_;
  Clock& clock_;
  Callbacks callbacks_;
  CollectorSettings settings_;
  std::string before_first_move_;  // empty: it begins at once
  Plausibility plausibility_;
  CollectorResult result_;

  std::deque<std::size_t> pending_;
  std::vector<int> attempts_;
  std::vector<bool> counted_;  // in done_
  std::size_t done_ = 0;
  std::optional<std::size_t> last_stored_;
  std::vector<Reading> last_readings_;
  std::vector<DialSettling> settling_;  // at the point in hand
  std::vector<ExpectedDial> last_expected_;
  std::vector<int> last_move_;  // sign of each joint's; 0: not known
  std::optional<Eigen::VectorXd> last_q_;
  std::vector<std::string> lost_;          // dials that lost the cuboid on the last move
  std::optional<session::Branch> branch_;  // the legs stand in; empty: nobody knows yet
  std::vector<std::string> remarks_;       // of the point in hand
  DeviceTime started_{0};
  DeviceTime paused_for_{0};

  mutable std::mutex mutex_;  // for what commands touch, from here on
  std::condition_variable_any changed_;
  bool pause_wanted_ = false;
  bool paused_ = false;
  Wish wish_ = Wish::kNone;
  std::deque<std::size_t> retakes_;
  std::optional<std::stop_source> here_;  // stops the point in hand
};

}  // namespace sixdial::acquisition
