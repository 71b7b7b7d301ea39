// Mistake dials nobody told about, and comparing a rig file with what answers.
#include "acquisition/rig_scan.h"

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <functional>

#include "acquisition/dial_protocol.h"
#include "acquisition/serial_port.h"
#include "mock_devices/mock_rig.h"
#include "tests/acquisition/wire.h"

namespace sixdial::acquisition {
namespace {

using test::PtyDevice;
using test::TemporaryFolder;
using testing::HasSubstr;
using testing::IsEmpty;

class RigScan : public testing::Test {
 protected:
  /// Scans as a person does: again, if what is there did not answer in the scan's short time,
  /// which a machine busy with other things may cause.
  ScannedPlace scan_until(
      const std::string& device, const std::function<bool(const ScannedPlace&)>& seen) {
    ScannedPlace place;
    (void)test::eventually([&] {
      place = scan_serial(device, clock_, {});
      return seen(place);
    });
    return place;
  }
  TemporaryFolder folder_;
  SystemClock clock_;
};

TEST_F(RigScan, NamesPortsByWhatStaysTheSame) {
  PtyDevice dial("\r", [](const std::string&) { return std::string(); });
  std::filesystem::create_directory(folder_.path("by-id"));
  const std::string link = folder_.path("by-id") + "/usb-Sylvac_dial_1001-if00";
  std::filesystem::create_symlink(dial.path(), link);
  std::filesystem::create_symlink(folder_.path("gone"), folder_.path("by-id") + "/usb-gone");
  const auto ports = serial_ports(folder_.path("by-id"));
  const auto found = std::ranges::find(ports, link, &PortName::name);
  ASSERT_NE(found, ports.end());
  EXPECT_EQ(found->device, dial.path());
  EXPECT_EQ(found->about, "usb-Sylvac_dial_1001-if00");
  EXPECT_EQ(std::ranges::count(ports, dial.path(), &PortName::device), 1)
      << "under one name only";
}

TEST_F(RigScan, FindsEveryDialectOnItsCable) {
  mock_devices::MockRigOptions options;
  options.pty_directory = folder_.path("ptys");
  options.dialects = {"sylvac", "mahr", "mux10", "mw", "modbus_rtu"};
  options.clock_speed = 20;
  mock_devices::MockRig mock(options);
  mock.start();
  const auto ports = mock.ports();
  struct Expected {
    std::string line, dialect;
    std::size_t dials;
  };
  for (const Expected& each : std::vector<Expected>{
           {"sylvac_B", "dialect=sylvac", 1},
           {"mahr_C", "dialect=mahr", 1},
           {"mux10", "dialect=mux10&channel=6", 6},
           {"mw", "dialect=mw&channel=6", 6},
           {"modbus_rtu", "modbus-rtu:", 6}}) {
    const std::string device = ports.serial.at(each.line).string();
    const ScannedPlace place =
        scan_until(device, [&](const auto& seen) { return seen.dials.size() == each.dials; });
    ASSERT_EQ(place.dials.size(), each.dials) << each.line << ": " << place.trouble;
    EXPECT_THAT(place.dials.back().connection, HasSubstr(each.dialect));
    EXPECT_THAT(place.dials.back().connection, HasSubstr(device));
    for (const FoundDial& dial : place.dials) {
      EXPECT_TRUE(dial.reading.value_mm) << each.line << " " << dial.reading.reason;
    }
  }
  const ScannedPlace box = scan_gauge_box(fmt::format("127.0.0.1:{}", ports.dials), clock_, {});
  ASSERT_EQ(box.dials.size(), 6U) << box.trouble;
  EXPECT_TRUE(box.dials[5].reading.value_mm);
}

TEST_F(RigScan, SaysWhatToDoWhereNothingIsFound) {
  PtyDevice silent("\r", [](const std::string&) { return std::string(); });
  const ScannedPlace quiet = scan_serial(silent.path(), clock_, {});
  EXPECT_THAT(quiet.dials, IsEmpty());
  EXPECT_EQ(quiet.trouble, "silent");
  EXPECT_THAT(quiet.fix, HasSubstr("switched on"));

  PtyDevice stranger("\r", [](const std::string&) { return std::string("hello?\r"); });
  const auto heard = [](const ScannedPlace& place) { return place.trouble != "silent"; };
  EXPECT_THAT(scan_until(stranger.path(), heard).trouble, HasSubstr("no dialect"));

  PtyDevice empty("\r", [](const std::string&) { return std::string("911\r"); });
  const ScannedPlace mux = scan_until(empty.path(), [](const ScannedPlace& place) {
    return place.trouble.find("mux10") != std::string::npos;
  });
  EXPECT_THAT(mux.trouble, HasSubstr("mux10"));
  EXPECT_THAT(mux.fix, HasSubstr("plug the dial"));

  const ScannedPlace gone = scan_serial(folder_.path("gone"), clock_, {});
  EXPECT_THAT(gone.trouble, HasSubstr("No such file"));
  EXPECT_FALSE(gone.fix.empty());

  const auto held = SerialPort::open(silent.path(), find_dial_protocol("sylvac")->line);
  ASSERT_TRUE(held);
  const ScannedPlace taken = scan_serial(silent.path(), clock_, {});
  EXPECT_THAT(taken.trouble, HasSubstr("in use"));
  EXPECT_THAT(taken.fix, HasSubstr("end what uses it"));

  const ScannedPlace nobody = scan_gauge_box("127.0.0.1:1", clock_, {});
  EXPECT_THAT(nobody.dials, IsEmpty());
  EXPECT_THAT(nobody.fix, HasSubstr("gauge box"));
}

TEST_F(RigScan, ChecksARigFileAgainstWhatAnswersLineByLine) {
  mock_devices::MockRigOptions options;
  options.pty_directory = folder_.path("ptys");
  options.dialects = {"sylvac"};
  options.world.robot.parameters = geometry::table_2_robot();
  mock_devices::MockRig mock(options);
  mock.start();
  geometry::Rig rig = mock.connected_rig("sylvac");
  CheckedRig well;
  EXPECT_TRUE(test::eventually([&] {
    well = check_rig(rig, {}, clock_, {});
    return well.good();
  })) << well.robot_trouble;
  ASSERT_EQ(well.dials.size(), 6U);
  EXPECT_TRUE(well.robot.has_value());

  // C's line is wrong; its dial answers somewhere that no line names.
  const std::string right = rig.dials[2].connection;
  const std::string device = mock.ports().serial.at("sylvac_C").string();
  rig.dials[2].connection = "serial:" + folder_.path("elsewhere") + "?dialect=sylvac";
  const std::vector<ScannedPlace> found{
      scan_until(device, [](const ScannedPlace& place) { return !place.dials.empty(); })};
  ASSERT_EQ(found[0].dials.size(), 1U);
  CheckedRig wrong;
  EXPECT_TRUE(test::eventually([&] {
    wrong = check_rig(rig, found, clock_, {});
    return wrong.dials[1].good;
  }));
  EXPECT_FALSE(wrong.good());
  EXPECT_TRUE(wrong.dials[1].good) << wrong.dials[1].trouble;
  EXPECT_FALSE(wrong.dials[2].good);
  EXPECT_THAT(wrong.dials[2].trouble, HasSubstr("disconnected"));
  EXPECT_THAT(wrong.dials[2].fix, HasSubstr(right));

  // A robot that is not there.
  rig.robot.connection = "modbus-tcp://127.0.0.1:1";
  const CheckedRig alone = check_rig(rig, {}, clock_, {});
  EXPECT_FALSE(alone.robot_trouble.empty());
  EXPECT_THAT(alone.robot_fix, HasSubstr("controller"));

  rig.dials[0].connection = "serial:here";
  EXPECT_THAT(check_rig(rig, {}, clock_, {}).trouble, HasSubstr("dial A"));
}

TEST_F(RigScan, HasAdviceForEveryReason) {
  for (const char* reason :
       {"timeout", "disconnected", "parse", "channel", "range", "unit", "device", "no dial",
        "busy", "identity", "stale", "implausible", "low battery", "frozen", "no contact"}) {
    EXPECT_THAT(advice_for(reason), testing::Not(HasSubstr("look at the dial and its cable")))
        << reason;
    EXPECT_FALSE(advice_for(reason).empty());
  }
}

}  // namespace
}  // namespace sixdial::acquisition
