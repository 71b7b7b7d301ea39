// A collector on a clock that stands still until slept on, with a rig of a few lines.
#pragma once

#include <gtest/gtest.h>

#include <chrono>
#include <functional>
#include <optional>
#include <vector>

#include "acquisition/collector.h"
#include "acquisition/plausibility.h"

namespace sixdial::acquisition {

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
    clock_.sleep_for(std::chrono::milliseconds(100), stop);
    now.q = q;
    if (on_read) on_read(now.q);
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
  std::function<void(Eigen::VectorXd& q)> on_read;  // what its encoders make of a command

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

}  // namespace sixdial::acquisition
