// The whole mock over its cables: raw bytes in, raw bytes out, by no code of the drivers.
#include "mock_devices/mock_rig.h"

#include <gtest/gtest.h>

#include <atomic>
#include <cstdio>

#include "mock_devices/iso_time.h"
#include "tests/mock_devices/raw_port.h"

namespace sixdial::mock_devices {
namespace {

TEST_F(MockRigTest, CommandingTheRobotOverRawBytesMovesTheDialsAsTheTrueRobotMoves) {
  MockRig rig(options());
  rig.start();
  Port robot(Port::tcp(rig.ports().robot));
  Port dials(Port::tcp(rig.ports().dials));
  EXPECT_EQ(robot_input(robot, 4), 0);  // idle: never moved
  std::vector<double> before;
  for (const Vector2d& target : {Vector2d(22, 40), Vector2d(34, 58), Vector2d(28, 48)}) {
    robot.send(start_request(angles(rig, target)));
    EXPECT_EQ(robot.bytes(12), (Bytes{0, 9, 0, 0, 0, 6, 1, 0x10, 0, 0, 0, 6}));
    ASSERT_TRUE(eventually([&] { return robot_input(robot, 4) == 2; }));
    const double arrived_s = rig.seconds();
    ASSERT_TRUE(eventually([&] { return rig.seconds() > arrived_s + 2.0; }));
    const std::vector<double> now = read_six(dials);
    const TruePose pose = rig.true_pose();
    ASSERT_EQ(now.size(), 6U);
    for (std::size_t i = 0; i < 6; ++i) {
      if (!pose.pushes[i]) continue;
      EXPECT_NEAR(now[i], pose.pushes[i]->displacement_mm, kNoise_mm);
      if (!before.empty()) {
        EXPECT_GT(std::abs(now[i] - before[i]), 1.0);
      }
    }
    before = now;
  }
  EXPECT_EQ(robot_input(robot, 5), 3);  // moves started
  EXPECT_NEAR(robot_input(robot, 6) / 100.0, rig.world().warm_up.start_c, 3.01);
}

TEST_F(MockRigTest, AnUnreachableTargetIsRefusedAndTheNextGoodOneClearsTheFault) {
  MockRig rig(options());
  rig.start();
  Port robot(Port::tcp(rig.ports().robot));
  robot.send(start_request({3.0, 0.0}));
  EXPECT_EQ(robot.bytes(12).size(), 12U);
  EXPECT_EQ(robot_input(robot, 4), 3);
  EXPECT_EQ(robot_input(robot, 7), 1);
  EXPECT_EQ(robot_input(robot, 5), 0);
  robot.send(start_request(angles(rig, {30, 50})));
  EXPECT_EQ(robot.bytes(12).size(), 12U);
  ASSERT_TRUE(eventually([&] { return robot_input(robot, 4) == 2; }));
  EXPECT_EQ(robot_input(robot, 7), 0);
}

TEST_F(MockRigTest, AllConnectionsShowTheSameDials) {
  MockRig rig(options());
  rig.start();
  const MockPorts ports = rig.ports();
  ASSERT_EQ(ports.serial.size(), 1 + 6 + 6 + 1 + 1U);
  Port tcp(Port::tcp(ports.dials));
  const std::vector<double> by_tcp = read_six(tcp);
  Port mux(Port::serial(ports.serial.at("mux10")));
  Port mw(Port::serial(ports.serial.at("mw")));
  for (std::size_t i = 0; i < 6; ++i) {
    const std::string id = rig.world().rig.dials[i].id;
    const auto number = [&](std::string text) {
      const std::size_t sign = text.find_first_of("+-");
      return sign == std::string::npos ? -999.0 : std::stod(text.substr(sign));
    };
    Port sylvac(Port::serial(ports.serial.at("sylvac_" + id)));
    sylvac.send("?\r");
    EXPECT_NEAR(number(sylvac.line()), by_tcp[i], kNoise_mm);
    Port mahr(Port::serial(ports.serial.at("mahr_" + id)));
    mahr.send("?\r");
    EXPECT_NEAR(number(mahr.line()), by_tcp[i], kNoise_mm);
    mux.send(std::to_string(i + 1) + "\r");
    const std::string reply = mux.line();
    EXPECT_EQ(reply.size(), 13U) << reply;
    EXPECT_NEAR(number(reply), by_tcp[i], kNoise_mm);
    mw.send("C" + std::to_string(i + 1) + "\r\n");
    const std::string shown =
        mw.read_until([](const std::string& got) { return got.ends_with("\r\n"); });
    EXPECT_NEAR(number(shown), by_tcp[i], kNoise_mm);
  }
  Port rtu(Port::serial(ports.serial.at("modbus_rtu")));
  rtu.send(Bytes{0x01, 0x04, 0x00, 0x00, 0x00, 0x0C, 0xF0, 0x0F});
  const Bytes frame = rtu.bytes(29);
  ASSERT_EQ(frame.size(), 29U);
  EXPECT_EQ(crc16(frame), 0);
}

TEST_F(MockRigTest, MbpollReadsTheMock) {
  MockRig rig(options());
  rig.start();
  const std::string command = std::string(SIXDIAL_MBPOLL) + " -m tcp -p " +
                              std::to_string(rig.ports().dials) +
                              " -a 1 -0 -r 0 -c 6 -t 3:int -B -1 127.0.0.1 2>&1";
  std::FILE* pipe = ::popen(command.c_str(), "r");
  ASSERT_NE(pipe, nullptr);
  std::string output;
  std::array<char, 256> chunk{};
  while (const std::size_t n = std::fread(chunk.data(), 1, chunk.size(), pipe)) {
    output.append(chunk.data(), n);
  }
  EXPECT_EQ(::pclose(pipe), 0) << output;
  const TruePose pose = rig.true_pose();
  for (std::size_t i = 0; i < 6; ++i) {
    const std::string mark = "[" + std::to_string(2 * i) + "]:";
    const std::size_t at = output.find(mark);
    ASSERT_NE(at, std::string::npos) << output;
    const double micrometres = std::stod(output.substr(at + mark.size()));
    EXPECT_NEAR(micrometres / 1000.0, pose.pushes[i]->displacement_mm, kNoise_mm);
  }
}

TEST_F(MockRigTest, RefusesForeignUnitsFunctionsAndAddressesAndGarbageEndsTheConnection) {
  MockRig rig(options());
  rig.start();
  Port dials(Port::tcp(rig.ports().dials));
  dials.send(Bytes{0, 5, 0, 0, 0, 6, 9, 4, 0, 0, 0, 12});
  EXPECT_EQ(dials.bytes(9), (Bytes{0, 5, 0, 0, 0, 3, 9, 0x84, 11}));
  dials.send(Bytes{0, 6, 0, 0, 0, 6, 1, 4, 0xEA, 0x60, 0, 2});
  EXPECT_EQ(dials.bytes(9), (Bytes{0, 6, 0, 0, 0, 3, 1, 0x84, 2}));
  dials.send(Bytes{0, 7, 0, 0, 0, 2, 1, 0x2B});
  EXPECT_EQ(dials.bytes(9), (Bytes{0, 7, 0, 0, 0, 3, 1, 0xAB, 1}));
  dials.send(std::string("GET / HTTP/1.1\r\n"));
  dials.nothing();
  EXPECT_TRUE(dials.ended);
  Port again(Port::tcp(rig.ports().dials));
  EXPECT_EQ(read_six(again).size(), 6U);
}

TEST_F(MockRigTest, RequestsInPiecesAndInOneGoAreAnsweredInOrder) {
  MockRig rig(options());
  rig.start();
  Port dials(Port::tcp(rig.ports().dials));
  Bytes two = kReadSix;
  two.insert(two.end(), kReadSix.begin(), kReadSix.end());
  two[13] = 2;
  dials.send(Bytes(two.begin(), two.begin() + 5));
  EXPECT_EQ(dials.nothing(), "");
  dials.send(Bytes(two.begin() + 5, two.end()));
  const Bytes replies = dials.bytes(66);
  ASSERT_EQ(replies.size(), 66U);
  EXPECT_EQ(replies[1], 1);
  EXPECT_EQ(replies[34], 2);
}

TEST_F(MockRigTest, ASerialRequestInPiecesIsOneRequest) {
  MockRig rig(options());
  rig.start();
  Port sylvac(Port::serial(rig.ports().serial.at("sylvac_B")));
  sylvac.send("BA");
  EXPECT_EQ(sylvac.nothing(), "");
  sylvac.send("T?\r");
  EXPECT_EQ(sylvac.line(), "BAT1\r");
}

TEST_F(MockRigTest, ServesManyClientsAtOnceWhileTheRobotMoves) {
  MockRig rig(options());
  rig.start();
  std::atomic<int> answered{0};
  std::vector<std::thread> clients;
  for (int c = 0; c < 6; ++c) {
    clients.emplace_back([&] {
      Port dials(Port::tcp(rig.ports().dials));
      for (int n = 0; n < 50; ++n) answered += read_six(dials).size() == 6 ? 1 : 0;
    });
  }
  Port robot(Port::tcp(rig.ports().robot));
  for (const double x : {20.0, 35.0, 25.0}) {
    robot.send(start_request(angles(rig, {x, 45})));
    EXPECT_EQ(robot.bytes(12).size(), 12U);
    static_cast<void>(rig.true_pose());
  }
  for (std::thread& client : clients) client.join();
  EXPECT_EQ(answered, 300);
}

TEST_F(MockRigTest, MockTimeRunsAtItsSpeedFromItsStart) {
  MockRigOptions fast = options(200.0);
  fast.start_time = "2026-03-02T08:30:00.000Z";
  MockRig rig(fast);
  const auto wall = Clock::now();
  const double start_s = rig.seconds();
  ASSERT_TRUE(eventually([&] { return Clock::now() - wall > std::chrono::milliseconds(100); }));
  const double mock_s = rig.seconds() - start_s;
  const std::chrono::duration<double> passed = Clock::now() - wall;
  EXPECT_GE(mock_s, 200.0 * 0.1);
  EXPECT_LE(mock_s, 200.0 * passed.count() + 1.0);
  EXPECT_GE(rig.utc_ms(), milliseconds_of(fast.start_time) + 20'000);
}

TEST_F(MockRigTest, ASerialReplyTakesItsTimeOnTheLine) {
  MockRig rig(options(1.0));
  rig.start();
  Port sylvac(Port::serial(rig.ports().serial.at("sylvac_A")));
  const auto start = Clock::now();
  sylvac.send("?\r");
  EXPECT_EQ(sylvac.line().size(), 9U);
  const std::chrono::duration<double> took = Clock::now() - start;
  // 60 ms to think and nine characters of 11 bits at 4800 baud: 80.6 ms, and never less.
  EXPECT_GE(took.count(), 0.080);
}

TEST_F(MockRigTest, LinksAreStableAndGoAwayAtTheEnd) {
  MockRig rig(options());
  rig.start();
  const auto link = rig.ports().serial.at("sylvac_A");
  EXPECT_EQ(link, folder_ / "sylvac_A");
  EXPECT_TRUE(std::filesystem::is_symlink(link));
  {
    Port first(Port::serial(link));
    first.send("?\r");
    EXPECT_EQ(first.line().size(), 9U);
  }
  Port second(Port::serial(link));  // a client comes back to the same line
  second.send("?\r");
  EXPECT_EQ(second.line().size(), 9U);
  rig.stop();
  EXPECT_FALSE(std::filesystem::exists(std::filesystem::symlink_status(link)));
  EXPECT_THROW(static_cast<void>(rig.ports()), std::logic_error);
  rig.start();
  EXPECT_TRUE(std::filesystem::is_symlink(link));
}

TEST_F(MockRigTest, ATakenPortIsSaidWithItsNumber) {
  MockRig rig(options());
  rig.start();
  MockRigOptions same = options();
  same.pty_directory.clear();
  same.dial_port = rig.ports().dials;
  MockRig other(same);
  try {
    other.start();
    FAIL() << "two listeners on one port";
  } catch (const std::system_error& error) {
    EXPECT_NE(
        std::string(error.what()).find(std::to_string(rig.ports().dials)), std::string::npos);
  }
}

TEST_F(MockRigTest, ConnectionStringsNameEveryPort) {
  MockRig rig(options());
  rig.start();
  const MockPorts ports = rig.ports();
  const geometry::Rig tcp = rig.connected_rig("modbus-tcp");
  EXPECT_EQ(
      tcp.dials[3].connection,
      "modbus-tcp://127.0.0.1:" + std::to_string(ports.dials) + "?unit=1");
  EXPECT_EQ(
      tcp.robot.connection,
      "modbus-tcp://127.0.0.1:" + std::to_string(ports.robot) + "?unit=1");
  EXPECT_EQ(
      rig.connected_rig("mux10").dials[2].connection,
      "serial:" + (folder_ / "mux10").string() + "?dialect=mux10&channel=3");
  EXPECT_EQ(
      rig.connected_rig("sylvac").dials[2].connection,
      "serial:" + (folder_ / "sylvac_C").string() + "?dialect=sylvac");
  EXPECT_THROW(static_cast<void>(rig.connected_rig("pigeon")), std::invalid_argument);
}

}  // namespace
}  // namespace sixdial::mock_devices
