#include "service/collection.h"

#include <fmt/format.h>
#include <spdlog/spdlog.h>

#include <algorithm>
#include <cmath>
#include <set>
#include <utility>

#include "acquisition/clock_watch.h"
#include "acquisition/connection.h"
#include "report/documents/estimate_json.h"
#include "service/live_dials.h"
#include "service/sample_json.h"
#include "service/store_json.h"

namespace sixdial::service {
namespace {

using acquisition::CollectorStage;

constexpr auto kLiveEvery = std::chrono::milliseconds(200);  // on the wall
constexpr std::size_t kMostTroubles = 50;
constexpr std::size_t kMostClockSteps = 20;

template <typename T>
Json or_null(const std::optional<T>& value) {
  return value ? Json(*value) : Json(nullptr);
}

/// The plan must not name another place for a point that is measured already: it would be
/// passed over as done.
void check_plan_fits(const session::Plan& plan, const session::Session& measured) {
  constexpr double kSamePlace_mm = 1e-3;
  for (const session::PlanPoint& point : plan.points) {
    for (const session::Sample& sample : measured.samples) {
      if (sample.set != point.set || sample.point != point.point ||
          sample.repeat != point.repeat || !sample.target_mm) {
        continue;
      }
      const double apart_mm = (*sample.target_mm - point.target_mm).norm();
      if (apart_mm <= kSamePlace_mm) continue;
      throw Error(
          ErrorCode::kWrongState,
          fmt::format(
              "{} point {} repeat {} is measured, {:.3f} mm from where this plan wants it",
              point.set, point.point, point.repeat, apart_mm),
          {{"session", measured.name}, {"set", point.set}, {"point", point.point}},
          "Collect another plan into another session, or give its points other numbers.");
    }
  }
}

}  // namespace

struct Collection::Run {
  explicit Run(const acquisition::Clock& clock) : clock_watch(clock) {}

