// The collector with another robot under another instrument: an arm of three joints under draw
// wires.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>

#include "acquisition/collector.h"
#include "session/live_channels.h"
#include "session/rig_file.h"

namespace sixdial::acquisition {
namespace {

constexpr const char* kRig = R"(name = "arm"
[robot]
model = "serial"
tool_x_mm = 50.0
[[joint]]
d_mm = 300.0
alpha_deg = 90.0
[[joint]]
a_mm = 250.0
[[joint]]
kind = "prismatic"
d_mm = 100.0
[instrument]
kind = "distance"
[[anchor]]
name = "K1"
[[anchor]]
name = "K2"
[dials]
travel_mm = 2500.0
resolution_mm = 0.01
repeatability_mm = 0.02
[[dial]]
id = "K1"
[[dial]]
id = "K2"
)";

class Arm final : public RobotPort {
 public:
  explicit Arm(Clock& clock) : clock_(clock) {}
  tl::expected<RobotState, RobotFault> state(const std::stop_token&) override { return now; }
  tl::expected<RobotState, RobotFault> move_to(
      const Eigen::VectorXd& q, std::chrono::milliseconds,
      const std::stop_token& stop) override {
    went.push_back(q);
    clock_.sleep_for(std::chrono::milliseconds(100), stop);
    now.q = q;
    now.motion = Motion::kInPosition;
    ++now.moves;
    return now;
  }
  RobotState now;
  std::vector<Eigen::VectorXd> went;

 private:
  Clock& clock_;
};

class Wires final : public DialSource {
 public:
  Wires(const Arm& arm, Clock& clock) : arm_(arm), clock_(clock) {}
  [[nodiscard]] std::size_t size() const override { return 2; }
  std::vector<Reading> read_since(DeviceTime, const std::stop_token& stop) override {
    const DeviceTime requested = clock_.monotonic();
    clock_.sleep_for(std::chrono::milliseconds(50), stop);
    std::vector<Reading> readings;
    for (int i = 0; i < 2; ++i) {
      readings.push_back(good_reading(
          500.0 + 100.0 * i + 10.0 * std::sin(arm_.now.q[0]), requested, clock_.now_utc()));
      readings.back().sequence = ++count_;
    }
    return readings;
  }
  [[nodiscard]] std::vector<Reading> latest() const override { return {}; }

 private:
  const Arm& arm_;
  Clock& clock_;
  std::uint64_t count_ = 0;
};

TEST(CollectArm, GoesToEachPointAndStoresWhatTheWiresRead) {
  const geometry::Rig rig = session::parse_rig(kRig, "rig.toml");
  FakeClock clock;
  Arm arm(clock);
  Wires wires(arm, clock);
  // It has moved since it was switched on: a branch would be asked for.
  ASSERT_TRUE(arm.move_to(Eigen::Vector3d(0, 0, 0), {}, {}));
  session::Plan plan;
  for (int i = 0; i < 5; ++i) {
    session::PlanPoint point;
    point.set = "G1";
    point.point = i;
    point.target_mm = Eigen::Vector3d(100, 200, 300);
    point.q = Eigen::Vector3d(0.2 * i, 0.1, 20.0 * i);
    point.approach = {1, 0, -1};
    plan.points.push_back(point);
  }
  std::vector<CollectedSample> stored;
  Collector collector(
      rig, plan, arm, wires, clock,
      {.store = [&](const CollectedSample& each) { stored.push_back(each); },
       .progress = {},
       .done = {}});
  const CollectorResult result = collector.run({});
  EXPECT_TRUE(result.complete);
  EXPECT_EQ(result.stored, 5u);
  ASSERT_EQ(stored.size(), 5u);
  EXPECT_TRUE(stored[2].remarks.empty()) << stored[2].remarks.front();
  EXPECT_EQ(stored[2].sample.q, plan.points[2].q);
  EXPECT_EQ(stored[2].sample.approach[0], 1);
  EXPECT_EQ(stored[2].sample.approach[2], -1);
  ASSERT_EQ(stored[2].sample.channels.size(), 2u);
  EXPECT_NEAR(*stored[2].sample.channels[1].value, 600.0 + 10.0 * std::sin(0.4), 1e-12);
  EXPECT_EQ(stored[2].sample.channels[1].quality, session::Quality::kGood);
  // From the asked side: a turning joint by an angle, a linear one by a millimetre.
  const Eigen::VectorXd& before = arm.went[1 + 2 * 2];
  EXPECT_NEAR(before[0], plan.points[2].q[0] - 0.01, 1e-12);
  EXPECT_NEAR(before[2], plan.points[2].q[2] + 1.0, 1e-12);
  const session::Sample seen = session::as_instrument(rig, stored[2].sample);
  EXPECT_EQ(seen.others[1], stored[2].sample.channels[1].value);
}

}  // namespace
}  // namespace sixdial::acquisition
