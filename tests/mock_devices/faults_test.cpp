// Every fault that can be ordered, as it looks at the other end of the cable.
#include "mock_devices/faults.h"

#include <gtest/gtest.h>

#include <set>

#include "mock_devices/mock_rig.h"
#include "tests/mock_devices/raw_port.h"

namespace sixdial::mock_devices {
namespace {

TEST(FaultBook, CountsRepliesAndKeepsConnectionsApart) {
  FaultBook book;
  book.order(2, {.fault = Fault::kSilent, .count = 2, .connection = "mux10"});
  EXPECT_FALSE(book.take(1, Fault::kSilent, "mux10"));
  EXPECT_FALSE(book.take(2, Fault::kLate, "mux10"));
  EXPECT_FALSE(book.take(2, Fault::kSilent, "sylvac"));
  EXPECT_TRUE(book.peek(2, Fault::kSilent, "mux10"));
  EXPECT_TRUE(book.take(2, Fault::kSilent, "mux10"));
  EXPECT_TRUE(book.take(2, Fault::kSilent, "mux10"));
  EXPECT_FALSE(book.take(2, Fault::kSilent, "mux10"));
}

TEST(FaultBook, LastsForItsTimeOrUntilCleared) {
  FaultBook book;
  book.order(0, {.fault = Fault::kFrozen, .count = 0});
  book.order(1, {.fault = Fault::kFrozen, .count = 0, .duration_s = 1e-6});
  ASSERT_TRUE(eventually([&] { return !book.peek(1, Fault::kFrozen, ""); }));
  for (int i = 0; i < 100; ++i) EXPECT_TRUE(book.take(0, Fault::kFrozen, ""));
  book.clear();
  EXPECT_FALSE(book.take(0, Fault::kFrozen, ""));
}

TEST(FaultBook, EveryFaultHasANameOfItsOwn) {
  std::set<std::string_view> names;
  for (const FaultName& each : fault_names()) {
    names.insert(each.name);
    EXPECT_EQ(fault_from(each.name), each.fault);
    EXPECT_EQ(to_string(each.fault), each.name);
  }
  EXPECT_EQ(names.size(), 18U);
  EXPECT_EQ(fault_from("gremlins"), std::nullopt);
}

class Faults : public MockRigTest {
 protected:
  Faults() : rig_(options()) { rig_.start(); }
  [[nodiscard]] std::filesystem::path path(const std::string& name) const {
    return rig_.ports().serial.at(name);
  }
  static std::string ask(Port& port, const std::string& request = "?\r") {
    port.send(request);
    return port.line();
  }
  MockRig rig_;
};

TEST_F(Faults, SilentGivesNoReplyAndTheNextOneAsUsual) {
  Port sylvac(Port::serial(path("sylvac_B")));
  rig_.order_fault("B", {.fault = Fault::kSilent});
  sylvac.send("?\r");
  EXPECT_EQ(sylvac.nothing(), "");
  EXPECT_EQ(ask(sylvac).size(), 9U);
}

TEST_F(Faults, LateComesAfterItsDelayAndNotBefore) {
  Port mux(Port::serial(path("mux10")));
  rig_.order_fault("C", {.fault = Fault::kLate, .amount = 0.25});
  const auto start = Clock::now();
  EXPECT_EQ(ask(mux, "3\r").substr(0, 3), "03A");
  EXPECT_GE(Clock::now() - start, std::chrono::milliseconds(250));
}

TEST_F(Faults, ALateModbusReplyHoldsUpTheOnesBehindIt) {
  Port dials(Port::tcp(rig_.ports().dials));
  rig_.order_fault("C", {.fault = Fault::kLate, .amount = 0.25});
  const auto start = Clock::now();
  dials.send(kReadSix);
  dials.send(kReadSix);
  EXPECT_EQ(dials.bytes(66).size(), 66U);
  EXPECT_GE(Clock::now() - start, std::chrono::milliseconds(250));
}

TEST_F(Faults, TruncatedLacksItsEnd) {
  Port mux(Port::serial(path("mux10")));
  rig_.order_fault("A", {.fault = Fault::kTruncated, .connection = "mux10"});
  mux.send("1\r");
  std::string got = mux.read_until([](const std::string& s) { return s.size() >= 9; });
  got += mux.read_until([](const std::string& s) { return !s.empty(); }, kSilence_ms);
  EXPECT_EQ(got.size(), 9U);
  EXPECT_EQ(ask(mux, "1\r").size(), 13U);
}

TEST_F(Faults, AStrayLineFeedFollowsTheReply) {
  Port sylvac(Port::serial(path("sylvac_A")));
  rig_.order_fault("A", {.fault = Fault::kStrayLf});
  sylvac.send("?\r");
  const std::string got =
      sylvac.read_until([](const std::string& s) { return s.ends_with('\n'); });
  EXPECT_EQ(got.size(), 10U);
  EXPECT_TRUE(got.ends_with("\r\n"));
}

TEST_F(Faults, ErrorBusyAndWrongChannelSpeakTheDialect) {
  Port mux(Port::serial(path("mux10")));
  rig_.order_fault("D", {.fault = Fault::kErrorLine, .amount = 1.0});
  EXPECT_EQ(ask(mux, "4\r"), "911\r");
  rig_.order_fault("D", {.fault = Fault::kBusy});
  EXPECT_EQ(ask(mux, "4\r"), "918\r");
  rig_.order_fault("D", {.fault = Fault::kWrongChannel});
  EXPECT_EQ(ask(mux, "4\r").substr(0, 3), "05A");
  Port sylvac(Port::serial(path("sylvac_A")));
  const TruePose pose = rig_.true_pose();
  rig_.order_fault("A", {.fault = Fault::kWrongChannel});
  EXPECT_NEAR(std::stod(ask(sylvac)), pose.pushes[1]->displacement_mm, kNoise_mm);
  EXPECT_NEAR(std::stod(ask(sylvac)), pose.pushes[0]->displacement_mm, kNoise_mm);
}

TEST_F(Faults, InchShowsTheSameLengthInInches) {
  Port mux(Port::serial(path("mux10")));
  rig_.order_fault("A", {.fault = Fault::kInch, .connection = "mux10"});
  const std::string reply = ask(mux, "1\r");
  EXPECT_EQ(reply.size(), 13U);
  EXPECT_NEAR(
      std::stod(reply.substr(3)) * 25.4, rig_.true_pose().pushes[0]->displacement_mm,
      kNoise_mm);
  EXPECT_EQ(reply.find('.'), 6U);  // five decimals tell
}

TEST_F(Faults, AFrozenDialHoldsItsValueWhileTheRobotMoves) {
  Port dials(Port::tcp(rig_.ports().dials));
  Port robot(Port::tcp(rig_.ports().robot));
  rig_.order_fault("B", {.fault = Fault::kFrozen, .count = 0});
  const std::vector<double> before = read_six(dials);
  robot.send(start_request(angles(rig_, {20, 40})));
  ASSERT_EQ(robot.bytes(12).size(), 12U);
  ASSERT_TRUE(eventually([&] { return robot_input(robot, 4) == 2; }));
  const double arrived_s = rig_.seconds();
  ASSERT_TRUE(eventually([&] { return rig_.seconds() > arrived_s + 2.0; }));
  const std::vector<double> after = read_six(dials);
  EXPECT_EQ(after[1], before[1]);
  EXPECT_GT(std::abs(after[0] - before[0]), 1.0);
  rig_.clear_faults();
  EXPECT_GT(std::abs(read_six(dials)[1] - before[1]), 1.0);
}

TEST_F(Faults, AKeyPressSendsALineUnaskedAndHolds) {
  Port sylvac(Port::serial(path("sylvac_E")));
  rig_.order_fault("E", {.fault = Fault::kUnsolicitedLine, .count = 0, .connection = "sylvac"});
  const std::string unasked = sylvac.line();
  EXPECT_EQ(unasked.size(), 9U);
  for (int i = 0; i < 5; ++i) EXPECT_EQ(ask(sylvac), unasked);
}

TEST_F(Faults, PowerOnSendsTheGreeting) {
  Port sylvac(Port::serial(path("sylvac_E")));
  rig_.order_fault("E", {.fault = Fault::kPowerOnLine, .connection = "sylvac"});
  EXPECT_EQ(sylvac.line().substr(0, 5), "SY280");
  EXPECT_EQ(ask(sylvac).size(), 9U);
}

TEST_F(Faults, LowBatteryIsToldByTheCableAndTheGaugeBox) {
  Port sylvac(Port::serial(path("sylvac_F")));
  rig_.order_fault("F", {.fault = Fault::kLowBattery, .count = 0});
  EXPECT_EQ(ask(sylvac, "BAT?\r"), "BAT0\r");
  Port dials(Port::tcp(rig_.ports().dials));
  dials.send(Bytes{0, 1, 0, 0, 0, 6, 1, 4, 0, 100, 0, 6});
  const Bytes reply = dials.bytes(21);
  ASSERT_EQ(reply.size(), 21U);
  EXPECT_EQ(reply[20], 2);
  EXPECT_EQ(reply[18], 0);
  rig_.clear_faults();
  EXPECT_EQ(ask(sylvac, "BAT?\r"), "BAT1\r");
}

TEST_F(Faults, ZeroPressedShiftsEveryLaterReading) {
  Port dials(Port::tcp(rig_.ports().dials));
  const double truth = rig_.true_pose().pushes[2]->displacement_mm;
  rig_.order_fault("C", {.fault = Fault::kZeroPressed});
  EXPECT_LT(std::abs(read_six(dials)[2]), kNoise_mm);
  rig_.clear_faults();
  EXPECT_NEAR(read_six(dials)[2], truth, kNoise_mm);
}

TEST_F(Faults, AHungUpLineEndsAndComesBackUnderItsName) {
  Port sylvac(Port::serial(path("sylvac_A")));
  EXPECT_EQ(ask(sylvac).size(), 9U);
  rig_.order_fault("A", {.fault = Fault::kHangUp, .amount = 0.1, .connection = "sylvac"});
  EXPECT_EQ(sylvac.read_until([](const std::string&) { return false; }), "");
  EXPECT_TRUE(sylvac.ended);
  ASSERT_TRUE(eventually([&] { return std::filesystem::exists(path("sylvac_A")); }));
  Port again(Port::serial(path("sylvac_A")));
  EXPECT_EQ(ask(again).size(), 9U);
}

TEST_F(Faults, AHungUpGaugeBoxClosesItsConnectionsAndTakesNewOnesLater) {
  Port dials(Port::tcp(rig_.ports().dials));
  Port robot(Port::tcp(rig_.ports().robot));
  EXPECT_EQ(read_six(dials).size(), 6U);
  rig_.order_fault("A", {.fault = Fault::kHangUp, .amount = 0.1, .connection = "modbus-tcp"});
  EXPECT_EQ(dials.read_until([](const std::string&) { return false; }), "");
  EXPECT_TRUE(dials.ended);
  EXPECT_EQ(robot_input(robot, 4), 0);  // another device, another cable
  EXPECT_TRUE(eventually([&] {
    Port again(Port::tcp(rig_.ports().dials));
    again.send_if_open(kReadSix);
    return again.bytes(33).size() == 33;
  }));
}

TEST_F(Faults, ANoiseByteChangesOneByteOfTheReply) {
  Port mw(Port::serial(path("mw")));
  rig_.order_fault("A", {.fault = Fault::kFrozen, .count = 0});
  mw.send("C1\r\n");
  const std::string good =
      mw.read_until([](const std::string& s) { return s.ends_with("\r\n"); });
  // A frozen dial's reply is as long each time; its bytes come one by one.
  const auto ask_mw = [&] {
    mw.send("C1\r\n");
    return mw.read_until([&](const std::string& s) { return s.size() >= good.size(); });
  };
  rig_.order_fault("A", {.fault = Fault::kNoiseByte});
  const std::string noisy = ask_mw();
  ASSERT_EQ(good.size(), noisy.size());
  int different = 0;
  for (std::size_t i = 0; i < good.size(); ++i) different += good[i] != noisy[i] ? 1 : 0;
  EXPECT_EQ(different, 1);
  EXPECT_EQ(ask_mw(), good);
}

TEST_F(Faults, ModbusFaultsDamageTheFrameOrSayAnException) {
  Port dials(Port::tcp(rig_.ports().dials));
  rig_.order_fault("A", {.fault = Fault::kException, .connection = "modbus-tcp"});
  dials.send(kReadSix);
  EXPECT_EQ(dials.bytes(9), (Bytes{0, 1, 0, 0, 0, 3, 1, 0x84, 4}));
  rig_.order_fault("B", {.fault = Fault::kBusy, .connection = "modbus-tcp"});
  dials.send(kReadSix);
  EXPECT_EQ(dials.bytes(9), (Bytes{0, 1, 0, 0, 0, 3, 1, 0x84, 6}));
  rig_.order_fault("C", {.fault = Fault::kWrongUnitId, .connection = "modbus-tcp"});
  dials.send(kReadSix);
  EXPECT_EQ(dials.bytes(33).at(6), 2);
  rig_.order_fault("D", {.fault = Fault::kCrcError, .connection = "modbus-tcp"});
  dials.send(kReadSix);
  EXPECT_EQ(dials.bytes(33).at(1), 2);  // another transaction number
  rig_.order_fault("E", {.fault = Fault::kErrorLine, .connection = "modbus-tcp"});
  dials.send(kReadSix);
  const Bytes invalid = dials.bytes(33);
  EXPECT_EQ(Bytes(invalid.begin() + 25, invalid.begin() + 29), (Bytes{0x80, 0, 0, 0}));
  Port rtu(Port::serial(path("modbus_rtu")));
  const Bytes request{0x01, 0x04, 0x00, 0x00, 0x00, 0x0C, 0xF0, 0x0F};
  rig_.order_fault("F", {.fault = Fault::kCrcError, .connection = "modbus_rtu"});
  rtu.send(request);
  EXPECT_NE(crc16(rtu.bytes(29)), 0);
  rtu.send(request);
  EXPECT_EQ(crc16(rtu.bytes(29)), 0);
}

TEST_F(Faults, AnUnknownDialIsRefused) {
  EXPECT_THROW(rig_.order_fault("G", {}), std::invalid_argument);
}

}  // namespace
}  // namespace sixdial::mock_devices
