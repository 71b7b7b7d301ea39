// What the serial dials say, against the literal lines of their makers (spec 5).
#include <gtest/gtest.h>

#include <array>
#include <map>
#include <vector>

#include "mock_devices/dials/dialect.h"
#include "mock_devices/modbus_slave.h"

namespace sixdial::mock_devices {
namespace {

/// Six displays that show what a test says, and faults that it orders.
class ScriptedPanel final : public Panel {
 public:
  std::size_t dial_count() const override { return 6; }
  ShownDial show(std::size_t dial) override { return shown[dial]; }
  std::optional<FaultOrder> take(std::size_t dial, Fault fault) override {
    const auto found = orders.find({dial, fault});
    if (found == orders.end()) return std::nullopt;
    const FaultOrder order = found->second;
    orders.erase(found);
    return order;
  }
  void set_inch(std::size_t dial, bool inch) override { shown[dial].inch = inch; }
  void set_hold(std::size_t dial, bool hold) override { held[dial] = hold; }
  std::uint16_t scan() override { return 1; }

  std::array<ShownDial, 6> shown{};
  std::array<bool, 6> held{};
  std::map<std::pair<std::size_t, Fault>, FaultOrder> orders;
};

std::string ask(
    const Dialect& dialect, const std::string& bytes, Panel& panel, std::size_t dial = 0) {
  std::string buffer = bytes;
  const auto request = dialect.take_request(buffer);
  return request ? dialect.answer(*request, dial, panel).bytes : "(no request)";
}

ShownDial showing(double value) { return {.value = value, .in_contact = true}; }
ShownDial showing_inch(double value) {
  return {.value = value, .inch = true, .in_contact = true};
}

TEST(Sylvac, SpeaksItsMakersLines) {
  ScriptedPanel panel;
  panel.shown[0] = showing(12.345);
  EXPECT_EQ(ask(kSylvac, "?\r", panel), "+012.345\r");
  panel.shown[0] = showing(-0.007);
  EXPECT_EQ(ask(kSylvac, "?\r", panel), "-000.007\r");
  panel.shown[0] = showing(-0.0001);
  EXPECT_EQ(ask(kSylvac, "?\r", panel), "+000.000\r");
  EXPECT_EQ(ask(kSylvac, "set?\r", panel), "MM RES2 B1\r");
  EXPECT_EQ(ask(kSylvac, "BAT?\r", panel), "BAT1\r");
  EXPECT_EQ(ask(kSylvac, "ID?\r", panel, 2), "SY2803\r");
  EXPECT_EQ(ask(kSylvac, "HELLO\r", panel), "ERR1\r");
  panel.shown[0].moving_fast = true;
  EXPECT_EQ(ask(kSylvac, "?\r", panel), "ERR0\r");
  panel.shown[0] = {.value = 50.8, .in_contact = true, .at_travel_end = true};
  EXPECT_EQ(ask(kSylvac, "?\r", panel), "ERR3\r");
  EXPECT_EQ(kSylvac.power_on(0).substr(0, 5), "SY280");
  EXPECT_NEAR(kSylvac.line.character_s(), 11.0 / 4800, 1e-12);  // 7E2
}

TEST(Sylvac, TellsInchLowBatteryAndOrderedErrors) {
  ScriptedPanel panel;
  panel.shown[0] = showing_inch(12.345 / 25.4);
  EXPECT_EQ(ask(kSylvac, "?\r", panel), "+0.48602\r");
  EXPECT_EQ(ask(kSylvac, "SET?\r", panel), "IN RES2 B1\r");
  panel.shown[0] = {.value = 1.0, .in_contact = true, .low_battery = true};
  EXPECT_EQ(ask(kSylvac, "BAT?\r", panel), "BAT0\r");
  EXPECT_EQ(ask(kSylvac, "SET?\r", panel), "MM RES2 B0\r");
  panel.orders[{0, Fault::kErrorLine}] = {};
  EXPECT_EQ(ask(kSylvac, "?\r", panel), "ERR2\r");
  EXPECT_EQ(ask(kSylvac, "?\r", panel), "+001.000\r");
  EXPECT_EQ(ask(kSylvac, "IN\r", panel), "IN\r");
  EXPECT_TRUE(panel.shown[0].inch);
  EXPECT_EQ(ask(kSylvac, "STO1\r", panel), "STO1\r");
  EXPECT_TRUE(panel.held[0]);
}

TEST(Mahr, SpeaksItsMakersLines) {
  ScriptedPanel panel;
  panel.shown[0] = showing(12.345);
  EXPECT_EQ(ask(kMahr, "?\r", panel), "+012.345 mm\r");
  panel.shown[0] = showing_inch(12.345 / 25.4);
  EXPECT_EQ(ask(kMahr, "?\r", panel), "+0.48602 inch\r");
  EXPECT_EQ(ask(kMahr, "?!\r", panel), "ERR2\r");
  panel.shown[0].moving_fast = true;
  EXPECT_EQ(ask(kMahr, "?\r", panel), "ERR3\r");
  EXPECT_NEAR(kMahr.longest_gap_s, 0.020, 1e-12);
}

TEST(Mux10, SpeaksItsMakersLines) {
  ScriptedPanel panel;
  panel.shown[0] = showing(12.345);
  panel.shown[5] = showing(-1.5);
  const std::string reply = ask(kMux10, "1\r", panel);
  EXPECT_EQ(reply, "01A+0012.345\r");
  EXPECT_EQ(reply.size(), 13U);
  EXPECT_EQ(ask(kMux10, "6\r", panel), "06A-0001.500\r");
  EXPECT_EQ(ask(kMux10, "7\r", panel), "911\r");
  EXPECT_EQ(ask(kMux10, "12\r", panel), "912\r");
  panel.shown[0] = showing_inch(12.345 / 25.4);
  const std::string inch = ask(kMux10, "1\r", panel);
  EXPECT_EQ(inch, "01A+00.48602\r");
  EXPECT_EQ(inch.size(), 13U);
  panel.shown[0].moving_fast = true;
  EXPECT_EQ(ask(kMux10, "1\r", panel), "911\r");
}

TEST(Mux10, IsBusyErrsAndGoesAstrayOnOrder) {
  ScriptedPanel panel;
  panel.shown[2] = showing(3.0);
  panel.shown[3] = showing(4.0);
  panel.orders[{2, Fault::kBusy}] = {};
  EXPECT_EQ(ask(kMux10, "3\r", panel), "918\r");
  panel.orders[{2, Fault::kErrorLine}] = {.amount = 9.0};
  EXPECT_EQ(ask(kMux10, "3\r", panel), "919\r");
  panel.orders[{2, Fault::kWrongChannel}] = {};
  EXPECT_EQ(ask(kMux10, "3\r", panel), "04A+0004.000\r");
  EXPECT_EQ(ask(kMux10, "3\r", panel), "03A+0003.000\r");
}

TEST(Mw, SpeaksItsMakersLines) {
  ScriptedPanel panel;
  panel.shown[0] = showing(1.378);
  EXPECT_EQ(ask(kMw, "C1\r\n", panel), "1 MW +001.378 mm\r\n");
  EXPECT_EQ(ask(kMw, "C8\r\n", panel), "8 TO 999999.99 mm\r\n");
  panel.orders[{2, Fault::kErrorLine}] = {};
  EXPECT_EQ(ask(kMw, "C3\r\n", panel), "3 TO 999999.99 mm\r\n");
  EXPECT_EQ(ask(kMw, "hello\r\n", panel), "");
}

TEST(ModbusRtuDial, AnswersTheLiteralRequestWithSixDials) {
  ScriptedPanel panel;
  for (std::size_t i = 0; i < 6; ++i) panel.shown[i] = showing(static_cast<double>(i) + 1.345);
  const std::string request("\x01\x04\x00\x00\x00\x0C\xF0\x0F", 8);
  const std::string reply = ask(kModbusRtu, request, panel);
  ASSERT_EQ(reply.size(), 3U + 24U + 2U);
  EXPECT_EQ(reply.substr(0, 3), (std::string{0x01, 0x04, 24}));
  EXPECT_EQ(reply.substr(3, 4), std::string("\x00\x00\x05\x41", 4));  // 1345
  const Bytes bytes(reply.begin(), reply.end());
  EXPECT_EQ(crc16(bytes), 0);
  panel.orders[{4, Fault::kCrcError}] = {};
  const std::string damaged = ask(kModbusRtu, request, panel);
  EXPECT_NE(crc16(Bytes(damaged.begin(), damaged.end())), 0);
  panel.orders[{4, Fault::kWrongUnitId}] = {};
  EXPECT_EQ(ask(kModbusRtu, request, panel)[0], 2);
  panel.orders[{1, Fault::kException}] = {};
  EXPECT_EQ(ask(kModbusRtu, request, panel).substr(1, 2), std::string("\x84\x04", 2));
  panel.orders[{1, Fault::kBusy}] = {};
  EXPECT_EQ(ask(kModbusRtu, request, panel).substr(1, 2), std::string("\x84\x06", 2));
  // Another unit is meant: this one is silent.
  std::string other("\x02\x04\x00\x00\x00\x0C", 6);
  const std::uint16_t crc = crc16(Bytes(other.begin(), other.end()));
  other += static_cast<char>(crc & 0xFF);
  other += static_cast<char>(crc >> 8);
  EXPECT_EQ(ask(kModbusRtu, other, panel), "");
}

TEST(Dialects, LinesEndWithEitherMarkAndEmptyOnesAreNone) {
  std::string buffer = "\r\n\n?\r\nSET";
  EXPECT_EQ(take_line(buffer), "?");
  EXPECT_EQ(take_line(buffer), std::nullopt);
  EXPECT_EQ(buffer, "SET");
}

class EveryDialect : public testing::TestWithParam<const Dialect*> {};

TEST_P(EveryDialect, ShowsAThousandValuesToTheMicrometre) {
  if (GetParam() == &kModbusRtu) {
    EXPECT_TRUE(GetParam()->shared);  // its numbers are not text; see ModbusRtuDial
    return;
  }
  ScriptedPanel panel;
  const std::string request =
      GetParam()->shared ? (GetParam() == &kMw ? "C1\r\n" : "1\r") : "?\r";
  for (int i = 0; i < 1000; ++i) {
    const double value = -1.0 + 0.0517 * i;
    panel.shown[0] = showing(value);
    const std::string reply = ask(*GetParam(), request, panel);
    const std::size_t sign = reply.find_first_of("+-");
    ASSERT_NE(sign, std::string::npos) << reply;
    ASSERT_NEAR(std::stod(reply.substr(sign)), value, 0.0005 + 1e-9) << reply;
  }
}

TEST_P(EveryDialect, IsFoundByItsNameAndHasALine) {
  EXPECT_EQ(find_dialect(GetParam()->name), GetParam());
  EXPECT_GT(GetParam()->line.baud, 0);
  EXPECT_GT(GetParam()->latency_s, 0.0);
}

INSTANTIATE_TEST_SUITE_P(
    , EveryDialect, testing::ValuesIn(dialects().begin(), dialects().end()),
    [](const auto& each) { return std::string(each.param->name); });

}  // namespace
}  // namespace sixdial::mock_devices
