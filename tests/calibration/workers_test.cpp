#include "calibration/workers.h"

#include <gtest/gtest.h>

#include <atomic>
#include <stdexcept>
#include <vector>

namespace sixdial::calibration {
namespace {

TEST(Workers, DoEachTaskOfEachJobOnce) {
  for (const int threads : {0, 1, 2, 3}) {
    Workers workers(threads);
    EXPECT_EQ(workers.count(), std::max(threads, 1));
    std::vector<std::atomic<int>> done(17);
    std::int64_t expected = 0;
    for (int job = 0; job < 2000; ++job) {
      const int tasks = job % 18;
      workers.run(tasks, [&](int task) { ++done[static_cast<std::size_t>(task)]; });
      // all are done when run returns
      std::int64_t sum = 0;
      for (const auto& each : done) sum += each.load();
      expected += tasks;
      ASSERT_EQ(sum, expected) << "job " << job;
    }
    for (std::size_t task = 1; task < done.size(); ++task) {
      EXPECT_LE(done[task].load(), done[task - 1].load());
    }
  }
}

TEST(Workers, ThrowTheExceptionOfTheLowestTaskAndGoOn) {
  for (const int threads : {1, 2}) {
    Workers workers(threads);
    for (int round = 0; round < 100; ++round) {
      try {
        workers.run(8, [&](int task) {
          if (task == 3 || task == 5) throw std::runtime_error(std::to_string(task));
        });
        FAIL() << "nothing was thrown";
      } catch (const std::runtime_error& error) {
        EXPECT_STREQ(error.what(), "3");
      }
      std::atomic<int> done{0};
      workers.run(8, [&](int) { ++done; });
      EXPECT_EQ(done.load(), 8);
    }
  }
}

TEST(Workers, LetTheOthersFinishWhileOneIsHeldUp) {
  Workers workers(2);
  std::atomic<int> done{0};
  // Whoever has task 0 waits until all others are done: nobody may be bound to a share.
  workers.run(9, [&](int task) {
    if (task == 0) {
      for (int now = done.load(); now < 8; now = done.load()) done.wait(now);
    } else {
      ++done;
      done.notify_all();
    }
  });
  EXPECT_EQ(done.load(), 8);
}

TEST(Workers, RefuseMoreTasksThanTheyCanCount) {
  Workers workers(1);
  EXPECT_THROW(workers.run(-1, [](int) {}), std::invalid_argument);
  EXPECT_THROW(workers.run(1 << 20, [](int) {}), std::invalid_argument);
}

}  // namespace
}  // namespace sixdial::calibration
