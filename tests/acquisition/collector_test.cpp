// The collector: points in order, settling, arrival, pauses, and a person's commands.
#include "acquisition/collector.h"

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <set>

#include "session/reason.h"
#include "tests/acquisition/collector_fixture.h"

namespace sixdial::acquisition {
namespace {

using namespace std::chrono_literals;
using session::Quality;
using testing::HasSubstr;
using testing::IsEmpty;

constexpr double kExact = 1e-12;  // numbers handed on unchanged

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

TEST_F(Collecting, WhatWasCommandedIsKeptWhereTheReadBackIsElsewhere) {
  // The controller stops short of points 2 and 4, and says so; of the others it gives the
  // command in its own digits.
  robot_.on_read = [this](Eigen::VectorXd& q) {
    const std::size_t point = robot_.commands.size() - 1;
    q[1] += point == 2 || point == 4 ? 5e-4 : 7e-7;
  };
  EXPECT_EQ(run().stored, 6u);
  for (const auto& each : stored_) {
    const auto& planned = plan_.points[each.plan_index];
    const bool short_of_it = each.plan_index == 2 || each.plan_index == 4;
    ASSERT_EQ(each.sample.q_command.size(), short_of_it ? 2 : 0) << each.plan_index;
    if (!short_of_it) continue;
    EXPECT_EQ(each.sample.q_command, planned.q);
    EXPECT_NEAR(each.sample.q[1], planned.q[1] + 5e-4, kExact);
  }
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
  EXPECT_EQ(stored_[0].sample.channels[2].reason, session::reason::kUnsettled);
  EXPECT_TRUE(stored_[0].sample.channels[2].value);
  EXPECT_EQ(stored_[0].sample.channels[1].quality, Quality::kGood);
  EXPECT_THAT(stored_[0].remarks.front(), HasSubstr("dial C"));
}

// A rig whose clock runs fast on a busy machine, or a slow radio link: two scans take all the
// time there is to settle.
TEST_F(Collecting, DialsThatAnswerSlowlyAreNotCalledUnsettled) {
  dials_.scan_time = 6s;
  spoil_dial(1, FaultKind::kTimeout, [this] { return dials_.scans == 2; });
  EXPECT_TRUE(run().complete);
  for (const auto& dial : stored_[0].sample.channels) {
    EXPECT_EQ(dial.quality, Quality::kGood) << dial.reason;
  }
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

}  // namespace
}  // namespace sixdial::acquisition
