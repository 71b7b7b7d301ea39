// Device time, its three clocks, and the state of a link that is kept in it.
#include "acquisition/clock.h"

#include <gtest/gtest.h>

#include <thread>

#include "acquisition/bus.h"
#include "acquisition/link_health.h"

namespace sixdial::acquisition {
namespace {

using namespace std::chrono_literals;
using std::chrono::steady_clock;

TEST(AcceleratedClock, RunsAsManyTimesFasterAsItSays) {
  const session::TimePoint start{std::chrono::milliseconds{1'700'000'000'000}};
  AcceleratedClock clock(100.0, start);
  const auto wall_before = steady_clock::now();
  const DeviceTime before = clock.monotonic();
  EXPECT_TRUE(clock.sleep_for(3s, {}));
  const DeviceTime after = clock.monotonic();
  const auto wall = steady_clock::now() - wall_before;
  EXPECT_GE(after - before, 3s);
  EXPECT_GE(wall, 30ms);
  EXPECT_LE(after - before, 100 * wall);
  EXPECT_GE(clock.now_utc(), start + 3s);
  EXPECT_EQ(clock.wall(3s), 30ms);
}

TEST(AcceleratedClock, StillLeavesTheWallTimeThatBytesNeed) {
  const AcceleratedClock clock(1000.0, {});
  EXPECT_EQ(clock.wall_timeout(300ms), kLeastWallTimeout);
  EXPECT_EQ(clock.wall_timeout(300s), 300ms);
  EXPECT_EQ(at_least_on_wall(clock, 25ms, 4ms), 4s);
  EXPECT_EQ(at_least_on_wall(clock, 25s, 4ms), 25s);
}

TEST(AcceleratedClock, RefusesAStandstill) {
  EXPECT_THROW(AcceleratedClock(0.0, {}), std::invalid_argument);
  EXPECT_THROW(AcceleratedClock(-1.0, {}), std::invalid_argument);
}

TEST(SystemClock, EndsASleepWhenStopped) {
  SystemClock clock;
  std::stop_source stop;
  std::jthread stopper([&] {
    std::this_thread::sleep_for(20ms);
    stop.request_stop();
  });
  const auto before = steady_clock::now();
  EXPECT_FALSE(clock.sleep_for(600s, stop.get_token()));
  EXPECT_LT(steady_clock::now() - before, 60s);
}

TEST(FakeClock, MovesOnlyWhenSleptOn) {
  FakeClock clock(session::TimePoint{1s});
  EXPECT_EQ(clock.monotonic(), 0s);
  EXPECT_TRUE(clock.sleep_for(2s, {}));
  EXPECT_EQ(clock.monotonic(), 2s);
  EXPECT_EQ(clock.now_utc(), session::TimePoint{3s});
  EXPECT_TRUE(clock.sleep_until(1s, {}));
  EXPECT_EQ(clock.monotonic(), 2s);
}

TEST(LinkHealth, GoesFromOkOverSuspectToDownAndBack) {
  LinkHealth health;
  health.good();
  EXPECT_EQ(health.state(), LinkState::kOk);
  health.bad(1s);
  EXPECT_EQ(health.state(), LinkState::kSuspect);
  EXPECT_LE(health.next_try(), 1s);
  health.bad(2s);
  health.bad(3s);
  EXPECT_EQ(health.state(), LinkState::kDown);
  EXPECT_EQ(health.next_try(), 3s + kFirstBackOff);
  health.good();
  EXPECT_EQ(health.state(), LinkState::kOk);
  EXPECT_EQ(health.next_try(), 0s);
}

TEST(LinkHealth, BacksOffFromAFifthOfASecondToTen) {
  LinkHealth health;
  DeviceTime now = 0s;
  std::vector<DeviceTime> waits;
  for (int i = 0; i < 8; ++i) {
    health.lost(now);
    waits.push_back(health.next_try() - now);
    now = health.next_try();
  }
  EXPECT_EQ(waits.front(), 200ms);
  EXPECT_EQ(waits[1], 400ms);
  EXPECT_EQ(waits[5], 6400ms);
  EXPECT_EQ(waits[6], 10s);
  EXPECT_EQ(waits.back(), 10s);
}

}  // namespace
}  // namespace sixdial::acquisition
