// Modbus frames as bytes, and registers as millimetres.
#include "acquisition/modbus_frame.h"

#include <gtest/gtest.h>

#include <random>

#include "tests/acquisition/wire.h"

namespace sixdial::acquisition {
namespace {

constexpr double kExact_mm = 1e-12;  // counts times a scale
constexpr double kFloat_mm = 1e-6;   // single precision at 12 mm

TEST(ModbusFrame, AsksForAllSixInOneRequest) {
  // Literal request of spec 5 for RTU: 01 04 00 00 00 0C F0 0F.
  const Bytes request = read_request(1, 4, 0, 12);
  EXPECT_EQ(request, (Bytes{0x01, 0x04, 0x00, 0x00, 0x00, 0x0c}));
  EXPECT_EQ(test::modbus_crc(request), 0x0ff0);  // sent low byte first: F0 0F
}

TEST(ModbusFrame, WritesRegisters) {
  const Words words{0x1234, 0xfffe};
  EXPECT_EQ(write_request(1, 4, words), (Bytes{1, 16, 0, 4, 0, 2, 4, 0x12, 0x34, 0xff, 0xfe}));
  EXPECT_TRUE(parse_write_reply(Bytes{1, 16, 0, 4, 0, 2}, 1, 4, 2));
  EXPECT_FALSE(parse_write_reply(Bytes{1, 16, 0, 4, 0, 1}, 1, 4, 2));
  EXPECT_FALSE(parse_write_reply(Bytes{1, 16, 0, 4, 0}, 1, 4, 2));
}

TEST(ModbusFrame, TakesOnlyTheReplyToItsRequest) {
  const Bytes good{1, 4, 4, 0x00, 0x00, 0x30, 0x39};
  EXPECT_EQ(parse_read_reply(good, 1, 4, 2).value(), (Words{0, 12345}));
  EXPECT_EQ(parse_read_reply(good, 2, 4, 2).error().kind, FaultKind::kWrongChannel);
  EXPECT_EQ(parse_read_reply(good, 1, 3, 2).error().kind, FaultKind::kBadFrame);
  EXPECT_EQ(parse_read_reply(good, 1, 4, 1).error().kind, FaultKind::kBadFrame);
  const auto exception = parse_read_reply(Bytes{1, 0x84, 2}, 1, 4, 2);
  EXPECT_EQ(exception.error().kind, FaultKind::kDevice);
  EXPECT_TRUE(is_illegal_address(exception.error()));
  EXPECT_FALSE(is_illegal_address(parse_read_reply(Bytes{1, 0x84, 6}, 1, 4, 2).error()));
  for (std::size_t size = 0; size < good.size(); ++size) {
    EXPECT_FALSE(parse_read_reply(std::span(good).first(size), 1, 4, 2)) << size;
  }
}

TEST(ModbusFrame, SurvivesAHundredThousandRandomReplies) {
  std::mt19937 random(7);
  std::uniform_int_distribution<int> byte(0, 255);
  std::uniform_int_distribution<int> length(0, 30);
  int understood = 0;
  for (int i = 0; i < 100'000; ++i) {
    Bytes reply(static_cast<std::size_t>(length(random)));
    for (auto& each : reply) each = static_cast<std::uint8_t>(byte(random));
    if (reply.size() > 2 && i % 2 == 0) {
      reply[0] = 1;
      reply[1] = 4;
    }
    if (parse_read_reply(reply, 1, 4, 2)) ++understood;
  }
  EXPECT_GT(understood, 0);
  EXPECT_LT(understood, 1000);
}

TEST(ModbusValue, KnowsBothWordOrders) {
  ModbusMap map;
  EXPECT_NEAR(value_mm(Words{0, 1345}, map).value(), 1.345, kExact_mm);
  EXPECT_NEAR(value_mm(Words{0xffff, 0xfac3}, map).value(), -1.341, kExact_mm);
  map.word_order = WordOrder::kLowFirst;
  EXPECT_NEAR(value_mm(Words{1345, 0}, map).value(), 1.345, kExact_mm);
  // Read the wrong way round 1345 shows as 88145920: outside every dial.
  EXPECT_NEAR(value_mm(Words{0, 1345}, map).value(), 88145.920, kExact_mm * 1e5);
  EXPECT_FALSE(within_travel(88145.920, 50.8));
}

TEST(ModbusValue, RefusesWhatTheGaugeMarksAsInvalid) {
  ModbusMap map;
  EXPECT_FALSE(value_mm(Words{0x8000, 0}, map));
  EXPECT_FALSE(value_mm(Words{0}, map));
  map.format = RegisterFormat::kInt16;
  EXPECT_FALSE(value_mm(Words{0x8000}, map));
  EXPECT_NEAR(value_mm(Words{0xfffb}, map).value(), -0.005, kExact_mm);
  map.format = RegisterFormat::kFloat32;
  map.scale = 1.0;
  EXPECT_FALSE(value_mm(Words{0x7fc0, 0}, map));
  EXPECT_NEAR(value_mm(Words{0x4145, 0x851f}, map).value(), 12.345, kFloat_mm);
}

TEST(ModbusValue, Int32GoesThereAndBack) {
  for (const std::int32_t value : {0, 1, -1, 123'456'789, -2'147'483'647, 2'147'483'647}) {
    Words words;
    append_int32(words, value);
    EXPECT_EQ(int32_of(words[0], words[1]), value);
  }
}

}  // namespace
}  // namespace sixdial::acquisition
