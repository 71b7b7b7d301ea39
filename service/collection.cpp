#include <fmt/format.h>
#include <spdlog/spdlog.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "acquisition/robot_driver.h"
#include "service/collection_run.h"
#include "service/first_pass.h"
#include "service/sample_json.h"
#include "service/store_json.h"
#include "session/live_channels.h"

namespace sixdial::service {
namespace {

using acquisition::CollectorStage;

constexpr std::size_t kMostTroubles = 50;

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

/// Its instrument shows positions.
bool gives_estimate(const geometry::Rig& rig) {
  return !session::has_live_channels(rig) || session::has_live_positions(rig);
}

}  // namespace

Collection::Collection(
    EventHub& events, db::Store& store, acquisition::Clock& clock,
    std::function<void()> changed, std::function<void()> take_ports, bool allow_exec)
    : events_(events),
      store_(store),
      clock_(clock),
      changed_(std::move(changed)),
      take_ports_(std::move(take_ports)),
      allow_exec_(allow_exec) {}

Collection::~Collection() { stop_and_wait(); }

Json Collection::start(CollectRequest request) {
  const std::lock_guard only_one(thread_mutex_);
  {
    const std::lock_guard lock(mutex_);
    if (is_active(state_)) {
      throw Error(
          ErrorCode::kWrongState, fmt::format("session {} is being collected", session_),
          {{"session", session_}}, "Stop it first: collect.stop.");
    }
  }
  // The last collection has ended, but its thread may still be telling so, and needs mutex_
  // for that.
  if (thread_.joinable()) thread_.join();
  const std::lock_guard lock(mutex_);
  std::shared_ptr<Run> run = made_run(request);
  connect_devices(*run);
  store_.record_action(
      to_operator(request.caller), "collect.start", run->id,
      fmt::format("{} points", run->plan.points.size()));

  forget_last_run();
  state_ = CollectState::kStarting;
  session_ = request.session;
  operator_name_ = request.caller.operator_name;
  progress_.total = run->plan.points.size();
  run_ = std::move(run);
  make_collector(*run_);
  thread_ = std::jthread(
      [this, r = run_.get()](const std::stop_token& stop) { this->run(*r, stop); });
  return status_locked();
}

/// A run's session, rig, plan and what of it is done.
std::shared_ptr<Collection::Run> Collection::made_run(CollectRequest& request) {
  auto run = std::make_shared<Run>(clock_);
  run->id = store_.find_session(request.session);
  run->rig = store_.load_rig(run->id);
  run->seen_rig = session::as_instrument(run->rig);
  run->settings = request.settings;
  run->stop_below_mm = request.stop_below_mm;
  if (run->stop_below_mm && !gives_estimate(run->rig)) {
    throw Error(
        ErrorCode::kInvalidParams,
        "the live estimate is made from positions, and this instrument shows none",
        {{"param", "stop_below_mm"}}, "Collect the whole plan.");
  }
  run->speed_percent = request.speed_percent;
  run->first_pass = request.first_pass;
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
        {{"session", request.session}, {"missing", "plan"}},
        "Give one: plan_csv, made by plan.grid or plan.random.");
  }
  if (run->first_pass) {
    prepare_first_pass(*run);
  } else {
    for (const db::PointKey& key : store_.done_points(run->id)) run->done.insert(key);
  }
  return run;
}

void Collection::connect_devices(Run& run) {
  if (take_ports_) take_ports_();
  const auto robot = acquisition::robot_connection_of(run.rig);
  if (!robot) {
    throw Error(
        ErrorCode::kBadData, "the robot's connection: " + robot.error(), {{"field", "robot"}},
        fmt::format(
            "In rig.toml, `connection` of [robot] is one of: {}.", acquisition::robot_forms()));
  }
  if (robot->driver->runs_programs && !allow_exec_) {
    throw Error(
        ErrorCode::kWrongState,
        fmt::format(
            "the rig file moves the robot by a program of its own ({}), and this service was "
            "not told that it may run one",
            run.rig.robot.connection),
        {{"field", "robot"}},
        "Start sixdiald with --allow-exec if everyone who reaches its socket may run programs "
        "as its user.");
  }
  run.robot = robot->open(
      {.clock = clock_, .ask = [this](const Eigen::VectorXd& q, const std::stop_token& stop) {
         return ask_person(q, stop);
       }});
  if (robot->driver->by_hand) run.settings.approach_rad = kApproachByHand_rad;
  auto dials = acquisition::DialBank::open(run.rig, clock_);
  if (!dials) {
    throw Error(
        ErrorCode::kBadData, dials.error(), {{"field", "dial"}},
        "Each [[dial]] in rig.toml needs a connection.");
  }
  run.dials = *std::move(dials);
}

