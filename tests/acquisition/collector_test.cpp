// The collector on a clock that stands still until slept on, with a rig of a few lines.
#include "acquisition/collector.h"

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <set>

namespace sixdial::acquisition {
namespace {

using namespace std::chrono_literals;
using session::Quality;
using testing::HasSubstr;
using testing::IsEmpty;

constexpr double kExact = 1e-12;  // numbers handed on unchanged

// A robot that goes where it is told in 100 ms, and remembers each command.
class FakeRobot final : public RobotPort {
 public:
  explicit FakeRobot(Clock& clock) : clock_(clock) {}
  tl::expected<RobotState, RobotFault> state(const std::stop_token&) override {
    if (state_fault) return tl::unexpected(*state_fault);
    return now;
  }
  tl::expected<RobotState, RobotFault> move_to(
      const Eigen::VectorXd& q, std::chrono::milliseconds,
      const std::stop_token& stop) override {
    commands.push_back(q);
    if (on_move) {
      if (auto fault = on_move(commands.size())) return tl::unexpected(*fault);
    }
    if (stop.stop_requested()) {
      return tl::unexpected(RobotFault{RobotFaultKind::kCancelled, ""});
    }
    clock_.sleep_for(100ms, stop);
    now.q = q;
    now.motion = Motion::kInPosition;
    now.temperature_c = 21.5;
    arrived_at = clock_.monotonic();
    return now;
  }

  RobotState now;
  DeviceTime arrived_at{0};
  std::vector<Eigen::Vector2d> commands;
  std::function<std::optional<RobotFault>(std::size_t command)> on_move;
  std::optional<RobotFault> state_fault;

 private:
  Clock& clock_;
};

// Dials that show what the nominal robot gives, each scan 50 ms later.
class FakeDials final : public DialSource {
 public:
  FakeDials(const geometry::Rig& rig, const FakeRobot& robot, Clock& clock)
      : rig_(rig), robot_(robot), clock_(clock), plausible_(rig, 5.0) {}
  [[nodiscard]] std::size_t size() const override { return rig_.dials.size(); }
  std::vector<Reading> read_since(DeviceTime, const std::stop_token& stop) override {
    const DeviceTime requested = clock_.monotonic();
    clock_.sleep_for(scan_time, stop);
    ++scans;
    std::vector<Reading> readings;
    const auto expected = plausible_.expected_at(robot_.now.q, assembly);
    for (std::size_t i = 0; i < size(); ++i) {
      double value = expected[i].displacement_mm.value_or(0.0);
      value += settling_mm(clock_.monotonic() - robot_.arrived_at);
      Reading reading = good_reading(value, requested, clock_.now_utc());
      reading.sequence = static_cast<std::uint64_t>(scans);
      if (spoil) spoil(i, reading);
      readings.push_back(reading);
    }
    return readings;
  }
  [[nodiscard]] std::vector<Reading> latest() const override { return {}; }

  std::function<void(std::size_t dial, Reading& reading)> spoil;
  std::function<double(DeviceTime since)> settling_mm = [](DeviceTime) { return 0.0; };
  int scans = 0;
  std::chrono::milliseconds scan_time{50};
  std::optional<geometry::Assembly> assembly;  // empty: the rig's

 private:
  const geometry::Rig& rig_;
  const FakeRobot& robot_;
  Clock& clock_;
  Plausibility plausible_;
};

class Collecting : public testing::Test {
 protected:
  Collecting() {
    for (int i = 0; i < 6; ++i) {
      session::PlanPoint point;
      point.set = "G1";
      point.point = i;
      point.target_mm = Eigen::Vector2d(20.0 + 3 * i, 40.0 + 2 * i);
      point.q = geometry::inverse(rig_.robot.nominal, point.target_mm, rig_.robot.working_mode)
                    .value();
      plan_.points.push_back(point);
    }
  }
  void spoil_dial(
      std::size_t dial, FaultKind kind, std::function<bool()> when = [] { return true; }) {
    dials_.spoil = [=](std::size_t i, Reading& reading) {
      if (i == dial && when()) {
        reading = bad_reading(Fault{kind, "spoilt"}, reading.requested, reading.time_utc);
      }
    };
  }
  CollectorResult run(const std::stop_token& stop = {}) {
    Collector::Callbacks callbacks;
    callbacks.store = [this](const CollectedSample& sample) {
      if (on_store_) on_store_(sample);
      stored_.push_back(sample);
    };
    callbacks.progress = [this](const CollectorProgress& progress) {
      progress_.push_back(progress);
      if (on_progress_) on_progress_(progress);
    };
    callbacks.done = done_;
    callbacks.wanted = wanted_;
    collector_.emplace(rig_, plan_, robot_, dials_, clock_, callbacks, settings_);
    return collector_->run(stop);
  }
  [[nodiscard]] std::vector<int> points() const {
    std::vector<int> result;
    for (const auto& each : stored_) result.push_back(each.sample.point);
    return result;
  }

