// The collector while dials, robot or readings go wrong.
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
    EXPECT_EQ(each.sample.channels[3].reason, session::reason::kDisconnected);
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
  EXPECT_EQ(stored_[1].sample.channels[0].reason, session::reason::kFrozen);
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
    EXPECT_EQ(each.sample.channels[4].reason, session::reason::kImplausible);
    EXPECT_FALSE(each.sample.channels[5].value);
    EXPECT_EQ(each.sample.channels[5].quality, Quality::kUncertain);
    EXPECT_EQ(each.sample.channels[5].reason, session::reason::kNoContact);
  }
}

}  // namespace
}  // namespace sixdial::acquisition
