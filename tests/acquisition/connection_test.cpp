// Connection strings of the rig file: what they mean, and how a wrong one is explained.
#include "acquisition/connection.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace sixdial::acquisition {
namespace {

using testing::HasSubstr;

SerialConnection serial(std::string_view text) {
  return std::get<SerialConnection>(parse_dial_connection(text).value());
}
ModbusConnection modbus(std::string_view text) {
  return std::get<ModbusConnection>(parse_dial_connection(text).value());
}
std::string refusal(std::string_view text) {
  const auto parsed = parse_dial_connection(text);
  return parsed ? "accepted" : parsed.error();
}

TEST(Connection, ReadsASerialDial) {
  const auto one = serial("serial:/dev/serial/by-id/usb-FTDI_x-port0?dialect=sylvac");
  EXPECT_EQ(one.device, "/dev/serial/by-id/usb-FTDI_x-port0");
  EXPECT_EQ(one.protocol, find_dial_protocol("sylvac"));
  const auto six = serial("serial:/dev/ttyUSB0?dialect=mux10&channel=3");
  EXPECT_EQ(six.protocol, find_dial_protocol("mux10"));
  EXPECT_EQ(six.channel, 3);
}

TEST(Connection, ReadsAModbusGaugeBox) {
  const auto plain = modbus("modbus-tcp://127.0.0.1:1502?unit=1");
  EXPECT_EQ(plain.endpoint, ModbusEndpoint(ModbusTcpEndpoint{"127.0.0.1", 1502}));
  EXPECT_EQ(plain.map, ModbusMap{});
  EXPECT_FALSE(plain.index);
  const auto other = modbus(
      "modbus-tcp://gauges.local?unit=7&base=40&scale=0.0001&word_order=low&function=3&index=2&"
      "status=none&counter=none&format=int32&count=8&timeout_ms=100&quiet_ms=2000");
  EXPECT_EQ(other.endpoint, ModbusEndpoint(ModbusTcpEndpoint{"gauges.local", 502}));
  EXPECT_EQ(other.map.unit, 7);
  EXPECT_EQ(other.map.base, 40);
  EXPECT_EQ(other.map.count, 8);
  EXPECT_EQ(other.map.scale, 0.0001);
  EXPECT_EQ(other.map.word_order, WordOrder::kLowFirst);
  EXPECT_EQ(other.map.function, 3);
  EXPECT_EQ(other.map.status, -1);
  EXPECT_EQ(other.map.counter, -1);
  EXPECT_EQ(other.index, 2);
  EXPECT_EQ(other.timeout.count(), 100);
  EXPECT_EQ(other.quiet.count(), 2000);
  EXPECT_EQ(
      modbus("modbus-tcp://[::1]:1502").endpoint,
      ModbusEndpoint(ModbusTcpEndpoint{"::1", 1502}));
}

TEST(Connection, FloatsLieAt8000InMillimetres) {
  const auto floats = modbus("modbus-tcp://h:502?format=float32");
  EXPECT_EQ(floats.map.base, 8000);
  EXPECT_EQ(floats.map.scale, 1.0);
}

TEST(Connection, ReadsAModbusLine) {
  const auto line = modbus("modbus-rtu:/dev/ttyUSB1?baud=9600&parity=E&unit=5");
  EXPECT_EQ(
      line.endpoint, ModbusEndpoint(ModbusRtuEndpoint{"/dev/ttyUSB1", 9600, Parity::kEven, 1}));
  EXPECT_EQ(line.map.unit, 5);
}

TEST(Connection, ExplainsWhatIsWrongAndWhatWouldBeRight) {
  EXPECT_THAT(refusal("modbus-tpc://h:1"), HasSubstr("did you mean 'modbus-tcp'"));
  EXPECT_THAT(refusal("seriel:/dev/ttyUSB0"), HasSubstr("did you mean 'serial'"));
  EXPECT_THAT(
      refusal("serial:/dev/ttyUSB0?dialect=silvac"), HasSubstr("did you mean 'sylvac'"));
  EXPECT_THAT(
      refusal("modbus-tcp://h:1?wordorder=low"), HasSubstr("did you mean 'word_order'"));
  EXPECT_THAT(refusal("modbus-tcp://h:1?word_order=middle"), HasSubstr("none of high, low"));
  EXPECT_THAT(refusal("serial:/dev/ttyUSB0"), HasSubstr("no dialect"));
  EXPECT_THAT(refusal("serial:/dev/ttyUSB0?dialect=mux10"), HasSubstr("channel=1..6"));
  EXPECT_THAT(refusal("serial:/dev/ttyUSB0?dialect=mux10&channel=7"), HasSubstr("from 1 to 6"));
  EXPECT_THAT(
      refusal("serial:/dev/ttyUSB0?dialect=sylvac&channel=1"), HasSubstr("has no channel"));
  EXPECT_THAT(refusal("serial:ttyUSB0?dialect=sylvac"), HasSubstr("not a device path"));
  EXPECT_THAT(refusal("modbus-tcp://h:70000"), HasSubstr("70000"));
  EXPECT_THAT(refusal("modbus-tcp://h:1?unit=one"), HasSubstr("unit=one"));
  EXPECT_THAT(refusal("modbus-tcp://h:1?unit=1&unit=2"), HasSubstr("twice"));
  EXPECT_THAT(refusal("modbus-tcp://h:1?unit"), HasSubstr("not key=value"));
  EXPECT_THAT(refusal("modbus-tcp://:1"), HasSubstr("host:port"));
  EXPECT_THAT(refusal("modbus-tcp://h:1?scale=0"), HasSubstr("scale=0"));
  EXPECT_THAT(refusal("modbus-tcp://h:1?timeout_ms=1000"), HasSubstr("20 to 300"));
  EXPECT_THAT(refusal("modbus-rtu:/dev/x?baud=19201"), HasSubstr("19201"));
  EXPECT_THAT(refusal("modbus-rtu:/dev/x?unit=248"), HasSubstr("248"));
  EXPECT_THAT(refusal(""), HasSubstr("empty"));
}

}  // namespace
}  // namespace sixdial::acquisition
