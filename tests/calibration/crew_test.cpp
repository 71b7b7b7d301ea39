#include "calibration/crew.h"

#include <gtest/gtest.h>

#include <atomic>
#include <latch>
#include <stdexcept>
#include <string>
#include <thread>
#include <vector>

#include "geometry/long_work.h"

namespace sixdial::calibration {
namespace {

TEST(Crew, DoesEachPartOnceWithAnyNumberOfThreads) {
  for (const int threads : {0, 1, 2, 5}) {
    const Crew crew(threads);
    EXPECT_EQ(crew_size(), std::max(threads, 1));
    std::vector<std::atomic<int>> done(100);
    in_parallel(100, [&](int i) { ++done[static_cast<std::size_t>(i)]; });
    for (const auto& each : done) EXPECT_EQ(each.load(), 1);
  }
}

TEST(Crew, WithoutOneTheCallerDoesAll) {
  EXPECT_EQ(crew_size(), 1);
  std::vector<int> order;
  in_parallel(3, [&](int i) { order.push_back(i); });
  EXPECT_EQ(order, (std::vector<int>{0, 1, 2}));
}

TEST(Crew, PartsOfAPartAreDoneWhereItIsDone) {
  const Crew crew(3);
  std::atomic<int> elsewhere = 0;
  std::atomic<int> done = 0;
  in_parallel(20, [&](int) {
    const auto here = std::this_thread::get_id();
    if (crew_size() != 1) ++elsewhere;
    in_parallel(10, [&](int) {
      if (std::this_thread::get_id() != here) ++elsewhere;
      ++done;
    });
  });
  EXPECT_EQ(elsewhere.load(), 0);
  EXPECT_EQ(done.load(), 200);
  EXPECT_EQ(crew_size(), 3);
}

TEST(Crew, TheOneBeforeCountsAgainAtTheEndOfTheScope) {
  const Crew outer(2);
  {
    const Crew inner(3);
    EXPECT_EQ(crew_size(), 3);
  }
  EXPECT_EQ(crew_size(), 2);
}

TEST(Crew, ThrowsWhatTheLowestPartThrewAndGoesOn) {
  const Crew crew(2);
  for (int round = 0; round < 50; ++round) {
    try {
      in_parallel(8, [&](int i) {
        if (i == 3 || i == 6) throw std::runtime_error(std::to_string(i));
      });
      FAIL() << "nothing was thrown";
    } catch (const std::runtime_error& error) {
      EXPECT_STREQ(error.what(), "3");
    }
    EXPECT_EQ(crew_size(), 2);
  }
}

TEST(Crew, AStopOfTheWorkReachesThePartsOnEveryThread) {
  const Crew crew(3);
  std::stop_source stop;
  const geometry::LongWork work(stop.get_token());
  stop.request_stop();
  std::latch all(3);  // so that each thread has one
  std::atomic<int> after_stop = 0;
  EXPECT_THROW(
      in_parallel(
          3,
          [&](int) {
            all.arrive_and_wait();
            geometry::check_end();
            ++after_stop;
          }),
      geometry::WorkEnded);
  EXPECT_EQ(after_stop.load(), 0);
}

TEST(Crew, OnlyTheCallerTellsHowFarItIs) {
  const Crew crew(3);
  const auto caller = std::this_thread::get_id();
  std::atomic<int> by_caller = 0;
  std::atomic<int> by_others = 0;
  const geometry::LongWork work({}, [&](std::string_view, std::int64_t, std::int64_t) {
    ++(std::this_thread::get_id() == caller ? by_caller : by_others);
  });
  std::latch all(3);
  in_parallel(3, [&](int i) {
    all.arrive_and_wait();
    geometry::tell_step("parts", i, 3);
  });
  EXPECT_EQ(by_caller.load(), 1);
  EXPECT_EQ(by_others.load(), 0);
}

}  // namespace
}  // namespace sixdial::calibration
