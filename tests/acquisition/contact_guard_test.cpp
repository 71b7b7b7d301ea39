// Two dials that lose the cuboid on a move halt the robot; one, or two that need not touch, do
// not.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <atomic>
#include <condition_variable>
#include <mutex>

#include "acquisition/collector.h"
#include "session/reason.h"

namespace sixdial::acquisition {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;

constexpr auto kPatience = std::chrono::seconds(60);
constexpr auto kLongMove = std::chrono::milliseconds(600);  // several looks of the guard

/// Its second move takes long, and ends when it is told to stop.
class SlowRobot final : public RobotPort {
 public:
  tl::expected<RobotState, RobotFault> state(const std::stop_token&) override { return now_; }
  tl::expected<RobotState, RobotFault> move_to(
      const Eigen::VectorXd& q, std::chrono::milliseconds,
      const std::stop_token& stop) override {
    ++moves;
    if (moves == 2) {
      std::mutex mutex;
      std::condition_variable_any over;
      std::unique_lock lock(mutex);
      moving = true;
      over.wait_for(lock, stop, move_time, [&] { return stop.stop_requested(); });
      moving = false;
      if (stop.stop_requested()) {
        ++halts;
        return tl::unexpected(RobotFault{RobotFaultKind::kCancelled, ""});
      }
    }
    now_.q = q;
    now_.motion = Motion::kInPosition;
    return now_;
  }
  std::atomic<bool> moving = false;
  std::chrono::milliseconds move_time = kLongMove;
  int moves = 0, halts = 0;

 private:
  RobotState now_;
};

/// Show what the nominal robot gives; those in `lost` hang free while the robot moves.
class Dials final : public DialSource {
 public:
  Dials(const geometry::Rig& rig, SlowRobot& robot, Clock& clock)
      : rig_(rig), robot_(robot), clock_(clock), plausible_(rig, 5.0) {}
  [[nodiscard]] std::size_t size() const override { return rig_.dials.size(); }
  std::vector<Reading> read_since(DeviceTime, const std::stop_token& stop) override {
    const DeviceTime requested = clock_.monotonic();
    clock_.sleep_for(std::chrono::milliseconds(50), stop);
    std::vector<Reading> readings;
    for (const auto& expected : plausible_.expected_at(robot_.state({})->q)) {
      readings.push_back(
          good_reading(expected.displacement_mm.value_or(0.0), requested, clock_.now_utc()));
    }
    return readings;
  }
  [[nodiscard]] std::vector<Reading> latest() const override {
    std::vector<Reading> readings;
    ++looks_;
    for (std::size_t i = 0; i < size(); ++i) {
      Reading reading = good_reading(10.0, clock_.monotonic(), clock_.now_utc());
      reading.sequence = looks_;
      if (robot_.moving && std::ranges::find(lost, i) != lost.end()) {
        reading.value_mm.reset();
        reading.reason = session::reason::kNoContact;
      }
      readings.push_back(reading);
    }
    return readings;
  }
  std::vector<std::size_t> lost;

 private:
  const geometry::Rig& rig_;
  SlowRobot& robot_;
  Clock& clock_;
  Plausibility plausible_;
  mutable std::atomic<std::uint64_t> looks_ = 0;
};

class ContactGuard : public ::testing::Test {
 protected:
  ContactGuard() {
    for (int i = 0; i < 3; ++i) {
      session::PlanPoint point;
      point.set = "G1";
      point.point = i;
      point.target_mm = Eigen::Vector2d(27.0 + i, 47.0 + i);
      point.q = geometry::inverse(rig_.robot.nominal, point.target_mm, rig_.robot.working_mode)
                    .value();
      plan_.points.push_back(point);
    }
  }
  CollectorResult run() {
    Collector::Callbacks callbacks;
    callbacks.store = [](const CollectedSample&) {};
    callbacks.progress = [this](const CollectorProgress& progress) {
      if (progress.stage != CollectorStage::kPaused) return;
      paused_.push_back(*progress.pause);
      said_ = progress.message;
      dials_.lost.clear();  // a person has mended it
      collector_->resume();
    };
    collector_.emplace(rig_, plan_, robot_, dials_, clock_, callbacks, settings_);
    return collector_->run({});
  }
  /// Dials that the nominal robot pushes in far enough at all points, and those that it does
  /// not.
  [[nodiscard]] std::vector<std::size_t> touching(bool surely) const {
    const Plausibility plausible(rig_, 5.0);
    std::vector<std::size_t> found;
    for (std::size_t i = 0; i < rig_.dials.size(); ++i) {
      bool all = true;
      for (const session::PlanPoint& point : plan_.points) {
        const auto expected = plausible.expected_at(point.q)[i].displacement_mm;
        all = all && expected && *expected > 5.5;
      }
      if (all == surely) found.push_back(i);
    }
    return found;
  }

  geometry::Rig rig_ = geometry::default_rig();
  session::Plan plan_;
  FakeClock clock_{session::TimePoint{std::chrono::milliseconds{1'700'000'000'000}}};
  SlowRobot robot_;
  Dials dials_{rig_, robot_, clock_};
  CollectorSettings settings_;
  std::optional<Collector> collector_;
  std::vector<PauseReason> paused_;
  std::string said_;
};

TEST_F(ContactGuard, TwoDialsThatLoseTheCuboidHaltTheRobot) {
  const auto sure = touching(true);
  ASSERT_GE(sure.size(), 2U);
  dials_.lost = {sure[0], sure[1]};
  robot_.move_time = kPatience;
  const CollectorResult result = run();
  EXPECT_EQ(robot_.halts, 1);
  EXPECT_THAT(paused_, ElementsAre(PauseReason::kLostContact));
  EXPECT_THAT(said_, HasSubstr(rig_.dials[sure[0]].id + ", " + rig_.dials[sure[1]].id));
  EXPECT_THAT(said_, HasSubstr("the robot was halted"));
  EXPECT_EQ(result.stored, plan_.points.size()) << "it goes on once it is mended";
}

TEST_F(ContactGuard, OneDialThatSticksHaltsNothing) {
  dials_.lost = {touching(true).front()};
  const CollectorResult result = run();
  EXPECT_EQ(robot_.halts, 0);
  EXPECT_THAT(paused_, IsEmpty());
  EXPECT_EQ(result.stored, plan_.points.size());
}

TEST_F(ContactGuard, DialsThatNeedNotTouchMayHangFree) {
  dials_.lost = touching(false);
  const CollectorResult result = run();
  EXPECT_EQ(robot_.halts, 0);
  EXPECT_THAT(paused_, IsEmpty());
  EXPECT_EQ(result.stored, plan_.points.size());
}

TEST_F(ContactGuard, IsLeftOutWhereItIsAskedTo) {
  const auto sure = touching(true);
  dials_.lost = {sure[0], sure[1]};
  settings_.halt_on_lost_contact = false;
  EXPECT_EQ(run().stored, plan_.points.size());
  EXPECT_EQ(robot_.halts, 0);
  EXPECT_THAT(paused_, IsEmpty());
}

}  // namespace
}  // namespace sixdial::acquisition