  geometry::Rig rig_ = geometry::default_rig();
  session::Plan plan_;
  FakeClock clock_{session::TimePoint{std::chrono::milliseconds{1'700'000'000'000}}};
  FakeRobot robot_{clock_};
  FakeDials dials_{rig_, robot_, clock_};
  CollectorSettings settings_;
  std::function<bool(const session::PlanPoint&)> done_, wanted_;
  std::function<void(const CollectedSample&)> on_store_;
  std::function<void(const CollectorProgress&)> on_progress_;
  std::optional<Collector> collector_;
  std::vector<CollectedSample> stored_;
  std::vector<CollectorProgress> progress_;
};

TEST_F(Collecting, EveryPointOfThePlanIsStoredOnceInOrder) {
  const auto result = run();
  EXPECT_TRUE(result.complete);
  EXPECT_EQ(result.stored, 6u);
  EXPECT_EQ(points(), (std::vector<int>{0, 1, 2, 3, 4, 5}));
  std::optional<session::TimePoint> before;
  for (const auto& each : stored_) {
    const session::Sample& sample = each.sample;
    const auto& planned = plan_.points[each.plan_index];
    EXPECT_EQ(sample.set, "G1");
    EXPECT_EQ(sample.q, planned.q);
    EXPECT_EQ(sample.target_mm, planned.target_mm);
    EXPECT_EQ(sample.temperature_c, 21.5);
    ASSERT_EQ(sample.channels.size(), 6u);
    for (const auto& dial : sample.channels) {
      EXPECT_TRUE(dial.value);
      EXPECT_EQ(dial.quality, Quality::kGood) << dial.reason;
      ASSERT_TRUE(dial.time_utc);
      EXPECT_LE(*dial.time_utc, *sample.time_utc);
    }
    if (before) {
      EXPECT_GT(*sample.time_utc, *before);
    }
    before = sample.time_utc;
    EXPECT_THAT(each.remarks, IsEmpty());
    EXPECT_EQ(each.attempt, 1);
  }
  EXPECT_EQ(progress_.back().stage, CollectorStage::kFinished);
  EXPECT_EQ(progress_.back().done, 6u);
  ASSERT_TRUE(progress_.back().eta_s);
  EXPECT_NEAR(*progress_.back().eta_s, 0.0, kExact);
}

TEST_F(Collecting, APointIsStoredBeforeTheRobotGoesToTheNext) {
  on_store_ = [&](const CollectedSample& sample) {
    EXPECT_EQ(robot_.commands.size(), sample.plan_index + 1);
  };
  EXPECT_EQ(run().stored, 6u);
}

// Points 0 to 2 in the rig's mode, 3 to 5 with leg 1's elbow on the other side.
class CollectingInTwoModes : public Collecting {
 protected:
  CollectingInTwoModes() {
    for (std::size_t i = 3; i < 6; ++i) {
      session::PlanPoint& point = plan_.points[i];
      point.q = geometry::inverse(rig_.robot.nominal, point.target_mm, {-1, +1}).value();
    }
    // The dials follow the command that is under way.
    robot_.on_move = [this](std::size_t) {
      for (const auto& point : plan_.points) {
        if (point.q == robot_.commands.back()) {
          dials_.assembly = session::branch_of(rig_, point).assembly;
        }
      }
      return std::nullopt;
    };
  }
  /// Answers every pause.
  void when_paused(std::function<void()> answer) {
    on_progress_ = [this, answer](const CollectorProgress& progress) {
      if (progress.stage != CollectorStage::kPaused) return;
      ++pauses_;
      commands_at_pause_ = robot_.commands.size();
      EXPECT_EQ(progress.plan_index, 3u + asked_);
      EXPECT_THAT(progress.message, HasSubstr("bring the legs over"));
      answer();
    };
  }
  int pauses_ = 0;
  std::size_t asked_ = 0;
  std::size_t commands_at_pause_ = 0;
};

TEST_F(CollectingInTwoModes, APersonIsAskedToBringTheLegsOverBeforeAnythingMoves) {
  when_paused([this] { collector_->resume(); });
  const auto result = run();
  EXPECT_TRUE(result.complete);
  EXPECT_EQ(pauses_, 1);
  EXPECT_EQ(commands_at_pause_, 3u);
  EXPECT_EQ(points(), (std::vector<int>{0, 1, 2, 3, 4, 5}));
  ASSERT_EQ(stored_[3].remarks.size(), 1u);
  EXPECT_THAT(stored_[3].remarks[0], HasSubstr("working mode -+"));
  for (const CollectedSample& each : stored_) {
    for (const auto& dial : each.sample.channels) {
      EXPECT_EQ(dial.quality, Quality::kGood) << each.sample.point << ": " << dial.reason;
    }
  }
}

TEST_F(CollectingInTwoModes, SkippingLeavesPointByPointOut) {
  when_paused([this] {
    ++asked_;
    collector_->skip();
  });
  const auto result = run();
  EXPECT_EQ(pauses_, 3);
  EXPECT_EQ(result.stored, 3u);
  EXPECT_EQ(result.skipped.size(), 3u);
  EXPECT_EQ(robot_.commands.size(), 3u);
}

TEST_F(CollectingInTwoModes, ARigThatCanDoesItByItself) {
  when_paused([] { ADD_FAILURE() << "nobody is to be asked"; });
  settings_.on_branch_change = OnBranchChange::kGo;
  EXPECT_EQ(run().stored, 6u);
  EXPECT_EQ(pauses_, 0);
}

TEST_F(CollectingInTwoModes, ARunThatBeginsWhereTheLegsStandAlreadyAsksNobody) {
  robot_.now.q = plan_.points[4].q;
  robot_.now.motion = Motion::kInPosition;
  done_ = [](const session::PlanPoint& point) { return point.point < 3; };
  when_paused([] { ADD_FAILURE() << "nobody is to be asked"; });
  EXPECT_EQ(run().stored, 3u);
}

TEST_F(Collecting, PointsThatAreNotWantedAnyMoreAreLeftOut) {
  wanted_ = [this](const session::PlanPoint& point) {
    return stored_.size() < 2 || point.point == 5;
  };
  const auto result = run();
  EXPECT_TRUE(result.complete);
  EXPECT_EQ(points(), (std::vector<int>{0, 1, 5}));
  EXPECT_EQ(result.left_out, 3u);
  EXPECT_EQ(progress_.back().done, 6u);
}

// A large way to settle, and one so small that the first three readings alone look settled.
TEST_F(Collecting, ReadingsAreTakenOnlyWhenTheySettled) {
  // Spread limit 12 um over a window of 150 ms with a time constant of 100 ms: rest 3.5 um.
  constexpr double kRest_mm = 0.004;
  dials_.scan_time = 5ms;
  const auto expected = Plausibility(rig_, 5.0).expected_at(plan_.points[0].q);
  for (const double way_mm : {5.0, 0.02}) {
    dials_.settling_mm = [=](DeviceTime since) {
      return way_mm * std::exp(-std::chrono::duration<double>(since).count() / 0.1);
    };
    stored_.clear();
    EXPECT_TRUE(run().complete);
    for (std::size_t i = 0; i < 6; ++i) {
      const auto& dial = stored_[0].sample.channels[i];
      EXPECT_EQ(dial.quality, Quality::kGood);
      EXPECT_NEAR(dial.value.value(), expected[i].displacement_mm.value(), kRest_mm);
    }
  }
}

TEST_F(Collecting, WhatNeverSettlesIsStoredAsUnsettled) {
  dials_.spoil = [&](std::size_t i, Reading& reading) {
    if (i == 2) *reading.value_mm += dials_.scans % 2 == 0 ? 0.05 : 0.0;
  };
  EXPECT_TRUE(run().complete);
  EXPECT_EQ(stored_[0].sample.channels[2].quality, Quality::kUncertain);
  EXPECT_EQ(stored_[0].sample.channels[2].reason, "unsettled");
  EXPECT_TRUE(stored_[0].sample.channels[2].value);
  EXPECT_EQ(stored_[0].sample.channels[1].quality, Quality::kGood);
  EXPECT_THAT(stored_[0].remarks.front(), HasSubstr("dial C"));
}

TEST_F(Collecting, JointsArriveFromTheAskedSide) {
  for (std::size_t i = 0; i < plan_.points.size(); ++i) {
    plan_.points[i].approach = i % 2 == 0 ? std::vector{1, -1} : std::vector{-1, 1};
  }
  EXPECT_TRUE(run().complete);
  ASSERT_EQ(robot_.commands.size(), 12u);
  for (std::size_t i = 0; i < 6; ++i) {
    const Eigen::Vector2d way = robot_.commands[2 * i + 1] - robot_.commands[2 * i];
    for (std::size_t joint = 0; joint < 2; ++joint) {
      const int asked = plan_.points[i].approach[joint];
      EXPECT_GT(way[static_cast<Eigen::Index>(joint)] * asked, 0.0);
      EXPECT_EQ(stored_[i].sample.approach[joint], asked);
    }
    EXPECT_EQ(robot_.commands[2 * i + 1], plan_.points[i].q);
  }
}

TEST_F(Collecting, TheDirectionOfTheLastMoveIsKeptWhereNoneIsAsked) {
  EXPECT_TRUE(run().complete);
  EXPECT_EQ(stored_[0].sample.approach[0], 0);  // nobody knows where it came from
  int compared = 0;
  for (std::size_t i = 1; i < 6; ++i) {
    for (std::size_t joint = 0; joint < 2; ++joint) {
      const auto j = static_cast<Eigen::Index>(joint);
      const double way = plan_.points[i].q[j] - plan_.points[i - 1].q[j];
      EXPECT_EQ(stored_[i].sample.approach[joint], way > 0 ? 1 : -1);
      ++compared;
    }
  }
  EXPECT_EQ(compared, 10);
}

TEST_F(Collecting, GoesOnWhereAnEarlierRunEnded) {
  const std::set<int> before{0, 1, 4};
  done_ = [&](const session::PlanPoint& point) { return before.contains(point.point); };
  const auto result = run();
  EXPECT_EQ(result.already_done, 3u);
  EXPECT_EQ(points(), (std::vector<int>{2, 3, 5}));
  EXPECT_EQ(progress_.back().done, 6u);
}

TEST_F(Collecting, ADialThatFailsNowAndThenIsAskedAgain) {
  spoil_dial(1, FaultKind::kTimeout, [&] { return dials_.scans % 10 == 2; });
  EXPECT_TRUE(run().complete);
  for (const auto& each : stored_) EXPECT_EQ(each.sample.channels[1].quality, Quality::kGood);
}

TEST_F(Collecting, ADialThatStaysAwayIsStoredAsBadAndNeverDropped) {
  spoil_dial(3, FaultKind::kDisconnected);
  EXPECT_TRUE(run().complete);
  ASSERT_EQ(stored_.size(), 6u);
  for (const auto& each : stored_) {
    EXPECT_FALSE(each.sample.channels[3].value);
    EXPECT_EQ(each.sample.channels[3].quality, Quality::kBad);
    EXPECT_EQ(each.sample.channels[3].reason, "disconnected");
    ASSERT_EQ(each.remarks.size(), 1u);
    EXPECT_THAT(each.remarks[0], HasSubstr("dial D: disconnected"));
  }
}

TEST_F(Collecting, MayPauseForADialUntilAPersonDecides) {
  settings_.on_dial_fault = OnDialFault::kPause;
  bool broken = true;
  spoil_dial(3, FaultKind::kTimeout, [&] { return broken; });
  int pauses = 0;
  on_progress_ = [&](const CollectorProgress& progress) {
    if (progress.stage != CollectorStage::kPaused) return;
    EXPECT_THAT(progress.message, HasSubstr("dial D: timeout"));
    switch (++pauses) {
      case 1:
        collector_->accept();  // point 0 as it is
        break;
      case 2:
        collector_->skip();  // point 1 not at all
        break;
      default:
        broken = false;  // mended: point 2 again
        collector_->resume();
        break;
    }
  };
  const auto result = run();
  EXPECT_TRUE(result.complete);
  EXPECT_EQ(pauses, 3);
  EXPECT_EQ(points(), (std::vector<int>{0, 2, 3, 4, 5}));
  EXPECT_EQ(stored_[0].sample.channels[3].quality, Quality::kBad);
  EXPECT_EQ(stored_[1].sample.channels[3].quality, Quality::kGood);
  ASSERT_EQ(result.skipped.size(), 1u);
  EXPECT_EQ(result.skipped[0].plan_index, 1u);
  EXPECT_THAT(result.skipped[0].why, HasSubstr("timeout"));
}

TEST_F(Collecting, PausesWhenNoDialAnswersAtAll) {
  bool dead = true;
  dials_.spoil = [&](std::size_t, Reading& reading) {
    if (dead) {
      reading = bad_reading(
          Fault{FaultKind::kDisconnected, "out"}, reading.requested, reading.time_utc);
    }
  };
  on_progress_ = [&](const CollectorProgress& progress) {
    if (progress.stage != CollectorStage::kPaused) return;
    EXPECT_THAT(progress.message, HasSubstr("no dial answers"));
    dead = false;
    collector_->resume();
  };
  EXPECT_TRUE(run().complete);
  EXPECT_EQ(points(), (std::vector<int>{0, 1, 2, 3, 4, 5}));
}

TEST_F(Collecting, AnUnreachablePointIsReportedAndTheRunGoesOn) {
  robot_.on_move = [&](std::size_t command) -> std::optional<RobotFault> {
    if (command != 3) return std::nullopt;
    return RobotFault{RobotFaultKind::kUnreachable, "out of reach"};
  };
  const auto result = run();
  EXPECT_TRUE(result.complete);
  EXPECT_EQ(points(), (std::vector<int>{0, 1, 3, 4, 5}));
  ASSERT_EQ(result.failed.size(), 1u);
  EXPECT_EQ(result.failed[0].plan_index, 2u);
  EXPECT_THAT(result.failed[0].why, HasSubstr("out of reach"));
}

TEST_F(Collecting, ARobotThatDoesNotAnswerIsTriedAgainThenPauses) {
  int failures = 2;
  robot_.on_move = [&](std::size_t) -> std::optional<RobotFault> {
    if (failures-- <= 0) return std::nullopt;
    return RobotFault{RobotFaultKind::kLink, "no answer"};
  };
  EXPECT_TRUE(run().complete);  // settings_.robot_retries more tries were enough
  EXPECT_EQ(stored_.size(), 6u);

  stored_.clear();
  failures = 3;
  int pauses = 0;
  on_progress_ = [&](const CollectorProgress& progress) {
    if (progress.stage != CollectorStage::kPaused) return;
    ++pauses;
    EXPECT_THAT(progress.message, HasSubstr("robot"));
    collector_->resume();
  };
  EXPECT_TRUE(run().complete);
  EXPECT_EQ(pauses, 1);
  EXPECT_EQ(stored_.size(), 6u);
}

TEST_F(Collecting, ObeysSkipAndRetakeWhileAPointIsInHand) {
  bool skipped = false;
  int moves_of_3 = 0;
  on_progress_ = [&](const CollectorProgress& progress) {
    if (progress.stage == CollectorStage::kMoving && progress.plan_index == 3u) ++moves_of_3;
    if (progress.stage != CollectorStage::kSettling) return;
    if (progress.plan_index == 1u && !skipped) {
      skipped = true;
      collector_->skip();
    }
    if (progress.plan_index == 3u && moves_of_3 == 1) collector_->retake();
  };
  const auto result = run();
  EXPECT_TRUE(result.complete);
  EXPECT_EQ(points(), (std::vector<int>{0, 2, 3, 4, 5}));
  EXPECT_EQ(moves_of_3, 2);
  ASSERT_EQ(result.skipped.size(), 1u);
  EXPECT_EQ(result.skipped[0].plan_index, 1u);
}

TEST_F(Collecting, ARetakeAfterStoringIsANewRow) {
  on_progress_ = [&](const CollectorProgress& progress) {
    if (progress.stage != CollectorStage::kStored || stored_.back().attempt > 1) return;
    if (progress.plan_index == 1u) collector_->retake();
    if (progress.plan_index == 5u) collector_->retake(0);
  };
  EXPECT_TRUE(run().complete);
  EXPECT_EQ(points(), (std::vector<int>{0, 1, 1, 2, 3, 4, 5, 0}));
  EXPECT_EQ(stored_[2].attempt, 2);
  EXPECT_EQ(stored_[7].attempt, 2);
  EXPECT_THROW(collector_->retake(6), std::invalid_argument);
}

TEST_F(Collecting, PausesAfterThePointInHandAndGoesOnWhenTold) {
  int pauses = 0;
  on_progress_ = [&](const CollectorProgress& progress) {
    if (progress.stage == CollectorStage::kSettling && progress.plan_index == 2u &&
        pauses == 0) {
      collector_->pause();
    }
    if (progress.stage == CollectorStage::kPaused) {
      ++pauses;
      EXPECT_EQ(stored_.size(), 3u);
      EXPECT_EQ(progress.plan_index, 3u);
      collector_->resume();
    }
  };
  EXPECT_TRUE(run().complete);
  EXPECT_EQ(pauses, 1);
  EXPECT_EQ(stored_.size(), 6u);
}

TEST_F(Collecting, StopsWithThePointsItHas) {
  std::stop_source stop;
  on_progress_ = [&](const CollectorProgress& progress) {
    if (progress.stage == CollectorStage::kSettling && progress.plan_index == 2u) {
      stop.request_stop();
    }
  };
  const auto result = run(stop.get_token());
  EXPECT_FALSE(result.complete);
  EXPECT_EQ(points(), (std::vector<int>{0, 1}));
  EXPECT_EQ(progress_.back().stage, CollectorStage::kStopped);
}

TEST_F(Collecting, AStoreThatFailsEndsTheRunLoudly) {
  on_store_ = [&](const CollectedSample& sample) {
    if (sample.plan_index == 2) throw std::runtime_error("disk full");
  };
  EXPECT_THROW(run(), std::runtime_error);
  EXPECT_EQ(stored_.size(), 2u);
}

TEST_F(Collecting, AFrozenDialIsNoticedWhenTheRobotMoves) {
  double held_mm = 0.0;
  dials_.spoil = [&](std::size_t i, Reading& reading) {
    if (i != 0) return;
    if (stored_.empty()) held_mm = *reading.value_mm;
    reading.value_mm = held_mm;
  };
  EXPECT_TRUE(run().complete);
  EXPECT_EQ(stored_[0].sample.channels[0].quality, Quality::kGood);
  EXPECT_EQ(stored_[1].sample.channels[0].quality, Quality::kBad);
  EXPECT_EQ(stored_[1].sample.channels[0].reason, "frozen");
  EXPECT_EQ(stored_[1].sample.channels[1].quality, Quality::kGood);
}

TEST_F(Collecting, ImplausibleReadingsAreKeptAndMarked) {
  dials_.spoil = [&](std::size_t i, Reading& reading) {
    if (i == 4) *reading.value_mm += 7.0;
    if (i == 5) {
      reading.value_mm.reset();
      reading.reason = "no contact";
    }
  };
  EXPECT_TRUE(run().complete);
  for (const auto& each : stored_) {
    EXPECT_TRUE(each.sample.channels[4].value);
    EXPECT_EQ(each.sample.channels[4].quality, Quality::kUncertain);
    EXPECT_EQ(each.sample.channels[4].reason, "implausible");
    EXPECT_FALSE(each.sample.channels[5].value);
    EXPECT_EQ(each.sample.channels[5].quality, Quality::kUncertain);
    EXPECT_EQ(each.sample.channels[5].reason, "no contact");
  }
}

TEST(Plausible, SwappedDialsAreNamed) {
  const geometry::Rig rig = geometry::default_rig();
  const Plausibility plausibility(rig, 5.0);
  const auto q = geometry::inverse(rig.robot.nominal, {36, 44}, rig.robot.working_mode).value();
  const auto expected = plausibility.expected_at(q);
  std::vector<Reading> readings;
  for (const auto& each : expected) {
    readings.push_back(good_reading(each.displacement_mm.value(), DeviceTime{0}, {}));
  }
  ASSERT_GT(std::abs(*readings[0].value_mm - *readings[1].value_mm), 5.0);
  auto straight = readings;
  plausibility.judge(straight, expected);
  for (const auto& each : straight) EXPECT_EQ(each.quality, Quality::kGood);
  std::swap(readings[0].value_mm, readings[1].value_mm);
  plausibility.judge(readings, expected);
  EXPECT_THAT(readings[0].detail, HasSubstr("would fit dial B"));
  EXPECT_THAT(readings[1].detail, HasSubstr("would fit dial A"));
  EXPECT_EQ(readings[2].quality, Quality::kGood);
}

TEST(Plausible, AFreeCuboidAllowsNoExpectation) {
  geometry::Rig rig = geometry::default_rig();
  rig.cuboid.mount = geometry::Mount::kFree;
  for (const auto& each : Plausibility(rig, 5.0).expected_at(Eigen::Vector2d(1.0, 2.0))) {
    EXPECT_FALSE(each.displacement_mm);
    EXPECT_FALSE(each.off_face);
  }
}

}  // namespace
}  // namespace sixdial::acquisition
