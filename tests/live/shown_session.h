// A service with a session of which 20 of 32 points are measured, its live page in Chromium,
// and a rig that is played: what it tells comes from the test.
#pragma once

#include <fstream>
#include <memory>
#include <sstream>
#include <string>
#include <vector>

#include "service/live/live_page.h"
#include "session/rig_file.h"
#include "tests/live/browser_page.h"
#include "tests/support/paths.h"
#include "tests/support/rig_for_tests.h"
#include "tests/support/simulated.h"

namespace sixdial::testing {

class ShownSession {
 public:
  static constexpr int kPoints = 32, kMeasured = 20;

  ShownSession() : world_(simple_world(7)) {
    session::PlanOptions options;
    options.seed = 3;
    plan_ = session::plan_random(world_.rig, kPoints, options).value();
    session::Plan begun = plan_;
    begun.points.resize(kMeasured);
    session::Session session = measured(world_, begun);
    session.name = "monday";
    db::Store& store = running_.service().store();
    store.save_plan(store.import_session(session), plan_);
    page_ = std::make_unique<service::LivePage>(service::LivePageOptions{
        .socket_path = running_.socket_path(), .port = 0, .token = std::string(32, 'a')});
  }

  void open() {
    browser_.open(page_->url());
    browser_.until("document.getElementById('session').value === 'monday'");
    browser_.until(
        "document.querySelectorAll('#map [data-mark=done]').length === " +
        std::to_string(kMeasured));
    std::ifstream file(test_paths::source_dir() + "/tests/live/look.js");
    std::stringstream text;
    text << file.rdbuf();
    browser_.run(text.str());
  }

  /// The collection as it stands in the middle of the session: paused, as dial C is lost; dial
  /// E is stale, B settles, F touches nothing.
  void play_middle() {
    const session::PlanPoint& point = plan_.points[kMeasured];
    running_.service().events().publish(
        "collect", {{"type", "paused"},
                    {"state", "paused"},
                    {"session", "monday"},
                    {"done", kMeasured},
                    {"total", kPoints},
                    {"stage", "paused"},
                    {"message",
                     "dial C: timeout, no answer; resume measures again, accept stores the "
                     "point as it is, skip leaves it out"},
                    {"pause_reason", "dial_fault"},
                    {"trouble", "dial C: timeout, no answer"},
                    {"eta_s", 65.0},
                    {"point",
                     {{"set", point.set},
                      {"point", point.point},
                      {"repeat", point.repeat},
                      {"target_mm", {point.target_mm.x(), point.target_mm.y()}}}},
                    {"move_to", nullptr},
                    {"error", nullptr},
                    {"ended_because", nullptr}});
    play_dials();
  }
  /// Shown for 5 s only, as a real one.
  void play_dials() {
    const auto dial = [](const Json& value_mm, const char* state, const char* reason) {
      return Json{
          {"value_mm", value_mm}, {"quality", "good"}, {"reason", reason}, {"state", state}};
    };
    running_.service().events().publish(
        service::kLiveTopic,
        {{"type", "dials"},
         {"session", "monday"},
         {"stage", "paused"},
         {"dials",
          {{"A", dial(10.490, "ok", "")},
           {"B", dial(-12.345, "settling", "")},
           {"C", dial(nullptr, "lost", "timeout")},
           {"D", dial(7.125, "ok", "")},
           {"E", dial(nullptr, "stale", "stale")},
           {"F", dial(nullptr, "free", "no contact")}}},
         {"settle",
          {{"spread_mm", 0.009}, {"limit_mm", 0.012}, {"settled", true}, {"dial", "B"}}},
         {"pose",
          {{"x_mm", 28.125}, {"y_mm", 48.5}, {"gamma_rad", 0.1}, {"dials", {"A", "B", "D"}}}}});
  }

  [[nodiscard]] BrowserPage& browser() { return browser_; }
  [[nodiscard]] RunningService& running() { return running_; }
  [[nodiscard]] const service::LivePage& page() const { return *page_; }
  void close_page() { page_.reset(); }

 private:
  mock_devices::World world_;
  session::Plan plan_;
  RunningService running_;
  std::unique_ptr<service::LivePage> page_;
  BrowserPage browser_;
};

}  // namespace sixdial::testing