void Collection::make_collector(Run& run) {
  run.collector = std::make_unique<acquisition::Collector>(
      run.rig, run.plan, *run.robot, *run.dials, clock_,
      acquisition::Collector::Callbacks{
          .store =
              [this, &run](const auto& sample) {
                if (run.first_pass) return on_rehearsed(run, sample);
                on_sample(run, sample);
              },
          .progress = [this](const auto& progress) { on_progress(progress); },
          .done =
              [&run](const session::PlanPoint& point) {
                return run.done.contains({point.set, point.point, point.repeat});
              },
          .wanted =
              [&run](const session::PlanPoint& point) {
                return point.set != "G1" || !run.stop_below_mm ||
                       !run.estimate->below(*run.stop_below_mm);
              }},
      run.settings);
  run.collector->ask_before_first_move(run.before_first_move);
}

void Collection::forget_last_run() {
  progress_ = {};
  stored_ = skipped_ = failed_ = left_out_ = 0;
  estimate_.reset();
  ++estimate_turn_;
  unusual_.clear();
  ended_because_.clear();
  troubles_ = Json::array();
  clock_steps_ = Json::array();
  clock_remarks_.clear();
  error_ = nullptr;
  asked_q_.reset();
  asked_from_.reset();
  asked_via_.reset();
  answer_.reset();
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
    run.stop = stop;
    if (gives_estimate(run.rig)) run.estimate.emplace(run.seen_rig, run.plan.points);
    take_in_stored(run);
    const ReducedSpeed speed(*run.robot, run.speed_percent);
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

namespace {

std::string plan_done_words(std::size_t skipped, std::size_t failed) {
  if (skipped == 0 && failed == 0) return "every point of the plan was measured";
  std::string words = "the plan is at its end";
  if (failed > 0) words += fmt::format("; {} of its points gave no sample", failed);
  if (skipped > 0)
    words +=
        fmt::format("; {} of its points {} skipped", skipped, skipped == 1 ? "was" : "were");
  return words;
}

}  // namespace

std::string Collection::why_ended(
    const Run& run, CollectState state, const acquisition::CollectorResult& result) const {
  if (state == CollectState::kStopped) return "stopped by a command";
  if (run.first_pass) {
    return fmt::format(
        "the first pass went to the {} outermost points; nothing was stored. Collect without "
        "it "
        "to measure",
        run.plan.points.size());
  }
  if (result.left_out == 0) {
    const std::lock_guard lock(mutex_);
    return plan_done_words(skipped_, failed_);
  }
  return fmt::format(
      "the position uncertainty over the workspace is {:.4f} mm at worst, below the {} mm "
      "asked "
      "for, after {} samples of G1; {} points of the plan were left out",
      run.estimate->uncertainty().max_mm, *run.stop_below_mm, run.estimate->filter().samples(),
      result.left_out);
}

void Collection::finish(CollectState state, Json error, std::string why) {
  // Ports are let go before the end is told: who waits for it may start the next at once. The
  // collector goes first, under the lock, so that no command reaches it any more.
  std::unique_ptr<acquisition::Collector> collector;
  std::shared_ptr<acquisition::RobotPort> robot;
  {
    const std::lock_guard lock(mutex_);
    collector = std::move(run_->collector);
    robot = std::move(run_->robot);
    asked_q_.reset();
  }
  collector.reset();
  run_->dials.reset();
  robot.reset();
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
  {
    // An older state is never told after a newer one, whichever threads tell them.
    const std::lock_guard in_turn(publish_mutex_);
    Json data = status();
    // Long, and new only then.
    if (type != "estimate" && active()) data.erase("estimate");
    data["type"] = type;
    data.update(more);
    events_.publish("collect", std::move(data));
  }
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
    // Both pass once a person has seen to them; the sample waits.
    const bool full = error.trouble == db::StoreTrouble::kDiskFull;
    if (!full && error.trouble != db::StoreTrouble::kLocked) throw;
    spdlog::warn("{}", error.what());
    throw acquisition::StoreLater(fmt::format(
        "{}; nothing is lost: {} and resume, and this sample is stored", error.what(),
        full ? "make room" : "let the other program go"));
  }
  const bool told = take_in(run, session::as_instrument(run.rig, collected.sample));
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

}  // namespace sixdial::service
