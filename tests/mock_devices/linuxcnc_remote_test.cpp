// The mock machine that LinuxCNC moves, spoken to by hand.
#include "mock_devices/linuxcnc_remote.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace sixdial::mock_devices {
namespace {

using testing::HasSubstr;

class Session {
 public:
  explicit Session(LinuxCncMachine machine = {}) : remote(std::move(machine)) {
    remote.connected(1, 0.0);
  }
  std::string answer(const std::string& line, double time_s = 0.0) {
    remote.receive(1, line + "\n", time_s);
    return remote.due(1, time_s);
  }
  /// As far as an order.
  void enable() {
    EXPECT_EQ(answer("hello EMC user 1.0"), "HELLO ACK EMCNETSVR 1.1\r\n");
    EXPECT_EQ(answer("set echo off"), "set echo off\n");
    EXPECT_EQ(answer("set verbose on"), "SET VERBOSE ACK\r\n");
    EXPECT_EQ(answer("set enable EMCTOO"), "SET ENABLE ACK\r\n");
    EXPECT_EQ(answer("set mode mdi"), "SET MODE ACK\r\n");
  }
  LinuxCncRemote remote;
};

TEST(LinuxCncRemote, TheSessionOfItsManualPage) {
  Session session({.estop = true, .on = false});
  EXPECT_EQ(
      session.answer("hello EMC user-typing-at-telnet 1.0"), "HELLO ACK EMCNETSVR 1.1\r\n");
  for (const char* const line :
       {"set enable EMCTOO", "set mode manual", "set estop off", "set machine on",
        "set mode mdi"}) {
    const std::string echo = std::string(line) + "\n";
    const bool refused = std::string(line) == "set mode manual";  // it is off still
    EXPECT_EQ(session.answer(line), refused ? echo + "SET MODE NAK\r\n" : echo);
  }
  EXPECT_EQ(session.answer("set mdi g53 g1 f600 x10"), "set mdi g53 g1 f600 x10\n");
  EXPECT_EQ(session.remote.moves(), 1);
}

TEST(LinuxCncRemote, AMoveIsRunningUntilItEnds) {
  Session session;
  session.enable();
  EXPECT_EQ(session.answer("set mdi G21 G53 G1 X10 F600"), "SET MDI ACK\r\n");
  EXPECT_EQ(session.answer("get program_status"), "PROGRAM_STATUS IDLE\r\n")
      << "taken, and not begun";
  EXPECT_EQ(session.answer("get program_status", 0.5), "PROGRAM_STATUS RUNNING\r\n");
  EXPECT_THAT(session.answer("get joint_pos", 0.52), HasSubstr("JOINT_POS 5.000000 0.000000"));
  EXPECT_EQ(session.answer("get program_status", 1.1), "PROGRAM_STATUS IDLE\r\n");
  EXPECT_EQ(session.answer("get error", 1.1), "ERROR OK\r\n");
}

TEST(LinuxCncRemote, AnAbortStopsItAndAnErrorIsToldOnce) {
  Session session;
  session.enable();
  (void)session.answer("set mdi G21 G53 G1 X10 F600");
  EXPECT_EQ(session.answer("set abort", 0.52), "SET ABORT ACK\r\n");
  EXPECT_NEAR(session.remote.position(9.0)[0], 5.0, 1e-9);
  EXPECT_EQ(session.answer("set mdi G53 G1 X999 F600", 1.0), "SET MDI ACK\r\n");
  EXPECT_THAT(session.answer("get error", 1.0), HasSubstr("joint 0's positive limit"));
  EXPECT_EQ(session.answer("get error", 1.0), "ERROR OK\r\n");
}

TEST(LinuxCncRemote, WithoutControlNothingIsTaken) {
  Session session;
  EXPECT_EQ(session.answer("set mode mdi"), "SET NAK\r\n") << "before hello";
  EXPECT_EQ(session.answer("hello wrong user 1.0"), "HELLO NAK\r\n");
  session.enable();
  session.remote.take_control();
  EXPECT_EQ(session.answer("set mdi G1 X1 F600"), "SET MDI NAK\r\n");
  EXPECT_EQ(session.answer("get nothing"), "GET NOTHING NAK\r\n");
}

TEST(LinuxCncRemote, WithWaitModeDoneTheAnswerComesAtTheEnd) {
  Session session;
  session.enable();
  EXPECT_EQ(session.answer("set wait_mode done"), "SET WAIT_MODE ACK\r\n");
  EXPECT_EQ(session.answer("set mdi G21 G53 G1 X10 F600"), "");
  EXPECT_EQ(session.answer("get machine", 0.5), "") << "not heard before";
  EXPECT_EQ(session.remote.due(1, 1.1), "SET MDI ACK\r\nMACHINE ON\r\n");
}

}  // namespace
}  // namespace sixdial::mock_devices
