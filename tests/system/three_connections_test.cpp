// The same pose read over Modbus TCP, over a mux10 multiplexer and over six sylvac cables.
#include <gtest/gtest.h>

#include <Eigen/Core>
#include <algorithm>
#include <filesystem>
#include <map>
#include <memory>
#include <string>
#include <variant>

#include "acquisition/clock.h"
#include "acquisition/connection.h"
#include "acquisition/dial_bank.h"
#include "acquisition/robots/modbus_robot.h"
#include "geometry/instruments/contact.h"
#include "geometry/robots/five_bar.h"
#include "mock_devices/mock_rig.h"
#include "mock_devices/session_generator.h"
#include "session/reason.h"
#include "session/session.h"
#include "tests/system/temporary_folder.h"

namespace sixdial {
namespace {

using Eigen::Vector2d;

constexpr double kSpeed = 20.0;
// Noise of a reading is 0.002 mm, of an active three's x or y up to 0.003 mm; six sigma of the
// difference of two.
constexpr double kSamePosition_mm = 0.026;

/// A dial whose answer a loaded machine has made late is asked again.
std::vector<acquisition::Reading> answered_scan(acquisition::DialBank& bank) {
  constexpr int kMostAgain = 20;
  std::vector<acquisition::Reading> scan = bank.scan({});
  const auto is_late = [](const acquisition::Reading& each) {
    return each.reason == session::reason::kTimeout;
  };
  for (int k = 0; k < kMostAgain && std::ranges::any_of(scan, is_late); ++k) {
    scan = bank.scan({});
  }
  return scan;
}

TEST(ThreeConnections, GiveTheSamePositionForTheSamePose) {
  const TemporaryFolder folder;
  mock_devices::MockRigOptions options;
  options.clock_speed = kSpeed;
  options.pty_directory = folder.path() / "ptys";
  options.dialects = {"mux10", "sylvac"};
  options.world.seed = 5;
  mock_devices::MockRig mock(options);
  mock.start();

  acquisition::AcceleratedClock clock(
      kSpeed, *session::from_iso8601("2026-03-02T08:30:00.000Z"));
  const geometry::Rig rig = mock.connected_rig("modbus-tcp");
  const auto connection = acquisition::parse_modbus_robot(rig.robot.connection);
  ASSERT_TRUE(connection) << connection.error();
  acquisition::ModbusRobot robot(*connection, clock);
  std::map<std::string, std::unique_ptr<acquisition::DialBank>> banks;
  for (const char* kind : {"modbus-tcp", "mux10", "sylvac"}) {
    auto bank = acquisition::DialBank::open(mock.connected_rig(kind), clock);
    ASSERT_TRUE(bank) << kind << ": " << bank.error();
    banks[kind] = std::move(*bank);
  }

  const auto reference = geometry::inverse(rig.robot.nominal, {28, 48}, {});
  int compared = 0;
  for (const Vector2d& target : {Vector2d(28, 48), Vector2d(22, 60), Vector2d(36, 38)}) {
    const auto q = geometry::inverse(rig.robot.nominal, target, {}, *reference);
    ASSERT_TRUE(q);
    const auto there = robot.move_to(*q, std::chrono::seconds(30), {});
    ASSERT_TRUE(there) << there.error().detail;
    clock.sleep_for(std::chrono::seconds(1), {});  // settles within 50 ms
    std::map<std::string, Vector2d> positions;
    for (const auto& [kind, bank] : banks) {
      std::vector<geometry::DialReading> readings;
      const auto scan = answered_scan(*bank);
      ASSERT_EQ(scan.size(), 6U);
      for (std::size_t i = 0; i < scan.size(); ++i) {
        ASSERT_NE(scan[i].quality, session::Quality::kBad)
            << kind << " dial " << rig.dials[i].id << ": " << scan[i].reason;
        if (scan[i].value_mm) readings.push_back({static_cast<int>(i), *scan[i].value_mm});
      }
      const auto pose = geometry::best_active_three(
          rig.dial_geometries(), readings, rig.cuboid.side_mm, mock.true_pose().gamma_rad);
      ASSERT_TRUE(pose) << kind << ": " << geometry::describe(pose.error());
      positions[kind] = pose->pose.p_WE;
    }
    for (const auto& [kind, position] : positions) {
      EXPECT_LT((position - positions.at("modbus-tcp")).norm(), kSamePosition_mm) << kind;
      // And it is where the robot really is, within the dials' own error of +-0.006 mm.
      EXPECT_LT((position - mock.true_pose().p_WE).norm(), 0.02) << kind;
      ++compared;
    }
  }
  EXPECT_EQ(compared, 9);
}

}  // namespace
}  // namespace sixdial
