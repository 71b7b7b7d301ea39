// The computer's clock is set while a session is collected. Expected: order by row, ages and
// deadlines unharmed, the stored times what the clock said, and everybody told by how much.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "session/reason.h"
#include "session/trials.h"
#include "tests/support/live_rig.h"

namespace sixdial::service {
namespace {

using namespace std::chrono_literals;

using testing::create;
using testing::error_code_of;
using ::testing::HasSubstr;
using testing::Key;
using testing::key_of;
using testing::LineClient;
using testing::Rig;
using testing::RunningService;
using testing::start;
using testing::wait_for_end;

constexpr std::chrono::hours kStep{1};
// Slow: a value is stale after three seconds of the rig, 0.6 s on the wall, which even a
// machine busy with other things keeps.
constexpr double kSlowSpeed = 5.0;   // rig seconds a wall second
constexpr double kWithin_s = 150.0;  // from one sample to the next; half a minute on the wall
constexpr double kRead_s = 10.0;     // between reading the two clocks; two seconds on the wall

/// A rig's clock whose time of day can be set; its monotonic time does not mind.
class SettableClock final : public acquisition::Clock {
 public:
  explicit SettableClock(const std::string& start)
      : clock_(kSlowSpeed, session::from_iso8601(start).value()) {}
  void set_by(std::chrono::milliseconds step) { offset_ms_ += step.count(); }

  [[nodiscard]] acquisition::DeviceTime monotonic() const override {
    return clock_.monotonic();
  }
  [[nodiscard]] session::TimePoint now_utc() const override {
    return clock_.now_utc() + std::chrono::milliseconds(offset_ms_.load());
  }
  bool sleep_until(acquisition::DeviceTime deadline, const std::stop_token& stop) override {
    return clock_.sleep_until(deadline, stop);
  }
  [[nodiscard]] std::chrono::nanoseconds wall(acquisition::DeviceTime span) const override {
    return clock_.wall(span);
  }

 private:
  acquisition::AcceleratedClock clock_;
  std::atomic<std::int64_t> offset_ms_{0};
};

/// Sets the clock in the middle of a collection and checks what is told and stored; how many
/// values were late.
int collect_with_step(const std::chrono::milliseconds step) {
  constexpr int kPoints = 9;
  constexpr int kBefore = 4;
  Rig rig(kSlowSpeed);
  const auto clock = std::make_shared<SettableClock>(rig.now());
  ServiceOptions options;
  options.clock = clock;
  RunningService running({}, options);
  LineClient client = running.client();
  create(client, rig);
  LineClient watcher = running.client();
  watcher.call("events.subscribe", {{"topics", {"sample", "collect"}}});
  EXPECT_EQ(error_code_of(start(client, Rig::plan(kPoints))), "");

  std::vector<Key> told;
  std::vector<Json> steps;
  int remarked = 0;
  for (std::string type; type != "done" && type != "failed";) {
    const Json params = watcher.read()["params"];
    const Json& data = params["data"];
    type = data["type"];
    if (type == "clock_step") steps.push_back(data);
    if (params["topic"] != "sample") continue;
    told.push_back(key_of(data));
    if (data["remarks"].dump().find("computer's clock") != std::string::npos) ++remarked;
    if (told.size() == kBefore) clock->set_by(step);
  }
  const Json status = wait_for_end(client);
  EXPECT_EQ(status["state"], "done");
  EXPECT_EQ(status["failed"], 0);
  EXPECT_EQ(told.size(), static_cast<std::size_t>(kPoints));

  // Told once, with its size, on the event, in the status and with the next sample.
  EXPECT_EQ(steps.size(), 1U);
  EXPECT_EQ(status["clock_steps"].size(), 1U);
  if (steps.empty() || status["clock_steps"].empty()) return 0;
  const double step_s = std::chrono::duration<double>(step).count();
  EXPECT_NEAR(status["clock_steps"][0]["by_s"].get<double>(), step_s, kRead_s);
  const std::string words = step < 0ms ? "was set back by 3" : "went forward by 3";
  EXPECT_THAT(steps[0]["message"].get<std::string>(), HasSubstr(words));
  EXPECT_EQ(remarked, 1);
  // And stored: it is there for who looks at the session next year.
  const Json shown = client.call("session.show", {{"session", "live"}})["result"];
  EXPECT_EQ(shown["clock_steps"].size(), 1U);
  EXPECT_THAT(shown["clock_steps"].dump(), HasSubstr(words));

  // The rows are in the order of measuring; each time is what the clock said.
  db::Store& reader = running.service().reader();
  const session::Session session = reader.load_session(reader.find_session("live"));
  EXPECT_EQ(session.samples.size(), told.size());
  if (session.samples.size() != told.size()) return 0;
  int jumps = 0, late = 0;
  for (std::size_t i = 0; i < told.size(); ++i) {
    const session::Sample& sample = session.samples[i];
    EXPECT_EQ((Key{sample.set, sample.point, sample.repeat}), told[i]);
    for (const session::ChannelValue& value : sample.channels) {
      late +=
          value.reason == session::reason::kStale || value.reason == session::reason::kTimeout
              ? 1
              : 0;
    }
    if (i == 0) continue;
    const double since_s =
        std::chrono::duration<double>(*sample.time_utc - *session.samples[i - 1].time_utc)
            .count();
    if (std::abs(since_s - step_s) < kWithin_s) {
      ++jumps;
    } else {
      EXPECT_GT(since_s, 0.0);
      EXPECT_LT(since_s, kWithin_s);
    }
  }
  EXPECT_EQ(jumps, 1) << "the stored times are the clock's, nothing was smoothed";
  return late;
}

class SteppingClock : public ::testing::TestWithParam<int> {};

TEST_P(SteppingClock, IsToldAndStoredAndHarmsNoSample) {
  EXPECT_EQ(collect_with_step(GetParam() * kStep), 0);
}

INSTANTIATE_TEST_SUITE_P(, SteppingClock, ::testing::Values(-1, 1), [](const auto& each) {
  return each.param < 0 ? "BackAnHour" : "ForwardAnHour";
});

TEST(Clock, ThatIsNotSetIsNotReported) {
  Rig rig;
  RunningService running({}, rig.service_options());
  LineClient client = running.client();
  create(client, rig);
  start(client, Rig::plan(5));
  const Json status = wait_for_end(client);
  EXPECT_EQ(status["state"], "done");
  EXPECT_TRUE(status["clock_steps"].empty()) << status["clock_steps"];
  const Json shown = client.call("session.show", {{"session", "live"}, {"limit", 5}})["result"];
  // One Modbus request reads all six.
  EXPECT_EQ(shown["readings_within_ms"]["median"], 0.0);
  EXPECT_EQ(shown["page"][0]["readings_within_ms"], 0.0);
}

}  // namespace
}  // namespace sixdial::service
