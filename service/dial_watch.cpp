#include "service/dial_watch.h"

#include <utility>

namespace sixdial::service {
namespace {

constexpr auto kEvery = std::chrono::milliseconds(200);  // on the wall

}  // namespace

Json check_json(const acquisition::PushCheck& check, const geometry::Rig& rig) {
  Json dials = Json::array();
  for (std::size_t i = 0; i < check.dials().size(); ++i) {
    const acquisition::PushedDial& dial = check.dials()[i];
    dials.push_back(
        {{"dial", dial.id},
         {"verdict", acquisition::to_string(dial.verdict)},
         {"words", acquisition::describe(dial, rig.dials[i].geometry.travel_mm)}});
  }
  return {
      {"asked", check.done() ? Json(nullptr) : Json(rig.dials[check.asked()].id)},
      {"instruction", check.instruction()},
      {"done", check.done()},
      {"good", check.good()},
      {"dials", std::move(dials)}};
}

DialWatch::DialWatch(EventHub& events, db::Store& reader, acquisition::Clock& clock)
    : events_(events), reader_(reader), clock_(clock) {}

DialWatch::~DialWatch() { stop(); }

Json DialWatch::watch(const std::string& session, std::chrono::milliseconds longest) {
  const std::lock_guard only_one(thread_mutex_);
  {
    const std::lock_guard lock(mutex_);
    if (watching_ && session_ == session) {
      until_ = std::chrono::steady_clock::now() + longest;
      return status_locked();
    }
  }
  if (thread_.joinable()) {
    thread_.request_stop();
    thread_.join();
  }
  const std::lock_guard lock(mutex_);
  rig_ = reader_.load_rig(reader_.find_session(session));
  if (rig_.dials.empty()) {
    throw Error(
        ErrorCode::kBadData, "the rig of session " + session + " has no dials",
        {{"session", session}}, "Only dials are shown live.");
  }
  auto opened = acquisition::DialBank::open(rig_, clock_);
  if (!opened) {
    throw Error(
        ErrorCode::kBadData, opened.error(), {{"session", session}},
        "Each [[dial]] in rig.toml needs a connection.");
  }
  dials_ = *std::move(opened);
  check_.reset();
  session_ = session;
  until_ = std::chrono::steady_clock::now() + longest;
  watching_ = true;
  thread_ = std::jthread([this](const std::stop_token& stop) { run(stop); });
  return status_locked();
}

Json DialWatch::check(CheckStep step) {
  const std::lock_guard lock(mutex_);
  if (!watching_ || (!check_ && step != CheckStep::kStart)) {
    throw Error(
        ErrorCode::kWrongState,
        watching_ ? "no check of the dials was begun" : "the dials are not watched", {},
        "dials.watch begins, then dials.check with do: start.");
  }
  switch (step) {
    case CheckStep::kStart:
      check_ = std::make_unique<acquisition::PushCheck>(rig_);
      break;
    case CheckStep::kAgain:
      check_->again();
      break;
    case CheckStep::kSkip:
      check_->skip();
      break;
    case CheckStep::kEnd:
      check_.reset();
      break;
  }
  return status_locked();
}

void DialWatch::stop() {
  const std::lock_guard only_one(thread_mutex_);
  if (!thread_.joinable()) return;
  thread_.request_stop();
  thread_.join();
}

Json DialWatch::status() const {
  const std::lock_guard lock(mutex_);
  return status_locked();
}

Json DialWatch::status_locked() const {
  return {
      {"watching", watching_},
      {"session", session_},
      {"check", watching_ && check_ ? check_json(*check_, rig_) : Json(nullptr)}};
}

void DialWatch::run(const std::stop_token& stop) {
  const LiveDials shown(rig_);
  std::unique_lock lock(mutex_);
  while (!over_.wait_for(lock, stop, kEvery, [&] { return stop.stop_requested(); })) {
    if (std::chrono::steady_clock::now() >= until_) break;
    const std::vector<acquisition::Reading> readings = dials_->latest();
    if (check_) check_->take(readings);
    Json data = shown.watched(readings);
    data["type"] = "dials";
    data["session"] = session_;
    data["check"] = check_ ? check_json(*check_, rig_) : Json(nullptr);
    events_.publish(kLiveTopic, std::move(data));
  }
  watching_ = false;
  const std::unique_ptr<acquisition::DialBank> let_go = std::move(dials_);
  lock.unlock();  // its threads end within their deadlines
}

}  // namespace sixdial::service
