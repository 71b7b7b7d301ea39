// The live rig, its clock, its displays and the ordered faults behind one lock: what all cables
// plug into. Thread-safe.
#pragma once

#include <chrono>
#include <cstdint>
#include <functional>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <vector>

#include "mock_devices/bench.h"
#include "mock_devices/dials/dialect.h"
#include "mock_devices/faults.h"
#include "mock_devices/live_rig.h"
#include "mock_devices/registers.h"

namespace sixdial::mock_devices {

/// Mock time: start + speed (wall - wall at start), by a clock that never steps.
class MockClock {
 public:
  MockClock(double speed, std::int64_t start_ms);
  [[nodiscard]] double seconds() const;  // since the start
  [[nodiscard]] std::int64_t utc_ms() const;
  [[nodiscard]] double speed() const { return speed_; }
  [[nodiscard]] std::int64_t start_ms() const { return start_ms_; }

 private:
  double speed_;
  std::int64_t start_ms_;
  std::chrono::steady_clock::time_point wall_start_;
};

class RigBench final : public Bench {
 public:
  /// `seconds`: the mock time.
  RigBench(const World& world, const LiveRigHabits& habits, std::function<double()> seconds);

  [[nodiscard]] std::unique_ptr<Panel> panel(std::string connection) override;
  [[nodiscard]] RobotCalls robot_port() override;
  [[nodiscard]] std::vector<std::string> dial_ids() const override;
  [[nodiscard]] std::uint64_t seed() const override { return world_.seed; }

  /// Zero and hold act at once; the other faults wait in the book for their reply.
  void order_fault(std::size_t dial, const FaultOrder& order);
  void clear_faults();
  [[nodiscard]] FaultBook& faults() { return faults_; }
  [[nodiscard]] std::optional<std::size_t> dial_index(const std::string& id) const;

  [[nodiscard]] TruePose true_pose() const;
  [[nodiscard]] RobotReport robot() const;
  [[nodiscard]] double seconds() const { return seconds_(); }
  [[nodiscard]] const World& world() const { return world_; }

 private:
  class PanelOnBench;
  struct Display {
    double zero_mm = 0.0;
    double held_mm = 0.0;
    bool hold = false;
    bool inch = false;
  };
  [[nodiscard]] ShownDial show(std::size_t dial, const std::string& connection);
  void hold_present_value(std::size_t dial);

  const World world_;
  const std::function<double()> seconds_;
  FaultBook faults_;
  mutable std::mutex mutex_;  // guards live_ and displays_
  mutable LiveRig live_;
  std::vector<Display> displays_;
};

}  // namespace sixdial::mock_devices
