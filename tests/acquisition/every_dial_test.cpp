// Laws that every dialect keeps, and the literal frames of the makers' sheets.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>
#include <set>
#include <string>
#include <vector>

#include "acquisition/connection.h"
#include "acquisition/dial_examples.h"
#include "acquisition/dial_protocol.h"
#include "session/rig_file.h"

namespace sixdial::acquisition {
namespace {

constexpr double kExact_mm = 1e-12;  // a decimal read into a double and nothing else
constexpr int kChannel = 3;

// The frame a dial of this dialect sends, typed here from the sheets and not from the parser.
std::string frame_for(std::string_view dialect, double value_mm, int channel) {
  const char sign = value_mm < 0 ? '-' : '+';
  const double size = std::abs(value_mm);
  if (dialect == "sylvac") return fmt::format("{}{:07.3f}\r", sign, size);
  if (dialect == "mahr") return fmt::format("{}{:07.3f} mm\r", sign, size);
  if (dialect == "mux10") return fmt::format("0{}A{}{:08.3f}\r", channel, sign, size);
  return fmt::format("{} MW {}{:07.3f} mm\r\n", channel, sign, size);
}

class EveryDial : public testing::TestWithParam<const DialProtocol*> {
 protected:
  [[nodiscard]] const DialProtocol& dial() const { return *GetParam(); }
  [[nodiscard]] int channel() const { return dial().channels > 0 ? kChannel : 0; }
};

TEST_P(EveryDial, ReadsWhatItsDialShows) {
  std::mt19937 random(20260301);
  std::uniform_int_distribution<int> micrometres(-500, 50'800);
  for (int i = 0; i < 10'000; ++i) {
    const double shown_mm = micrometres(random) * 1e-3;
    const std::string frame = frame_for(dial().name, shown_mm, channel());
    const auto parsed = dial().parse(frame, channel());
    ASSERT_TRUE(parsed) << frame;
    const auto value_mm = displacement_mm(*parsed, 0.001, 50.8);
    ASSERT_TRUE(value_mm) << frame;
    ASSERT_NEAR(*value_mm, shown_mm, kExact_mm) << frame;
  }
}

TEST_P(EveryDial, RefusesEveryTruncatedFrame) {
  const std::string frame = frame_for(dial().name, 12.345, channel());
  ASSERT_TRUE(dial().parse(frame, channel()));
  for (std::size_t size = 0; size < frame.size(); ++size) {
    EXPECT_FALSE(dial().parse(frame.substr(0, size), channel())) << "first " << size;
    if (size == 0) continue;
    EXPECT_FALSE(dial().parse(frame.substr(size), channel())) << "from " << size;
  }
}

TEST_P(EveryDial, RefusesTwoFramesRunIntoOne) {
  const std::string frame = frame_for(dial().name, 12.345, channel());
  EXPECT_FALSE(dial().parse(frame + frame, channel()));
  EXPECT_FALSE(dial().parse(frame.substr(0, frame.size() / 2) + frame, channel()));
  EXPECT_FALSE(dial().parse(" " + frame, channel()));
}

TEST_P(EveryDial, SurvivesAHundredThousandRandomByteStrings) {
  std::mt19937 random(5);
  std::uniform_int_distribution<int> length(0, 24);
  std::uniform_int_distribution<int> byte(0, 255);
  const std::string likely = "+-.0123456789AMWTOmminchERR<=> \r\n";
  std::uniform_int_distribution<std::size_t> letter(0, likely.size() - 1);
  int tried = 0;
  int understood = 0;
  for (int i = 0; i < 100'000; ++i) {
    std::string frame;
    const int size = length(random);
    for (int k = 0; k < size; ++k) {
      frame += i % 2 == 0 ? static_cast<char>(byte(random)) : likely[letter(random)];
    }
    if (i % 2 == 1) frame += dial().frame_end;
    const auto parsed = dial().parse(frame, channel());
    if (parsed) {
      ++understood;
      EXPECT_TRUE(std::isfinite(parsed->value)) << frame;
    }
    ++tried;
  }
  EXPECT_EQ(tried, 100'000);
  EXPECT_LT(understood, 1000);
}

TEST_P(EveryDial, SurvivesOneChangedByteAnywhere) {
  const std::string frame = frame_for(dial().name, 12.345, channel());
  int accepted = 0;
  for (std::size_t at = 0; at < frame.size(); ++at) {
    for (int byte = 0; byte < 256; ++byte) {
      std::string changed = frame;
      changed[at] = static_cast<char>(byte);
      const auto parsed = dial().parse(changed, channel());
      if (!parsed) continue;
      ++accepted;
      // What is still read is a number of the same shape: a changed digit or sign.
      EXPECT_LT(std::abs(parsed->value), 10'000.0) << printable(changed);
    }
  }
  EXPECT_GT(accepted, 50);  // changed digits
  EXPECT_LT(accepted, 200);
}

TEST_P(EveryDial, NamesItsLineAndItsFrame) {
  EXPECT_FALSE(dial().name.empty());
  EXPECT_TRUE(dial().frame_end == "\r" || dial().frame_end == "\r\n");
  EXPECT_TRUE(
      dial().request(channel()).ends_with("\r") || dial().request(channel()).ends_with("\n"));
  EXPECT_LE(dial().timeout.count(), 300);
  EXPECT_EQ(find_dial_protocol(dial().name), &dial());
}

TEST_P(EveryDial, FollowsIntoAnExampleRigAndTheTable) {
  EXPECT_FALSE(dial().maker.empty());
  EXPECT_FALSE(dial().wiring.empty());
  EXPECT_FALSE(dial().example_port.empty());
  const geometry::Rig rig = session::parse_rig(example_rig(dial()), "rig.toml");
  std::set<std::string> places;
  for (const geometry::Dial& each : rig.dials) {
    const auto connection = parse_dial_connection(each.connection);
    ASSERT_TRUE(connection.has_value()) << connection.error();
    EXPECT_EQ(std::get<SerialConnection>(*connection).protocol, &dial());
    places.insert(each.connection);
  }
  EXPECT_EQ(places.size(), 6U) << "each dial at a place of its own";
  EXPECT_NE(dial_table().find(std::string(dial().maker)), std::string::npos);
}

INSTANTIATE_TEST_SUITE_P(
    , EveryDial, testing::ValuesIn(dial_protocols()),
    [](const auto& each) { return std::string{each.param->name}; });

tl::expected<double, FaultKind> read(
    std::string_view dialect, std::string_view frame, int channel = 0) {
  const auto parsed = find_dial_protocol(dialect)->parse(frame, channel);
  if (!parsed) return tl::unexpected(parsed.error());
  return displacement_mm(*parsed, 0.001, 50.8);
}

TEST(Sylvac, ReadsTheFramesOfTheDataSheet) {
  EXPECT_NEAR(read("sylvac", "+012.345\r").value(), 12.345, kExact_mm);
  EXPECT_NEAR(read("sylvac", " 12.345\r").value(), 12.345, kExact_mm);
  EXPECT_NEAR(read("sylvac", "-00.105<\r").value(), -0.105, kExact_mm);
  EXPECT_NEAR(read("sylvac", "+1.5=\r").value(), 1.5, kExact_mm);
  EXPECT_NEAR(read("sylvac", "+1.5>\r").value(), 1.5, kExact_mm);
  EXPECT_EQ(read("sylvac", "ERR0\r").error(), FaultKind::kDevice);
  EXPECT_EQ(read("sylvac", "ERR1\r").error(), FaultKind::kDevice);
  EXPECT_EQ(read("sylvac", "ERR2\r").error(), FaultKind::kDevice);
  EXPECT_EQ(read("sylvac", "ERR3\r").error(), FaultKind::kRange);
  EXPECT_EQ(read("sylvac", "ERR7\r").error(), FaultKind::kBadFrame);
  EXPECT_EQ(read("sylvac", "SY280\r").error(), FaultKind::kBadFrame);
  EXPECT_TRUE(find_dial_protocol("sylvac")->unasked("SY280 V1.2\r"));
  EXPECT_FALSE(find_dial_protocol("sylvac")->unasked("+012.345\r"));
  EXPECT_EQ(find_dial_protocol("sylvac")->request(0), "?\r");
}

TEST(Sylvac, NoticesInchByItsDecimals) {
  EXPECT_EQ(read("sylvac", "+0.48602\r").error(), FaultKind::kUnit);
  EXPECT_EQ(read("sylvac", "+00.4860\r").error(), FaultKind::kUnit);
}

TEST(Mahr, ReadsTheFramesOfTheDataSheet) {
  EXPECT_NEAR(read("mahr", "+012.345 mm\r").value(), 12.345, kExact_mm);
  EXPECT_EQ(read("mahr", "+0.48602 inch\r").error(), FaultKind::kUnit);
  EXPECT_EQ(read("mahr", "ERR2\r").error(), FaultKind::kDevice);
  EXPECT_EQ(read("mahr", "ERR3\r").error(), FaultKind::kDevice);
  EXPECT_EQ(read("mahr", "ERR4\r").error(), FaultKind::kDevice);
  EXPECT_EQ(read("mahr", "+012.345\r").error(), FaultKind::kBadFrame);
}

TEST(Mux10, ReadsTheFramesOfTheDataSheet) {
  EXPECT_NEAR(read("mux10", "01A+0012.345\r", 1).value(), 12.345, kExact_mm);
  EXPECT_NEAR(read("mux10", "06A-0000.105\r", 6).value(), -0.105, kExact_mm);
  EXPECT_EQ(read("mux10", "01A+0012.345\r", 2).error(), FaultKind::kWrongChannel);
  EXPECT_EQ(read("mux10", "01A+00.48602\r", 1).error(), FaultKind::kUnit);
  EXPECT_EQ(read("mux10", "01A+000.4860\r", 1).error(), FaultKind::kUnit);
  EXPECT_EQ(read("mux10", "911\r", 1).error(), FaultKind::kNoDial);
  EXPECT_EQ(read("mux10", "912\r", 1).error(), FaultKind::kDevice);
  EXPECT_EQ(read("mux10", "918\r", 1).error(), FaultKind::kBusy);
  EXPECT_EQ(read("mux10", "919\r", 1).error(), FaultKind::kDevice);
  EXPECT_EQ(read("mux10", "915\r", 1).error(), FaultKind::kBadFrame);
  EXPECT_EQ(find_dial_protocol("mux10")->request(4), "4\r");
}

TEST(Mw, ReadsTheFramesOfTheDataSheet) {
  EXPECT_NEAR(read("mw", "1 MW +001.378 mm\r\n", 1).value(), 1.378, kExact_mm);
  EXPECT_NEAR(read("mw", "1 MW+001.378 mm\r\n", 1).value(), 1.378, kExact_mm);
  EXPECT_EQ(read("mw", "3 TO 999999.99 mm\r\n", 3).error(), FaultKind::kNoDial);
  EXPECT_EQ(read("mw", "2 MW +001.378 mm\r\n", 1).error(), FaultKind::kWrongChannel);
  EXPECT_EQ(read("mw", "1 MW +0.05425 in\r\n", 1).error(), FaultKind::kUnit);
  EXPECT_EQ(find_dial_protocol("mw")->request(1), "C1\r\n");
}

TEST(Displacement, IsRefusedOutsideTheTravel) {
  const auto frame = [](double value) { return DialFrame{value, Unit::kMillimetre, 3}; };
  EXPECT_TRUE(displacement_mm(frame(50.8), 0.001, 50.8));
  EXPECT_TRUE(displacement_mm(frame(-0.2), 0.001, 50.8));
  EXPECT_EQ(displacement_mm(frame(52.0), 0.001, 50.8).error(), FaultKind::kRange);
  EXPECT_EQ(displacement_mm(frame(-1.0), 0.001, 50.8).error(), FaultKind::kRange);
}

}  // namespace
}  // namespace sixdial::acquisition
