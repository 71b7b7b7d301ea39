// Modbus frames byte by byte, against the frames of spec 5 and of the protocol's specification.
#include "mock_devices/modbus_slave.h"

#include <gtest/gtest.h>

#include <map>

#include "mock_devices/random.h"
#include "mock_devices/registers.h"

namespace sixdial::mock_devices {
namespace {

/// Registers 0..9 hold 100..109 and can be written.
class TenRegisters final : public RegisterMap {
 public:
  std::optional<std::vector<std::uint16_t>> read(
      RegisterTable /*table*/, std::uint16_t address, std::uint16_t count) override {
    if (address + count > 10) return std::nullopt;
    return std::vector<std::uint16_t>(value.begin() + address, value.begin() + address + count);
  }
  std::optional<ModbusException> write(
      std::uint16_t address, std::span<const std::uint16_t> values) override {
    if (address + values.size() > 10) return ModbusException::kIllegalAddress;
    std::copy(values.begin(), values.end(), value.begin() + address);
    return std::nullopt;
  }
  std::vector<std::uint16_t> value{100, 101, 102, 103, 104, 105, 106, 107, 108, 109};
};

TEST(ModbusSlave, TakesTheLiteralTcpRequestOfTheSpec) {
  // TCP 00 01 00 00 00 06 01 04 00 00 00 0C
  Bytes buffer{0x00, 0x01, 0x00, 0x00, 0x00, 0x06, 0x01, 0x04, 0x00, 0x00, 0x00, 0x0C, 0x77};
  ModbusRequest request;
  ASSERT_EQ(take_tcp_request(buffer, request), Framing::kRequest);
  EXPECT_EQ(request.transaction, 1);
  EXPECT_EQ(request.unit, 1);
  EXPECT_EQ(request.pdu, (Bytes{0x04, 0x00, 0x00, 0x00, 0x0C}));
  EXPECT_EQ(request.address(), 0);
  EXPECT_EQ(request.count(), 12);
  EXPECT_EQ(buffer, Bytes{0x77});
}

TEST(ModbusSlave, TakesTheLiteralRtuRequestOfTheSpec) {
  // 01 04 00 00 00 0C F0 0F
  Bytes buffer{0x01, 0x04, 0x00, 0x00, 0x00, 0x0C, 0xF0, 0x0F};
  ModbusRequest request;
  ASSERT_EQ(take_rtu_request(buffer, request), Framing::kRequest);
  EXPECT_EQ(request.pdu, (Bytes{0x04, 0x00, 0x00, 0x00, 0x0C}));
  EXPECT_TRUE(buffer.empty());
  Bytes wrong{0x01, 0x04, 0x00, 0x00, 0x00, 0x0C, 0xF0, 0x0E};
  EXPECT_EQ(take_rtu_request(wrong, request), Framing::kBroken);
}

TEST(ModbusSlave, EveryShorterPieceOfARequestWaitsForMore) {
  const Bytes tcp{0x00, 0x01, 0x00, 0x00, 0x00, 0x06, 0x01, 0x04, 0x00, 0x00, 0x00, 0x0C};
  for (std::size_t n = 0; n < tcp.size(); ++n) {
    Bytes piece(tcp.begin(), tcp.begin() + static_cast<std::ptrdiff_t>(n));
    ModbusRequest request;
    EXPECT_EQ(take_tcp_request(piece, request), Framing::kNeedMore) << n;
    EXPECT_EQ(piece.size(), n);
  }
}

TEST(ModbusSlave, AForeignProtocolOrAnImpossibleLengthBreaksTheStream) {
  ModbusRequest request;
  Bytes http{'G', 'E', 'T', ' ', '/', ' ', 'H', 'T'};
  EXPECT_EQ(take_tcp_request(http, request), Framing::kBroken);
  Bytes length{0, 1, 0, 0, 0, 1, 1, 4};
  EXPECT_EQ(take_tcp_request(length, request), Framing::kBroken);
}

TEST(ModbusSlave, AnswersReadsAndWritesByteForByte) {
  TenRegisters registers;
  EXPECT_EQ(answer_pdu(Bytes{0x04, 0, 2, 0, 2}, registers), (Bytes{0x04, 4, 0, 102, 0, 103}));
  EXPECT_EQ(answer_pdu(Bytes{0x03, 0, 9, 0, 1}, registers), (Bytes{0x03, 2, 0, 109}));
  EXPECT_EQ(
      answer_pdu(Bytes{0x06, 0, 1, 0x12, 0x34}, registers), (Bytes{0x06, 0, 1, 0x12, 0x34}));
  EXPECT_EQ(registers.value[1], 0x1234);
  EXPECT_EQ(
      answer_pdu(Bytes{0x10, 0, 3, 0, 2, 4, 0xAB, 0xCD, 0, 1}, registers),
      (Bytes{0x10, 0, 3, 0, 2}));
  EXPECT_EQ(registers.value[3], 0xABCD);
  EXPECT_EQ(registers.value[4], 1);
}

TEST(ModbusSlave, RefusesWithTheRightException) {
  TenRegisters registers;
  EXPECT_EQ(answer_pdu(Bytes{0x04, 0, 9, 0, 2}, registers), (Bytes{0x84, 2}));
  EXPECT_EQ(answer_pdu(Bytes{0x04, 0, 0, 0, 0}, registers), (Bytes{0x84, 3}));
  EXPECT_EQ(answer_pdu(Bytes{0x04, 0, 0, 0, 126}, registers), (Bytes{0x84, 3}));
  EXPECT_EQ(answer_pdu(Bytes{0x04, 0, 0}, registers), (Bytes{0x84, 3}));
  EXPECT_EQ(answer_pdu(Bytes{0x2B, 0x0E}, registers), (Bytes{0xAB, 1}));
  EXPECT_EQ(answer_pdu(Bytes{0x10, 0, 3, 0, 2, 3, 1, 2, 3}, registers), (Bytes{0x90, 3}));
  EXPECT_EQ(answer_pdu(Bytes{0x06, 0, 10, 0, 1}, registers), (Bytes{0x86, 2}));
}

TEST(ModbusSlave, FramesRepliesForTcpAndRtu) {
  const Bytes pdu{0x04, 0x02, 0xFF, 0xFE};
  EXPECT_EQ(
      tcp_frame(0x1234, 1, pdu), (Bytes{0x12, 0x34, 0, 0, 0, 5, 1, 0x04, 0x02, 0xFF, 0xFE}));
  const Bytes rtu = rtu_frame(1, pdu);
  ASSERT_EQ(rtu.size(), 7U);
  EXPECT_EQ(crc16(rtu), 0);  // a frame with its CRC has CRC zero
}

TEST(ModbusSlave, SurvivesRandomBytes) {
  TenRegisters registers;
  const Random random(12, Stream::kNoiseByte);
  int answered = 0;
  for (std::uint64_t i = 0; i < 20'000; ++i) {
    Bytes bytes;
    const auto size = static_cast<std::size_t>(random.uniform(40 * i) * 30);
    for (std::size_t k = 0; k < size; ++k) {
      bytes.push_back(static_cast<std::uint8_t>(random.uniform(40 * i + 1 + k) * 256));
    }
    ModbusRequest request;
    Bytes tcp = bytes;
    static_cast<void>(take_tcp_request(tcp, request));
    Bytes rtu = bytes;
    static_cast<void>(take_rtu_request(rtu, request));
    if (!answer_pdu(bytes, registers).empty()) ++answered;
  }
  EXPECT_GT(answered, 15'000);
}

TEST(DialRegisters, HoldTheMapOfTheManual) {
  DialScan scan;
  for (int i = 0; i < 6; ++i) {
    scan.dials.push_back({.counts = (i + 1) * 1000 + 345, .shown = 1.5F});
  }
  scan.dials[5] = {.counts = -6345, .shown = -6.345F};
  scan.dials[2].valid = false;
  scan.dials[3].status = 2;
  scan.scan = 4711;
  DialRegisterMap map([&] { return scan; });
  const auto values = map.read(RegisterTable::kInput, 0, 12).value();
  EXPECT_EQ(values[0], 0);
  EXPECT_EQ(values[1], 1345);
  EXPECT_EQ(values[4], 0x8000);  // invalid
  EXPECT_EQ(values[5], 0);
  EXPECT_EQ(values[10], 0xFFFF);
  EXPECT_EQ(values[11], 0xE737);  // -6345
  const auto status = map.read(RegisterTable::kInput, 100, 7).value();
  EXPECT_EQ(status[3], 2);
  EXPECT_EQ(status[6], 4711);
  const auto floats = map.read(RegisterTable::kInput, 8000, 12).value();
  EXPECT_EQ(floats[0], 0x3FC0);  // 1.5F
  EXPECT_EQ(floats[1], 0x0000);
  EXPECT_EQ(map.read(RegisterTable::kHolding, 0, 12), map.read(RegisterTable::kInput, 0, 12));
  EXPECT_FALSE(map.read(RegisterTable::kInput, 11, 2));
  EXPECT_FALSE(map.read(RegisterTable::kInput, 60000, 2));
  const std::uint16_t one = 1;
  EXPECT_EQ(map.write(0, {&one, 1}), ModbusException::kIllegalAddress);
}

struct Told {
  int starts = 0;
  int stops = 0;
  Eigen::Vector2d q_rad{0, 0};
  int speed = 0;
};

RobotCalls port_to(Told& told) {
  return {
      .report =
          [] {
            RobotReport report;
            report.state = MotionState::kInPosition;
            report.q_rad = Eigen::Vector2d(1.5, -0.00000001);
            report.moves_started = 7;
            report.temperature_c = -1.25;
            report.cycles = 9;
            return report;
          },
      .start =
          [&](const Eigen::Vector2d& q_rad, int speed) {
            ++told.starts;
            told.q_rad = q_rad;
            told.speed = speed;
          },
      .stop = [&] { ++told.stops; }};
}

TEST(RobotRegisters, ReportInUnitsOfTenNanoradians) {
  Told told;
  RobotRegisterMap map(port_to(told));
  const auto values = map.read(RegisterTable::kInput, 0, 9).value();
  // 150 000 000 = 0x08F0D180
  EXPECT_EQ(
      values, (std::vector<std::uint16_t>{0x08F0, 0xD180, 0xFFFF, 0xFFFF, 2, 7, 0xFF83, 0, 9}));
  EXPECT_FALSE(map.read(RegisterTable::kInput, 8, 2));
}

TEST(RobotRegisters, StartsOnCommandWithTargetAndSpeedAndReadsBackTaken) {
  Told told;
  RobotRegisterMap map(port_to(told));
  const std::vector<std::uint16_t> all{0x08F0, 0xD180, 0xFFFF, 0xFFFF, 1, 30};
  EXPECT_FALSE(map.write(0, all));
  EXPECT_EQ(told.starts, 1);
  EXPECT_EQ(told.speed, 30);
  EXPECT_LT((told.q_rad - Eigen::Vector2d(1.5, -1e-8)).norm(), 1e-15);
  const auto back = map.read(RegisterTable::kHolding, 0, 6).value();
  EXPECT_EQ(back[4], 0);
  EXPECT_EQ(back[5], 30);
  const std::uint16_t stop = 2;
  EXPECT_FALSE(map.write(4, {&stop, 1}));
  EXPECT_EQ(told.stops, 1);
  EXPECT_EQ(told.starts, 1);
}

TEST(RobotRegisters, OfMoreJointsAllThatFollowsMovesOn) {
  Eigen::VectorXd sent;
  int stops = 0;
  RobotRegisterMap map(
      {.report =
           [] {
             RobotReport report;
             report.state = MotionState::kMoving;
             report.q_rad = Eigen::Vector3d(1.5, -0.00000001, 0.0);
             report.moves_started = 7;
             return report;
           },
       .start = [&](const Eigen::VectorXd& q_rad, int) { sent = q_rad; },
       .stop = [&] { ++stops; },
       .joints = 3});
  const auto values = map.read(RegisterTable::kInput, 0, 11).value();
  EXPECT_EQ(values[0], 0x08F0);
  EXPECT_EQ(values[6], 1) << "status";
  EXPECT_EQ(values[7], 7) << "moves";
  EXPECT_EQ(map.read(RegisterTable::kInput, 200, 1).value(), std::vector<std::uint16_t>{3});
  EXPECT_FALSE(map.read(RegisterTable::kInput, 8, 4));
  const std::vector<std::uint16_t> all{0, 0, 0, 0, 0x08F0, 0xD180, 1, 30};
  EXPECT_FALSE(map.write(0, all));
  EXPECT_NEAR(sent[2], 1.5, 1e-15);
  const std::uint16_t stop = 2;
  EXPECT_FALSE(map.write(6, {&stop, 1}));
  EXPECT_EQ(stops, 1);
}

TEST(RobotRegisters, ABadValueChangesNothing) {
  Told told;
  RobotRegisterMap map(port_to(told));
  const std::vector<std::uint16_t> bad_speed{1, 2, 3, 4, 1, 101};
  EXPECT_EQ(map.write(0, bad_speed), ModbusException::kIllegalValue);
  const std::uint16_t three = 3;
  EXPECT_EQ(map.write(4, {&three, 1}), ModbusException::kIllegalValue);
  EXPECT_EQ(map.write(6, {&three, 1}), ModbusException::kIllegalAddress);
  EXPECT_EQ(map.read(RegisterTable::kHolding, 0, 4).value(), std::vector<std::uint16_t>(4, 0));
  EXPECT_EQ(told.starts, 0);
}

}  // namespace
}  // namespace sixdial::mock_devices
