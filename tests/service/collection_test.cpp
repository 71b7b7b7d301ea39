// The collection without a socket: what its callers on several threads may do at once.
#include "service/collection.h"

#include <gtest/gtest.h>

#include <thread>

#include "studies/live_estimate.h"
#include "tests/support/live_rig.h"
#include "tests/support/simulated.h"

namespace sixdial::service {
namespace {

using testing::eventually;
using testing::kSpeed;
using testing::Rig;

/// A collection on a mock rig. Its sessions are already measured: each ends where it starts.
class CollectionThreads : public ::testing::Test {
 protected:
  void import(const std::string& name, int points, const std::string& set = "G1") {
    session::Session session =
        testing::measured(testing::simple_world(3), Rig::plan(points, set));
    session.name = name;
    session.rig_text = rig_.toml();
    session.rig = session::parse_rig(session.rig_text, "rig.toml");
    const db::SessionId id = store_.import_session(session);
    session::Plan plan;
    plan.points = studies::points_of(session);
    store_.save_plan(id, plan);
  }
  void start(const std::string& name) { collection_.start({.session = name}); }
  void collect(const std::string& name) {
    start(name);
    EXPECT_TRUE(collection_.wait_for_end({}, testing::kPatience));
    EXPECT_EQ(collection_.status()["state"], "done") << collection_.status();
  }

  Rig rig_;
  acquisition::AcceleratedClock clock_{
      kSpeed, session::from_iso8601(rig_.now()).value_or(session::TimePoint())};
  EventHub events_;
  db::Store store_ = db::Store::open(":memory:");
  // What the collection's thread uses outlives it: it may still tell of an end when a test
  // ends.
  std::atomic<bool> tells_{false}, starts_{false};
  std::function<void()> changed_;  // set before a thread may call it
  Collection collection_{events_, store_, clock_, [this] {
                           if (changed_) changed_();
                         }};
};

TEST_F(CollectionThreads, ACollectionThatBeginsWhileTheEstimateIsMadeAnewKeepsItsOwn) {
  import("long", 150);
  import("other", 4, "G2");  // G2 tells the estimate nothing
  collect("long");
  ASSERT_EQ(collection_.status()["estimate"]["samples"], 150);
  std::jthread withdrawer([&] { collection_.samples_changed("long"); });
  // The old estimate is gone: the new one is being made.
  ASSERT_TRUE(eventually([&] { return collection_.status()["estimate"].is_null(); }));
  start("other");
  withdrawer.join();
  EXPECT_TRUE(collection_.wait_for_end({}, testing::kPatience));
  const Json status = collection_.status();
  EXPECT_EQ(status["session"], "other");
  EXPECT_EQ(status["state"], "done");
  EXPECT_TRUE(status["estimate"].is_null()) << status["estimate"];
}

TEST_F(CollectionThreads, OfTwoWithdrawalsAtOnceTheLastCounts) {
  import("long", 60);
  collect("long");
  const db::SessionId id = store_.find_session("long");
  const auto withdraw = [&] {
    store_.undo_last(id);
    collection_.samples_changed("long");
  };
  std::jthread first(withdraw), second(withdraw);
  first.join();
  second.join();
  EXPECT_EQ(collection_.status()["estimate"]["samples"], 58);
}

TEST_F(CollectionThreads, TheNextMayStartWhileTheLastStillTellsOfItsEnd) {
  import("one", 4);
  import("two", 4);
  changed_ = [this] {
    if (collection_.active() || tells_.exchange(true)) return;
    // The first has ended; start() comes now, and still the state can be asked for.
    EXPECT_TRUE(eventually([this] { return starts_.load(); }));
    const auto moment = std::chrono::steady_clock::now() + std::chrono::milliseconds(50);
    EXPECT_TRUE(eventually([&] { return std::chrono::steady_clock::now() > moment; }));
    EXPECT_EQ(collection_.status()["session"], "one");
  };
  start("one");
  ASSERT_TRUE(eventually([this] { return tells_.load(); }));
  starts_ = true;
  start("two");
  EXPECT_TRUE(collection_.wait_for_end({}, testing::kPatience));
  EXPECT_EQ(collection_.status()["session"], "two");
  EXPECT_EQ(collection_.status()["state"], "done");
}

}  // namespace
}  // namespace sixdial::service
