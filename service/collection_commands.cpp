// The state of a collection as JSON, and its commands: from any thread, while it runs.
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <stdexcept>
#include <utility>

#include "geometry/units.h"
#include "report/documents/estimate_json.h"
#include "report/words/move_words.h"
#include "service/collection_run.h"
#include "service/or_null.h"
#include "session/sample_layout.h"

namespace sixdial::service {
namespace {

constexpr std::array kStates{
    std::pair{CollectState::kIdle, std::string_view("idle")},
    std::pair{CollectState::kStarting, std::string_view("starting")},
    std::pair{CollectState::kRunning, std::string_view("running")},
    std::pair{CollectState::kPaused, std::string_view("paused")},
    std::pair{CollectState::kStopping, std::string_view("stopping")},
    std::pair{CollectState::kDone, std::string_view("done")},
    std::pair{CollectState::kStopped, std::string_view("stopped")},
    std::pair{CollectState::kFailed, std::string_view("failed")}};

}  // namespace

std::string_view to_string(CollectState state) {
  return std::ranges::find(kStates, state, &std::pair<CollectState, std::string_view>::first)
      ->second;
}

CollectState collect_state_of(const Json& status) {
  const auto& name = status.at("state").get_ref<const std::string&>();
  const auto* found =
      std::ranges::find(kStates, name, &std::pair<CollectState, std::string_view>::second);
  if (found == kStates.end()) throw std::invalid_argument("no such collection state: " + name);
  return found->first;
}

bool is_active(CollectState state) {
  return state == CollectState::kStarting || state == CollectState::kRunning ||
         state == CollectState::kPaused || state == CollectState::kStopping;
}

std::optional<acquisition::ManualAnswer> Collection::ask_person(
    const Eigen::VectorXd& q, const std::stop_token& stop) {
  {
    const std::lock_guard lock(mutex_);
    asked_q_ = q;
    asked_via_.reset();
    asked_from_.reset();
    if (const auto* by_hand =
            dynamic_cast<acquisition::ManualRobot*>(run_ ? run_->robot.get() : nullptr)) {
      asked_via_ = by_hand->approach_from();
      asked_from_ = by_hand->stands_at();
    }
    answer_.reset();
  }
  publish("move");
  std::unique_lock lock(mutex_);
  answered_.wait(lock, stop, [&] { return answer_.has_value(); });
  asked_q_.reset();
  return std::exchange(answer_, std::nullopt);
}

/// What a person is to do, in the units that people read.
Json Collection::move_json() const {
  const session::SampleLayout layout = session::layout_of(run_->rig);
  report::MoveByHand move;
  if (progress_.plan_index)
    move.target_mm = run_->plan.points.at(*progress_.plan_index).target_mm;
  Json joints = Json::array();
  for (std::size_t i = 0; i < layout.joints.size(); ++i) {
    const auto k = static_cast<Eigen::Index>(i);
    const geometry::ShownUnit shown = geometry::shown_unit(layout.joints[i].unit);
    const auto figure = [&](const std::optional<Eigen::VectorXd>& q) {
      return q && k < q->size() ? std::optional((*q)[k] * shown.per_unit) : std::nullopt;
    };
    const report::JointByHand joint{
        .joint = layout.joints[i].name,
        .unit = std::string(shown.name),
        .to = *figure(asked_q_),
        .from = figure(asked_from_),
        .first = figure(asked_via_)};
    joints.push_back(
        {{"joint", joint.joint},
         {"unit", joint.unit},
         {"to", joint.to},
         {"from", or_null(joint.from)},
         {"first", or_null(joint.first)}});
    move.joints.push_back(joint);
  }
  return {
      {"target_mm", move.target_mm
                        ? Json(std::vector(move.target_mm->begin(), move.target_mm->end()))
                        : Json(nullptr)},
      {"joints", std::move(joints)},
      {"words", report::move_words(move)}};
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
      {"pause_reason",
       progress_.pause ? Json(acquisition::to_string(*progress_.pause)) : Json(nullptr)},
      {"trouble", progress_.trouble},
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
      {"move_to", nullptr},
      {"move", nullptr},
      {"error", error_}};
  if (progress_.plan_index && run_) {
    const session::PlanPoint& point = run_->plan.points.at(*progress_.plan_index);
    status["point"] = {
        {"set", point.set},
        {"point", point.point},
        {"repeat", point.repeat},
        {"target_mm", std::vector(point.target_mm.begin(), point.target_mm.end())}};
  }
  if (asked_q_ && run_) {
    status["move_to_rad"] = std::vector(asked_q_->begin(), asked_q_->end());
    const session::SampleLayout layout = session::layout_of(run_->rig);
    Json joints = Json::array();
    for (std::size_t i = 0; i < layout.joints.size(); ++i) {
      joints.push_back(
          {{"joint", layout.joints[i].name},
           {"unit", layout.joints[i].unit},
           {"value", (*asked_q_)[static_cast<Eigen::Index>(i)]}});
    }
    status["move_to"] = std::move(joints);
    status["move"] = move_json();
  }
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
    if (!asked_q_) {
      throw Error(ErrorCode::kWrongState, "nobody was asked to move the robot");
    }
    answer_ = std::move(answer);
  });
  answered_.notify_all();
}

void Collection::halt_robot() {
  std::shared_ptr<acquisition::RobotPort> robot;
  command("halt of the robot", [&](acquisition::Collector& collector) {
    robot = run_->robot;
    collector.pause();
  });
  if (!robot) return;
  const auto told = robot->halt({});
  if (told) return;
  throw Error(
      ErrorCode::kDevice,
      fmt::format("the robot could not be told to stop: {}", told.error().detail),
      {{"field", "robot"}}, "Use the emergency stop if anything is in danger.");
}

void Collection::stop() {
  command("stop", [this](acquisition::Collector&) {
    state_ = CollectState::kStopping;
    thread_.request_stop();
  });
}

void Collection::stop_and_wait() {
  const std::lock_guard no_start(thread_mutex_);
  {
    const std::lock_guard lock(mutex_);
    if (is_active(state_)) state_ = CollectState::kStopping;
    thread_.request_stop();
  }
  if (thread_.joinable()) thread_.join();
}

}  // namespace sixdial::service