  db::SessionId id;
  geometry::Rig rig;
  session::Plan plan;
  std::set<db::PointKey> done;
  acquisition::CollectorSettings settings;
  std::optional<double> stop_below_mm;
  Caller caller;
  std::optional<studies::LiveEstimate> estimate;  // in the collection's thread alone
  acquisition::ClockWatch clock_watch;
  std::unique_ptr<acquisition::RobotPort> robot;
  std::unique_ptr<acquisition::DialBank> dials;
  std::unique_ptr<acquisition::Collector> collector;
  std::jthread live;  // last: it looks at the dials
};

std::string_view to_string(CollectState state) {
  switch (state) {
    case CollectState::kIdle:
      return "idle";
    case CollectState::kStarting:
      return "starting";
    case CollectState::kRunning:
      return "running";
    case CollectState::kPaused:
      return "paused";
    case CollectState::kStopping:
      return "stopping";
    case CollectState::kDone:
      return "done";
    case CollectState::kStopped:
      return "stopped";
    case CollectState::kFailed:
      return "failed";
  }
  return "";
}

bool is_active(CollectState state) {
  return state == CollectState::kStarting || state == CollectState::kRunning ||
         state == CollectState::kPaused || state == CollectState::kStopping;
}

Collection::Collection(
    EventHub& events, db::Store& store, acquisition::Clock& clock,
    std::function<void()> changed)
    : events_(events), store_(store), clock_(clock), changed_(std::move(changed)) {}

Collection::~Collection() { stop_and_wait(); }

Json Collection::start(CollectRequest request) {
  const std::lock_guard lock(mutex_);
  if (is_active(state_)) {
    throw Error(
        ErrorCode::kWrongState, fmt::format("session {} is being collected", session_),
        {{"session", session_}}, "Stop it first: collect.stop.");
  }
  if (thread_.joinable()) thread_.join();  // it has ended
  auto run = std::make_unique<Run>(clock_);
  run->id = store_.find_session(request.session);
  run->rig = store_.load_rig(run->id);
  run->settings = request.settings;
  run->stop_below_mm = request.stop_below_mm;
  run->caller = request.caller;
  const auto planned = store_.load_plan(run->id);
  if (request.plan) {
    check_plan_fits(*request.plan, store_.load_session(run->id));
    if (!planned || *planned != *request.plan) store_.save_plan(run->id, *request.plan);
    run->plan = *std::move(request.plan);
  } else if (planned) {
    run->plan = *planned;
  } else {
    throw Error(
        ErrorCode::kBadData, fmt::format("session {} has no plan", request.session),
        {{"session", request.session}},
        "Give one: plan_csv, made by plan.grid or plan.random.");
  }
  for (const db::PointKey& key : store_.done_points(run->id)) run->done.insert(key);

  const auto robot = acquisition::parse_robot_connection(run->rig.robot.connection);
  if (!robot) {
    throw Error(
        ErrorCode::kBadData, "the robot's connection: " + robot.error(), {{"field", "robot"}},
        R"(In rig.toml: connection = "modbus-tcp://host:port" or "manual" under [robot].)");
  }
  if (const auto* modbus = std::get_if<acquisition::ModbusConnection>(&*robot)) {
    run->robot = std::make_unique<acquisition::ModbusRobot>(*modbus, clock_);
  } else {
    run->robot = std::make_unique<acquisition::ManualRobot>(
        [this](const Eigen::Vector2d& q_rad, const std::stop_token& stop) {
          return ask_person(q_rad, stop);
        });
  }
  auto dials = acquisition::DialBank::open(run->rig, clock_);
  if (!dials) {
    throw Error(
        ErrorCode::kBadData, dials.error(), {{"field", "dial"}},
        "Each [[dial]] in rig.toml needs a connection.");
  }
  run->dials = *std::move(dials);
  store_.record_action(
      to_operator(request.caller), "collect.start", run->id,
      fmt::format("{} points", run->plan.points.size()));

  state_ = CollectState::kStarting;
  session_ = request.session;
  operator_name_ = request.caller.operator_name;
  progress_ = {};
  progress_.total = run->plan.points.size();
  stored_ = skipped_ = failed_ = left_out_ = 0;
  estimate_.reset();
  unusual_.clear();
  ended_because_.clear();
  troubles_ = Json::array();
  clock_steps_ = Json::array();
  clock_remarks_.clear();
  error_ = nullptr;
  asked_q_rad_.reset();
  answer_.reset();
  run_ = std::move(run);
  run_->collector = std::make_unique<acquisition::Collector>(
      run_->rig, run_->plan, *run_->robot, *run_->dials, clock_,
      acquisition::Collector::Callbacks{
          .store = [this, r = run_.get()](const auto& sample) { on_sample(*r, sample); },
          .progress = [this](const auto& progress) { on_progress(progress); },
          .done =
              [r = run_.get()](const session::PlanPoint& point) {
                return r->done.contains({point.set, point.point, point.repeat});
              },
          .wanted =
              [r = run_.get()](const session::PlanPoint& point) {
                return point.set != "G1" || !r->stop_below_mm ||
                       !r->estimate->below(*r->stop_below_mm);
              }},
      run_->settings);
  thread_ = std::jthread(
      [this, r = run_.get()](const std::stop_token& stop) { this->run(*r, stop); });
  return status_locked();
}

void Collection::run(Run& run, const std::stop_token& stop) {
  {
    const std::lock_guard lock(mutex_);
    if (state_ == CollectState::kStarting) state_ = CollectState::kRunning;
  }
  publish("started");
  run.live = std::jthread([this, &run](const std::stop_token& end) { publish_live(end, run); });
  CollectState state = CollectState::kFailed;
  Json error;
  std::string why;
  try {
    run.estimate.emplace(run.rig, run.plan.points);
    bool told = false;
    for (const session::Sample& sample : store_.load_session(run.id).samples) {
      told = take_in(run, sample) || told;
    }
    if (told) show_estimate(run);
    const acquisition::CollectorResult result = run.collector->run(stop);
    state = result.complete ? CollectState::kDone : CollectState::kStopped;
    why = why_ended(run, state, result);
  } catch (...) {
    error = to_error_object(std::current_exception());
    why = error["message"].get<std::string>();
    spdlog::error("collection of {}: {}", session_, why);
  }
  run.live = {};
  try {
    store_.record_action(to_operator(run.caller), "collect.end", run.id, why);
  } catch (const std::exception& trouble) {
    spdlog::error("the end of a collection is not in the store: {}", trouble.what());
  }
  finish(state, std::move(error), std::move(why));
}

std::string Collection::why_ended(
    const Run& run, CollectState state, const acquisition::CollectorResult& result) const {
  if (state == CollectState::kStopped) return "stopped by a command";
  if (result.left_out == 0) return "every point of the plan was had";
  return fmt::format(
      "the position uncertainty over the workspace is {:.4f} mm at worst, below the {} mm "
      "asked "
      "for, after {} samples of G1; {} points of the plan were left out",
      run.estimate->uncertainty().max_mm, *run.stop_below_mm, run.estimate->filter().samples(),
      result.left_out);
}

bool Collection::take_in(Run& run, const session::Sample& sample) {
  const bool told = run.estimate->add(sample);
  const db::PointKey key{sample.set, sample.point, sample.repeat};
  const std::lock_guard lock(mutex_);
  unusual_.erase(key);
  if (told && run.estimate->last_unusual()) unusual_[key] = *run.estimate->last_times_usual();
  return told;
}

std::string Collection::unusual(const std::string& session, const db::PointKey& point) const {
  const std::lock_guard lock(mutex_);
  const auto found = unusual_.find(point);
  if (session != session_ || found == unusual_.end()) return "";
  return fmt::format("{:.0f} times the usual residual", found->second);
}

void Collection::samples_changed(const std::string& session) {
  {
    const std::lock_guard lock(mutex_);
    if (session != session_ || is_active(state_) || !run_) return;
    unusual_.clear();
    estimate_.reset();
  }
  run_->estimate.emplace(run_->rig, run_->plan.points);
  bool told = false;
  for (const session::Sample& sample : store_.load_session(run_->id).samples) {
    told = take_in(*run_, sample) || told;
  }
  if (told) show_estimate(*run_);
  publish("estimate");
}

void Collection::show_estimate(const Run& run) {
  studies::EstimateSummary estimate = run.estimate->summary();
  const std::lock_guard lock(mutex_);
  estimate_ = std::move(estimate);
}

void Collection::finish(CollectState state, Json error, std::string why) {
  // Ports are let go before the end is told: who waits for it may start the next at once. The
  // collector goes first, under the lock, so that no command reaches it any more.
  std::unique_ptr<acquisition::Collector> collector;
  {
    const std::lock_guard lock(mutex_);
    collector = std::move(run_->collector);
    asked_q_rad_.reset();
  }
  collector.reset();
  run_->dials.reset();
  run_->robot.reset();
  {
    const std::lock_guard lock(mutex_);
    state_ = state;
    error_ = std::move(error);
    ended_because_ = std::move(why);
  }
  ended_.notify_all();
  publish(to_string(state));
}

void Collection::publish(std::string_view type, Json more) {
  Json data = status();
  // Long, and new only then.
  if (type != "estimate" && active()) data.erase("estimate");
  data["type"] = type;
  data.update(more);
  events_.publish("collect", std::move(data));
  changed_();
}

void Collection::on_progress(const acquisition::CollectorProgress& progress) {
  bool tell = false;
  {
    const std::lock_guard lock(mutex_);
    tell = progress.stage != progress_.stage || progress.plan_index != progress_.plan_index ||
           progress.message != progress_.message;
    progress_ = progress;
    if (state_ == CollectState::kRunning && progress.stage == CollectorStage::kPaused) {
      state_ = CollectState::kPaused;
    } else if (state_ == CollectState::kPaused && progress.stage != CollectorStage::kPaused) {
      state_ = CollectState::kRunning;
    }
    if (progress.stage == CollectorStage::kSkipped) ++skipped_;
    if (progress.stage == CollectorStage::kFailed) ++failed_;
    left_out_ = progress.left_out;
    const bool lost =
        progress.stage == CollectorStage::kSkipped || progress.stage == CollectorStage::kFailed;
    if (lost && progress.plan_index && troubles_.size() < kMostTroubles) {
      const session::PlanPoint& point = run_->plan.points.at(*progress.plan_index);
      troubles_.push_back(
          {{"set", point.set},
           {"point", point.point},
           {"repeat", point.repeat},
           {"why", progress.message}});
    }
  }
  // The end is told by finish(), when nothing runs any more.
  if (progress.stage == CollectorStage::kFinished ||
      progress.stage == CollectorStage::kStopped) {
    return;
  }
  if (tell) publish(acquisition::to_string(progress.stage));
}

void Collection::store_sample(Run& run, const session::Sample& sample, bool& retaken) {
  try {
    store_.append_sample(run.id, sample);
  } catch (const db::StoreError& error) {
    if (error.trouble != db::StoreTrouble::kAlreadyThere) throw;
    store_.retake_sample(run.id, sample);
    retaken = true;
  }
}

void Collection::on_sample(Run& run, const acquisition::CollectedSample& collected) {
  watch_clock(run);
  bool retaken = false;
  try {
    store_sample(run, collected.sample, retaken);
  } catch (const db::StoreError& error) {
    if (error.trouble != db::StoreTrouble::kDiskFull) throw;
    spdlog::warn("{}", error.what());
    throw acquisition::StoreLater(fmt::format(
        "{}; nothing is lost: make room and resume, and this sample is stored", error.what()));
  }
  const bool told = take_in(run, collected.sample);
  std::size_t number = 0;
  std::vector<std::string> remarks = collected.remarks;
  {
    const std::lock_guard lock(mutex_);
    number = ++stored_;
    remarks.insert(remarks.end(), clock_remarks_.begin(), clock_remarks_.end());
    clock_remarks_.clear();
  }
  Json data = sample_json(run.rig, collected.sample);
  data["type"] = "stored";
  data["session"] = session_;
  data["stored_in_this_run"] = number;
  data["plan_index"] = collected.plan_index;
  data["retaken"] = retaken;
  data["remarks"] = std::move(remarks);
  data["doubt"] = doubt_of(run.rig, collected.sample);
  if (const std::string odd = unusual(
          session_, {collected.sample.set, collected.sample.point, collected.sample.repeat});
      data["doubt"] == "" && !odd.empty()) {
    data["doubt"] = odd;
  }
  events_.publish("sample", std::move(data));
  if (!told) return;
  show_estimate(run);
  publish("estimate");
}

// Stored times stay what the clock said; that it was changed is stored beside them.
void Collection::watch_clock(Run& run) {
  const auto step = run.clock_watch.look();
  if (!step) return;
  std::string told;
  {
    const std::lock_guard lock(mutex_);
    told = fmt::format(
        "{} after {} samples of this run: times before and after do not compare",
        acquisition::describe(*step), stored_);
    clock_remarks_.push_back(acquisition::describe(*step));
    if (clock_steps_.size() < kMostClockSteps) {
      clock_steps_.push_back(
          {{"by_s", std::chrono::duration<double>(step->by).count()},
           {"time_utc", session::to_iso8601(step->now)},
           {"after_samples", stored_}});
    }
  }
  spdlog::warn("{}", told);
  try {
    store_.record_action(to_operator(run.caller), kClockStep, run.id, told);
  } catch (const std::exception& trouble) {
    spdlog::error("a step of the clock is not in the store: {}", trouble.what());
  }
  publish("clock_step", {{"message", told}});
}

void Collection::publish_live(const std::stop_token& stop, Run& run) {
  std::mutex mutex;
  std::condition_variable_any over;
  std::unique_lock lock(mutex);
  const LiveDials shown(run.rig);
  while (!over.wait_for(lock, stop, kLiveEvery, [&] { return stop.stop_requested(); })) {
    acquisition::CollectorProgress now;
    {
      const std::lock_guard state_lock(mutex_);
      now = progress_;
    }
    Json data = shown.show(
        run.dials->latest(), now.plan_index ? &run.plan.points.at(*now.plan_index) : nullptr,
        now);
    data["type"] = "dials";
    data["session"] = session_;
    events_.publish(kLiveTopic, std::move(data));
    watch_clock(run);
  }
}

std::optional<acquisition::ManualAnswer> Collection::ask_person(
    const Eigen::Vector2d& q_rad, const std::stop_token& stop) {
  {
    const std::lock_guard lock(mutex_);
    asked_q_rad_ = q_rad;
    answer_.reset();
  }
  publish("move");
  std::unique_lock lock(mutex_);
  answered_.wait(lock, stop, [&] { return answer_.has_value(); });
  asked_q_rad_.reset();
  return std::exchange(answer_, std::nullopt);
}

Json Collection::status() const {
  const std::lock_guard lock(mutex_);
  return status_locked();
}

Json Collection::status_locked() const {
  Json status{
      {"state", to_string(state_)},
      {"session", session_},
      {"operator", operator_name_},
      {"done", progress_.done},
      {"total", progress_.total},
      {"stage", acquisition::to_string(progress_.stage)},
      {"message", progress_.message},
      {"eta_s", or_null(progress_.eta_s)},
      {"stored_in_this_run", stored_},
      {"skipped", skipped_},
      {"failed", failed_},
      {"left_out", left_out_},
      {"estimate", estimate_ ? report::to_json(*estimate_) : Json(nullptr)},
      {"ended_because", ended_because_.empty() ? Json(nullptr) : Json(ended_because_)},
      {"troubles", troubles_},
      {"clock_steps", clock_steps_},
      {"point", nullptr},
      {"move_to_rad", nullptr},
      {"error", error_}};
  if (progress_.plan_index && run_) {
    const session::PlanPoint& point = run_->plan.points.at(*progress_.plan_index);
    status["point"] = {
        {"set", point.set},
        {"point", point.point},
        {"repeat", point.repeat},
        {"target_mm", {point.target_mm.x(), point.target_mm.y()}}};
  }
  if (asked_q_rad_) status["move_to_rad"] = {asked_q_rad_->x(), asked_q_rad_->y()};
  return status;
}

bool Collection::active() const {
  const std::lock_guard lock(mutex_);
  return is_active(state_);
}

bool Collection::wait_for_end(
    const std::stop_token& stop, std::chrono::milliseconds longest) const {
  std::unique_lock lock(mutex_);
  return ended_.wait_for(lock, stop, longest, [this] { return !is_active(state_); });
}

template <typename Command>
void Collection::command(std::string_view name, Command command) {
  const std::lock_guard lock(mutex_);
  if (!is_active(state_) || !run_ || !run_->collector) {
    throw Error(
        ErrorCode::kWrongState, fmt::format("nothing is being collected, so no {}", name), {},
        "collect.start begins, and goes on where an earlier run ended.");
  }
  command(*run_->collector);
}

void Collection::pause() {
  command("pause", [](acquisition::Collector& collector) { collector.pause(); });
}
void Collection::resume() {
  command("resume", [](acquisition::Collector& collector) { collector.resume(); });
}
void Collection::skip() {
  command("skip", [](acquisition::Collector& collector) { collector.skip(); });
}
void Collection::retake() {
  command("retake", [](acquisition::Collector& collector) { collector.retake(); });
}
void Collection::accept() {
  command("accept", [](acquisition::Collector& collector) { collector.accept(); });
}

void Collection::moved(acquisition::ManualAnswer answer) {
  command("moved", [&](acquisition::Collector&) {
    if (!asked_q_rad_) {
      throw Error(ErrorCode::kWrongState, "nobody was asked to move the robot");
    }
    answer_ = std::move(answer);
  });
  answered_.notify_all();
}

void Collection::stop() {
  command("stop", [this](acquisition::Collector&) {
    state_ = CollectState::kStopping;
    thread_.request_stop();
  });
}

void Collection::stop_and_wait() {
  {
    const std::lock_guard lock(mutex_);
    if (is_active(state_)) state_ = CollectState::kStopping;
    thread_.request_stop();
  }
  if (thread_.joinable()) thread_.join();
}

}  // namespace sixdial::service
