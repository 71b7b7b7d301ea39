// The collection of a session on the rig: one at a time, in a thread of its own, with its
// state, its commands and its events. Each sample is on the disk before anyone is told of it.
#pragma once

#include <atomic>
#include <chrono>
#include <condition_variable>
#include <cstdint>
#include <map>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <thread>

#include "acquisition/clock.h"
#include "acquisition/collector.h"
#include "acquisition/dial_bank.h"
#include "acquisition/robot.h"
#include "acquisition/robots/manual_robot.h"
#include "db/store.h"
#include "service/methods/method.h"
#include "service/socket/event_hub.h"
#include "studies/live_estimate.h"

namespace sixdial::service {

enum class CollectState {
  kIdle,  // none since the service began
  kStarting,
  kRunning,
  kPaused,
  kStopping,
  kDone,     // every point of the plan is stored, skipped or failed, or needed no more
  kStopped,  // by a command; goes on at the next point when started again
  kFailed,   // `error` says why; what was acknowledged is stored
};
[[nodiscard]] std::string_view to_string(CollectState state);
[[nodiscard]] bool is_active(CollectState state);
/// The state in an answer of collect.status or collect.wait.
[[nodiscard]] CollectState collect_state_of(const Json& status);

struct CollectRequest {
  std::string session;
  std::optional<session::Plan> plan{};  // empty: the session's own
  acquisition::CollectorSettings settings{};
  /// Points of G1 are left out once the position uncertainty at the worst place of the
  /// workspace (standard deviation, LiveEstimate) is below this.
  std::optional<double> stop_below_mm{};
  /// Percent of the controller's full speed; as before again at the end. Empty: as it is.
  std::optional<int> speed_percent{};
  /// Only goes to the outermost points, slowly, and looks whether the dials show there what
  /// they should; asks a person before the first move, and stores nothing.
  bool first_pass = false;
  Caller caller{};
};
inline constexpr int kFirstPassSpeed_percent = 10;

class Collection {
 public:
  /// All must outlive the collection. `changed` is called after each change of the state,
  /// `take_ports` before the devices are opened, so that others release their ports. Without
  /// `allow_exec` no program is run that a rig file names.
  Collection(
      EventHub& events, db::Store& store, acquisition::Clock& clock,
      std::function<void()> changed, std::function<void()> take_ports = {},
      bool allow_exec = false);
  ~Collection();  // stop() and wait
  Collection(const Collection&) = delete;
  Collection& operator=(const Collection&) = delete;

  /// Throws Error: wrong_state (one is active; the plan contradicts what is measured),
  /// not_found, bad_data (no plan, connection strings).
  Json start(CollectRequest request);
  [[nodiscard]] Json status() const;
  [[nodiscard]] bool active() const;
  /// Why a sample of the session that is or was collected last is worth another look: its
  /// residual is large against the fit so far. Empty: it is not.
  [[nodiscard]] std::string unusual(
      const std::string& session, const db::PointKey& point) const;
  /// A sample was withdrawn: the estimate is made anew from what is left. If another collection
  /// begins meanwhile, or another sample is withdrawn, this estimate is out of date and
  /// dropped.
  void samples_changed(const std::string& session);

  // Commands of an active collection; throw Error wrong_state otherwise.
  void pause();
  void resume();
  void skip();
  void retake();
  void accept();
  /// A person's answer to "move": the robot is there, or cannot go there.
  void moved(acquisition::ManualAnswer answer);
  /// Stops the robot where it is, and pauses: resume goes to the point in hand again. Throws
  /// Error device where the robot cannot be told.
  void halt_robot();
  /// Ends it; the point in hand is rolled back. Does not wait.
  void stop();
  /// stop() and wait for the thread.
  void stop_and_wait();
  /// Until it has ended, `stop` is asked for or `longest` is over; true: it has ended.
  [[nodiscard]] bool wait_for_end(
      const std::stop_token& stop, std::chrono::milliseconds longest) const;

 private:
  struct Run;  // what one collection owns: robot, dials, collector
  std::shared_ptr<Run> made_run(CollectRequest& request);
  static void prepare_first_pass(Run& run);
  void connect_devices(Run& run);
  void make_collector(Run& run);
  void forget_last_run();
  void run(Run& run, const std::stop_token& stop);
  void finish(CollectState state, Json error, std::string why);
  /// `sample` as its instrument shows it.
  bool take_in(Run& run, const session::Sample& sample);
  void take_in_stored(Run& run);
  void show_estimate(const Run& run);
  [[nodiscard]] std::string why_ended(
      const Run& run, CollectState state, const acquisition::CollectorResult& result) const;
  void publish(std::string_view type, Json more = Json::object());
  void on_progress(const acquisition::CollectorProgress& progress);
  void on_sample(Run& run, const acquisition::CollectedSample& sample);
  void on_rehearsed(Run& run, const acquisition::CollectedSample& sample);
  [[nodiscard]] Json move_json() const;
  void store_sample(Run& run, const session::Sample& sample, bool& retaken);
  void watch_clock(Run& run);
  void publish_live(const std::stop_token& stop, Run& run);
  std::optional<acquisition::ManualAnswer> ask_person(
      const Eigen::VectorXd& q, const std::stop_token& stop);
  [[nodiscard]] Json status_locked() const;
  template <typename Command>
  void command(std::string_view name, Command command);

  EventHub& events_;
  db::Store& store_;
  acquisition::Clock& clock_;
  const std::function<void()> changed_;
  const std::function<void()> take_ports_;
  const bool allow_exec_;

  mutable std::mutex mutex_;
  std::condition_variable_any answered_;
  mutable std::condition_variable_any ended_;
  CollectState state_ = CollectState::kIdle;
  std::string session_;
  std::string operator_name_;
  acquisition::CollectorProgress progress_;
  std::size_t stored_ = 0, skipped_ = 0, failed_ = 0, left_out_ = 0;  // in this run
  std::map<db::PointKey, double> unusual_;            // times the usual residual
  std::optional<studies::EstimateSummary> estimate_;  // empty: nothing of G1 so far
  std::uint64_t estimate_turn_ = 0;         // counts what makes an older estimate out of date
  std::string ended_because_;               // empty while it runs
  Json clock_steps_ = Json::array();        // when the time of day was changed, in this run
  std::vector<std::string> clock_remarks_;  // for the next sample
  Json troubles_ = Json::array();           // points without a sample, and why
  Json error_;
  std::optional<Eigen::VectorXd> asked_q_;     // a person is to move the robot there
  std::optional<Eigen::VectorXd> asked_from_;  // from here, as far as is known
  std::optional<Eigen::VectorXd> asked_via_;   // by way of here
  std::optional<acquisition::ManualAnswer> answer_;
  /// Shared: samples_changed() may still look at the last one while start() makes the next.
  std::shared_ptr<Run> run_;

  std::mutex publish_mutex_;  // who tells the state holds it; taken before mutex_
  std::mutex thread_mutex_;   // who starts or joins thread_ holds it; taken before mutex_
  std::jthread thread_;
};

}  // namespace sixdial::service
