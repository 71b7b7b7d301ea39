#include "mock_devices/rig_bench.h"

#include <cmath>

namespace sixdial::mock_devices {
namespace {

constexpr double kMmPerInch = 25.4;
constexpr double kScans_hz = 100.0;  // the gauge box; each dial renews its value more slowly

}  // namespace

MockClock::MockClock(double speed, std::int64_t start_ms)
    : speed_(speed), start_ms_(start_ms), wall_start_(std::chrono::steady_clock::now()) {}

double MockClock::seconds() const {
  const std::chrono::duration<double> wall = std::chrono::steady_clock::now() - wall_start_;
  return speed_ * wall.count();
}

std::int64_t MockClock::utc_ms() const { return start_ms_ + std::llround(seconds() * 1000.0); }

class RigBench::PanelOnBench final : public Panel {
 public:
  PanelOnBench(RigBench& bench, std::string connection)
      : bench_(bench), connection_(std::move(connection)) {}
  std::size_t dial_count() const override { return bench_.world_.rig.dials.size(); }
  ShownDial show(std::size_t dial) override { return bench_.show(dial, connection_); }
  std::optional<FaultOrder> take(std::size_t dial, Fault fault) override {
    return bench_.faults_.take(dial, fault, connection_);
  }
  void set_inch(std::size_t dial, bool inch) override {
    const std::lock_guard lock(bench_.mutex_);
    bench_.displays_[dial].inch = inch;
  }
  void set_hold(std::size_t dial, bool hold) override {
    if (hold) bench_.hold_present_value(dial);
    const std::lock_guard lock(bench_.mutex_);
    bench_.displays_[dial].hold = hold;
  }
  std::uint16_t scan() override {
    return static_cast<std::uint16_t>(
        static_cast<std::int64_t>(std::max(0.0, bench_.seconds_()) * kScans_hz));
  }

 private:
  RigBench& bench_;
  const std::string connection_;
};

RigBench::RigBench(
    const World& world, const LiveRigHabits& habits, std::function<double()> seconds)
    : world_(world),
      seconds_(std::move(seconds)),
      live_(world, habits),
      displays_(world.rig.dials.size()) {}

std::unique_ptr<Panel> RigBench::panel(std::string connection) {
  return std::make_unique<PanelOnBench>(*this, std::move(connection));
}

RobotCalls RigBench::robot_port() {
  return {
      .report = [this] { return robot(); },
      .start =
          [this](const Eigen::VectorXd& q_rad, int speed_percent) {
            const std::lock_guard lock(mutex_);
            live_.start_move(q_rad, speed_percent, seconds_());
          },
      .stop =
          [this] {
            const std::lock_guard lock(mutex_);
            live_.stop(seconds_());
          },
      .follow =
          [this](const Eigen::VectorXd& q_rad, double seconds) {
            const std::lock_guard lock(mutex_);
            live_.follow(q_rad, seconds, seconds_());
          }};
}

std::vector<std::string> RigBench::dial_ids() const {
  std::vector<std::string> ids;
  for (const geometry::Dial& dial : world_.rig.dials) ids.push_back(dial.id);
  return ids;
}

ShownDial RigBench::show(std::size_t dial, const std::string& connection) {
  // A dial behind a cable of its own, or in a gauge box, that was plugged in the wrong place.
  if (faults_.take(dial, Fault::kWrongChannel, connection)) {
    dial = (dial + 1) % displays_.size();
  }
  const bool inch = faults_.take(dial, Fault::kInch, connection).has_value();
  const bool frozen = faults_.take(dial, Fault::kFrozen, connection).has_value();
  const bool low_battery = faults_.take(dial, Fault::kLowBattery, connection).has_value();
  const std::lock_guard lock(mutex_);
  const DialFace face = live_.dial(dial, seconds_());
  const Display& display = displays_[dial];
  ShownDial shown;
  shown.in_contact = face.in_contact;
  shown.at_travel_end = face.at_travel_end;
  shown.moving_fast = face.moving_fast;
  shown.low_battery = low_battery;
  double value_mm = face.value_mm;
  if (frozen || display.hold) {
    value_mm = display.held_mm;
    shown.moving_fast = false;
  }
  value_mm -= display.zero_mm;
  shown.inch = inch || display.inch;
  shown.value = shown.inch ? value_mm / kMmPerInch : value_mm;
  return shown;
}

void RigBench::hold_present_value(std::size_t dial) {
  const std::lock_guard lock(mutex_);
  displays_[dial].held_mm = live_.dial(dial, seconds_()).value_mm;
}

void RigBench::order_fault(std::size_t dial, const FaultOrder& order) {
  switch (order.fault) {
    case Fault::kZeroPressed: {
      const std::lock_guard lock(mutex_);
      displays_[dial].zero_mm = live_.dial(dial, seconds_()).value_mm;
      return;
    }
    case Fault::kFrozen:
      hold_present_value(dial);
      break;
    case Fault::kUnsolicitedLine: {
      hold_present_value(dial);
      FaultOrder hold = order;
      hold.fault = Fault::kFrozen;
      faults_.order(dial, hold);
      // The line itself comes once.
      FaultOrder line = order;
      line.count = 1;
      faults_.order(dial, line);
      return;
    }
    case Fault::kPowerOnLine:
    case Fault::kHangUp: {
      FaultOrder once = order;
      once.count = 1;
      faults_.order(dial, once);
      return;
    }
    default:
      break;
  }
  faults_.order(dial, order);
}

void RigBench::clear_faults() {
  faults_.clear();
  const std::lock_guard lock(mutex_);
  for (Display& display : displays_) display = Display{};
}

std::optional<std::size_t> RigBench::dial_index(const std::string& id) const {
  return world_.rig.find_dial(id);
}

TruePose RigBench::true_pose() const {
  const std::lock_guard lock(mutex_);
  return live_.true_pose(seconds_());
}

RobotReport RigBench::robot() const {
  const std::lock_guard lock(mutex_);
  return live_.robot(seconds_());
}

}  // namespace sixdial::mock_devices
