// A whole small session through real bytes: controller and gauge box on Modbus TCP, one dial on
// a serial line, on an accelerated clock.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <atomic>
#include <cmath>

#include "acquisition/collector.h"
#include "acquisition/dial_bank.h"
#include "acquisition/robots/modbus_robot.h"
#include "tests/acquisition/controller.h"
#include "tests/acquisition/wire.h"

namespace sixdial::acquisition {
namespace {

using session::Quality;

constexpr double kDial_mm = 0.0011;  // rounded to 0.001 on the wire, angles to 10 nrad

TEST(CollectOverTheWire, GivesTheReadingsOfEachPose) {
  geometry::Rig rig = geometry::default_rig();
  const Plausibility nominal(rig, 5.0);
  test::Controller controller;
  test::ModbusTable gauges;
  std::array<std::atomic<int>, 6> shown_um{};
  for (int k = 0; k < 7; ++k) gauges.input[100 + k] = 0;
  gauges.before_read = [&](int) {
    ++gauges.input[106];
    for (int k = 0; k < 5; ++k) {
      test::put_int32(gauges.input, 2 * k, shown_um[static_cast<std::size_t>(k)]);
    }
  };
  controller.on_arrival = [&] {
    const auto& words = controller.table.input;
    const auto angle = [&](int at) {
      const auto bits = static_cast<std::uint32_t>(words.at(at)) << 16 | words.at(at + 1);
      return static_cast<double>(static_cast<std::int32_t>(bits)) * 1e-8;
    };
    const auto expected = nominal.expected_at(Eigen::Vector2d(angle(0), angle(2)));
    for (std::size_t k = 0; k < 6; ++k) {
      shown_um[k] = static_cast<int>(std::lround(*expected[k].displacement_mm * 1000));
    }
  };
  test::ModbusTcpServer robot_server(controller.table);
  test::ModbusTcpServer gauge_server(gauges);
  test::PtyDevice dial("\r", [&](const std::string& request) {
    return request == "?\r" ? fmt::format("+{:07.3f}\r", shown_um[5] * 1e-3) : "ERR1\r";
  });
  for (std::size_t k = 0; k < 5; ++k) {
    rig.dials[k].connection = fmt::format("modbus-tcp://127.0.0.1:{}", gauge_server.port());
  }
  rig.dials[5].connection = fmt::format("serial:{}?dialect=sylvac", dial.path());

  session::Plan plan;
  for (int i = 0; i < 8; ++i) {
    session::PlanPoint point;
    point.set = "G1";
    point.point = i;
    point.target_mm = Eigen::Vector2d(20.0 + 2 * i, 60.0 - 3 * i);
    point.q =
        geometry::inverse(rig.robot.nominal, point.target_mm, rig.robot.working_mode).value();
    point.approach = {1, i % 2 == 0 ? 1 : -1};
    plan.points.push_back(point);
  }

  AcceleratedClock clock(
      20.0, session::TimePoint{std::chrono::milliseconds{1'700'000'000'000}});
  const auto connection =
      parse_modbus_robot(fmt::format("modbus-tcp://127.0.0.1:{}", robot_server.port()));
  ModbusRobot robot(connection.value(), clock);
  const auto bank = DialBank::open(rig, clock);
  ASSERT_TRUE(bank) << bank.error();
  std::vector<CollectedSample> stored;
  Collector::Callbacks callbacks;
  callbacks.store = [&](const CollectedSample& sample) { stored.push_back(sample); };
  // Bytes are looked at here and not patience, which a busy machine may wear out.
  CollectorSettings patient;
  patient.fault_retries = patient.robot_retries = 100;
  patient.settle_timeout = std::chrono::hours(1);
  Collector collector(rig, plan, robot, **bank, clock, callbacks, patient);
  const auto result = collector.run({});
  EXPECT_TRUE(result.complete);
  ASSERT_EQ(stored.size(), plan.points.size());
  for (std::size_t i = 0; i < stored.size(); ++i) {
    const session::Sample& sample = stored[i].sample;
    const auto expected = nominal.expected_at(plan.points[i].q);
    for (std::size_t k = 0; k < 6; ++k) {
      ASSERT_TRUE(sample.channels[k].value)
          << i << " " << k << " " << sample.channels[k].reason;
      EXPECT_EQ(sample.channels[k].quality, Quality::kGood) << sample.channels[k].reason;
      EXPECT_NEAR(*sample.channels[k].value, *expected[k].displacement_mm, kDial_mm);
    }
    EXPECT_EQ(sample.approach[1], plan.points[i].approach[1]);
    EXPECT_EQ(sample.temperature_c, -1.25);
  }
}

}  // namespace
}  // namespace sixdial::acquisition
