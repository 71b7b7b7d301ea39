// Dials on real serial bytes: the real libserialport on pseudo-terminals.
#include "acquisition/serial_bus.h"

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/resource.h>

#include <cmath>
#include <filesystem>
#include <fstream>
#include <memory>
#include <set>
#include <sstream>

#include "acquisition/dial_bank.h"
#include "session/reason.h"
#include "tests/acquisition/answered.h"
#include "tests/acquisition/wire.h"
#include "tests/support/figure.h"
#include "tests/support/pty_shim.h"

namespace sixdial::acquisition {
namespace {

using namespace std::chrono_literals;
using std::chrono::steady_clock;
using test::answered;
using test::eventually;
using test::PtyDevice;
using test::TemporaryFolder;
using testing::HasSubstr;

constexpr double kExact_mm = 1e-12;

geometry::Rig rig_of(const std::vector<std::string>& connections) {
  geometry::Rig rig = geometry::default_rig();
  rig.dials.resize(connections.size());
  for (std::size_t i = 0; i < connections.size(); ++i) {
    rig.dials[i].connection = connections[i];
  }
  return rig;
}

std::unique_ptr<DialBank> open(const geometry::Rig& rig, Clock& clock) {
  auto bank = DialBank::open(rig, clock);
  if (!bank) throw std::runtime_error(bank.error());
  return std::move(*bank);
}

std::string reason_of(const DialBank& bank, std::size_t dial = 0) {
  return bank.latest()[dial].reason;
}

// A Sylvac dial as the sheet has it; does not know ID?.
PtyDevice::Answer sylvac_dial(std::string value = "+012.345\r") {
  return [value = std::move(value)](const std::string& request) {
    return request == "?\r" ? value : "ERR1\r";
  };
}

class SerialDials : public testing::Test {
 protected:
  TemporaryFolder folder_;
  SystemClock clock_;
};

TEST_F(SerialDials, SylvacIsReadOverItsOwnLineSettings) {
  const std::string log = folder_.path("line.log");
  pty_shim_log_to(log.c_str());
  PtyDevice dial("\r", sylvac_dial());
  const auto bank = open(rig_of({"serial:" + dial.path() + "?dialect=sylvac"}), clock_);
  const auto readings = answered(*bank);
  pty_shim_log_to(nullptr);
  ASSERT_TRUE(readings[0].value_mm) << readings[0].reason << readings[0].detail;
  EXPECT_NEAR(*readings[0].value_mm, 12.345, kExact_mm);
  EXPECT_EQ(readings[0].quality, session::Quality::kGood);
  EXPECT_GT(readings[0].sequence, 0u);
  std::ifstream in(log);
  const std::string written{std::istreambuf_iterator<char>(in), {}};
  EXPECT_THAT(written, HasSubstr(dial.path() + " 4800 7E2\n"));
  // The last word on the modem lines.
  const std::size_t last = written.rfind(dial.path() + " DTR");
  ASSERT_NE(last, std::string::npos) << written;
  EXPECT_THAT(written.substr(last), HasSubstr("DTR on, RTS off"));
}

TEST_F(SerialDials, LinksUnderByIdAreResolved) {
  PtyDevice dial("\r", sylvac_dial());
  const std::string link = folder_.path("usb-Sylvac_dial-if00");
  std::filesystem::create_symlink(dial.path(), link);
  const auto bank = open(rig_of({"serial:" + link + "?dialect=sylvac"}), clock_);
  EXPECT_NEAR(answered(*bank)[0].value_mm.value(), 12.345, kExact_mm);
}

TEST_F(SerialDials, SixBehindOneMultiplexerEachWithItsOwnTime) {
  PtyDevice mux("\r", [](const std::string& request) {
    if (request.size() != 2) return std::string("912\r");
    return fmt::format("0{}A+00{}2.345\r", request[0], request[0]);
  });
  std::vector<std::string> connections;
  for (int channel = 1; channel <= 6; ++channel) {
    connections.push_back(
        fmt::format("serial:{}?dialect=mux10&channel={}", mux.path(), channel));
  }
  std::swap(connections[0], connections[4]);  // the rig's order is not the channels'
  auto rig = rig_of(connections);
  for (auto& dial : rig.dials) dial.geometry.travel_mm = 99.0;
  const auto bank = open(rig, clock_);
  const auto readings = answered(*bank);
  const std::vector<double> shown{52.345, 22.345, 32.345, 42.345, 12.345, 62.345};
  for (std::size_t i = 0; i < 6; ++i) {
    ASSERT_TRUE(readings[i].value_mm) << i << readings[i].reason << readings[i].detail;
    EXPECT_NEAR(*readings[i].value_mm, shown[i], kExact_mm) << i;
  }
  EXPECT_EQ(bank->buses().size(), 1u);
}

TEST_F(SerialDials, ABusyMultiplexerIsAskedAgain) {
  std::atomic<int> busy{2};
  PtyDevice mux("\r", [&](const std::string&) {
    return busy-- > 0 ? std::string("918\r") : std::string("01A+0012.345\r");
  });
  const auto bank = open(rig_of({"serial:" + mux.path() + "?dialect=mux10&channel=1"}), clock_);
  EXPECT_NEAR(answered(*bank)[0].value_mm.value(), 12.345, kExact_mm);
}

TEST_F(SerialDials, EachFaultOfTheLineIsToldByItsReason) {
  struct Case {
    std::string dialect;
    std::string answer;
    std::string reason;
  };
  const std::vector<Case> cases{
      {"sylvac", "", "timeout"},
      {"sylvac", "+012.3", "parse"},
      {"sylvac", "ERR0\r", "device"},
      {"sylvac", "ERR3\r", "range"},
      {"sylvac", "+0.48602\r", "unit"},
      {"sylvac", "+099.123\r", "range"},
      {"sylvac", "+01?.345\r", "parse"},
      {"mux10&channel=2", "03A+0012.345\r", "channel"},
      {"mux10&channel=2", "911\r", "no dial"},
      {"mw&channel=3", "3 TO 999999.99 mm\r\n", "no dial"},
      {"mahr", "+0.48602 inch\r", "unit"},
  };
  for (const Case& each : cases) {
    PtyDevice dial("\r", [&](const std::string& request) {
      return request.starts_with("ID") ? std::string("ERR1\r") : each.answer;
    });
    const auto bank =
        open(rig_of({"serial:" + dial.path() + "?dialect=" + each.dialect}), clock_);
    const auto readings =
        each.reason == session::reason::kTimeout ? bank->scan({}) : answered(*bank);
    EXPECT_EQ(readings[0].reason, each.reason) << each.dialect << " " << each.answer;
    EXPECT_FALSE(readings[0].value_mm);
    EXPECT_EQ(readings[0].quality, session::Quality::kBad);
  }
}

TEST_F(SerialDials, StrayLineFeedsAndUnaskedLinesAreNoReadings) {
  std::atomic<int> k{0};
  PtyDevice dial("\r", [&](const std::string& request) -> std::string {
    if (request != "?\r") return "ERR1\r";
    switch (k++ % 3) {
      case 0:
        return "SY280 V2\r+001.000\r";  // switched on meanwhile
      case 1:
        return "\n+001.000\r\n";
      default:
        return "+0\x01"
               "1.000\r+001.000\r";  // a noise byte in an unasked line before
    }
  });
  const auto bank = open(rig_of({"serial:" + dial.path() + "?dialect=sylvac"}), clock_);
  for (int i = 0; i < 6; ++i) {
    const auto reading = answered(*bank)[0];
    ASSERT_TRUE(reading.value_mm) << reading.reason << reading.detail;
    EXPECT_NEAR(*reading.value_mm, 1.0, kExact_mm);
  }
}

// The trap: the late answer to one question is taken for the answer to the next.
TEST_F(SerialDials, ALateAnswerIsNeverTakenForANewOne) {
  // Shows 2 until that was read. Then one answer, 3, comes only after it was given up, when a
  // careless driver would have put its next question. From then on 8.
  constexpr auto kHeldUp = 400ms;  // a careless driver asks again after 50 ms
  // Half speed: the driver stays quiet for 2 s, which is slack for a loaded machine.
  AcceleratedClock half(0.5, clock_.now_utc());
  enum class Step { kBefore, kLate, kAfter };
  std::atomic<Step> step{Step::kBefore};
  std::atomic<bool> given_up{false};
  PtyDevice dial("\r", [&](const std::string& request) -> std::string {
    if (request != "?\r") return "ERR1\r";
    if (step == Step::kBefore) return "+002.000\r";
    if (step == Step::kAfter) return "+008.000\r";
    step = Step::kAfter;
    EXPECT_TRUE(eventually([&] { return given_up.load(); }));
    std::this_thread::sleep_for(kHeldUp);
    return "+003.000\r";
  });
  const auto bank = open(rig_of({"serial:" + dial.path() + "?dialect=sylvac"}), half);
  std::set<double> read_mm;
  const auto newest_is = [&](double value_mm) {
    const Reading newest = bank->latest()[0];
    if (newest.value_mm) read_mm.insert(*newest.value_mm);
    return newest.value_mm && std::abs(*newest.value_mm - value_mm) < kExact_mm;
  };
  ASSERT_TRUE(eventually([&] { return newest_is(2.0); }));
  step = Step::kLate;
  ASSERT_TRUE(eventually([&] { return reason_of(*bank) == "timeout"; }));
  given_up = true;
  ASSERT_TRUE(eventually([&] { return newest_is(8.0); }));
  for (const double value_mm : read_mm) EXPECT_GT(std::abs(value_mm - 3.0), 0.5);
}

TEST_F(SerialDials, UnpluggedIsToldFromSilentAtOnceAndWithoutBurningTheProcessor) {
  PtyDevice silent("\r", [](const std::string&) { return std::string(); });
  auto pulled = std::make_unique<PtyDevice>("\r", sylvac_dial());
  const auto bank = open(
      rig_of(
          {"serial:" + silent.path() + "?dialect=sylvac",
           "serial:" + pulled->path() + "?dialect=sylvac"}),
      clock_);
  ASSERT_TRUE(eventually([&] {
    return reason_of(*bank, 0) == "timeout" && bank->latest()[1].value_mm.has_value();
  }));
  const auto out = steady_clock::now();
  pulled->hang_up();
  std::set<std::string> told;
  ASSERT_TRUE(eventually([&] {
    told.insert(reason_of(*bank, 1));
    return told.contains("disconnected");
  }));
  EXPECT_FALSE(told.contains("timeout")) << "it was taken for silent first";
  const auto noticed = steady_clock::now() - out;  // 100 ms on a machine at rest
  test::figure("unplugged.noticed_ms", static_cast<double>(noticed / 1us) * 1e-3);
  EXPECT_EQ(reason_of(*bank, 0), "timeout");

  rusage before{};
  rusage after{};
  ::getrusage(RUSAGE_SELF, &before);
  const auto from = steady_clock::now();
  EXPECT_FALSE(eventually([] { return false; }, 500ms));
  ::getrusage(RUSAGE_SELF, &after);
  const double wall_s = std::chrono::duration<double>(steady_clock::now() - from).count();
  const auto seconds = [](const rusage& usage) {
    return static_cast<double>(usage.ru_utime.tv_sec + usage.ru_stime.tv_sec) +
           static_cast<double>(usage.ru_utime.tv_usec + usage.ru_stime.tv_usec) * 1e-6;
  };
  EXPECT_LT(seconds(after) - seconds(before), 0.5 * wall_s);
  test::figure(
      "unplugged.processor_percent", 100.0 * (seconds(after) - seconds(before)) / wall_s);
}

TEST_F(SerialDials, ARepluggedAdapterIsTakenUpAgainByItsStableName) {
  const std::string link = folder_.path("usb-dial");
  const auto dial_with = [](const std::string& id, const std::string& value) {
    return [=](const std::string& request) { return request == "?\r" ? value : id + "\r"; };
  };
  auto first = std::make_unique<PtyDevice>("\r", dial_with("SN 1001", "+001.000\r"));
  std::filesystem::create_symlink(first->path(), link);
  const auto bank = open(rig_of({"serial:" + link + "?dialect=sylvac"}), clock_);
  ASSERT_TRUE(eventually([&] { return bank->latest()[0].value_mm.has_value(); }));

  const auto replug = [&](const std::string& id, const std::string& value) {
    first.reset();
    ASSERT_TRUE(eventually([&] { return reason_of(*bank) == "disconnected"; }));
    first = std::make_unique<PtyDevice>("\r", dial_with(id, value));
    std::filesystem::remove(link);
    std::filesystem::create_symlink(first->path(), link);
  };
  replug("SN 1001", "+002.000\r");
  ASSERT_TRUE(eventually([&] { return bank->latest()[0].value_mm.value_or(0) == 2.0; }));
  EXPECT_GE(bank->buses()[0].reconnections, 1u);
  // Another dial on the same cable is not the dial of the rig file.
  replug("SN 2002", "+003.000\r");
  ASSERT_TRUE(eventually([&] { return reason_of(*bank) == "identity"; }));
  EXPECT_FALSE(bank->latest()[0].value_mm);
}

TEST_F(SerialDials, StopsInTimeWithASilentDialAndAMissingPort) {
  PtyDevice silent("\r", [](const std::string&) { return std::string(); });
  auto bank = open(
      rig_of(
          {"serial:" + silent.path() + "?dialect=sylvac",
           "serial:" + folder_.path("not-there") + "?dialect=sylvac"}),
      clock_);
  ASSERT_TRUE(eventually([&] { return reason_of(*bank, 1) == "disconnected"; }));
  EXPECT_THAT(bank->latest()[1].detail, HasSubstr("No such file"));
  const auto before = steady_clock::now();
  bank.reset();
  EXPECT_LT(steady_clock::now() - before, test::kInTime);  // 300 ms on a machine at rest
}

TEST_F(SerialDials, APortIsTakenByOneProgramOnly) {
  PtyDevice dial("\r", sylvac_dial());
  const LineSettings line = find_dial_protocol("sylvac")->line;
  const auto first = SerialPort::open(dial.path(), line);
  ASSERT_TRUE(first) << first.error().detail;
  const auto second = SerialPort::open(dial.path(), line);
  ASSERT_FALSE(second);
  EXPECT_EQ(second.error().kind, FaultKind::kDisconnected);
}

TEST_F(SerialDials, AnAcceleratedRigIsReadJustTheSame) {
  AcceleratedClock fast(100.0, clock_.now_utc());
  PtyDevice dial("\r", sylvac_dial());
  const auto bank = open(rig_of({"serial:" + dial.path() + "?dialect=sylvac"}), fast);
  for (int i = 0; i < 20; ++i) {
    const DeviceTime before = fast.monotonic();
    const auto reading = answered(*bank)[0];
    ASSERT_TRUE(reading.value_mm) << reading.reason;
    EXPECT_GE(reading.requested, before);
  }
}

TEST(DialBank, ListsEveryConnectionThatCannotBeUsed) {
  SystemClock clock;
  const auto refused = [&](const std::vector<std::string>& connections) {
    const auto bank = DialBank::open(rig_of(connections), clock);
    return bank ? std::string("accepted") : bank.error();
  };
  const std::string both = refused({"serial:/dev/x", "modbus:/y"});
  EXPECT_THAT(both, HasSubstr("dial A"));
  EXPECT_THAT(both, HasSubstr("dial B"));
  EXPECT_THAT(
      refused({"serial:/dev/x?dialect=sylvac", "serial:/dev/x?dialect=sylvac"}),
      HasSubstr("already the cable of dial A"));
  EXPECT_THAT(
      refused(
          {"serial:/dev/x?dialect=mux10&channel=1", "serial:/dev/x?dialect=mux10&channel=1"}),
      HasSubstr("already dial A"));
  EXPECT_THAT(
      refused({"serial:/dev/x?dialect=mux10&channel=1", "serial:/dev/x?dialect=sylvac"}),
      HasSubstr("dialect mux10"));
  EXPECT_THAT(
      refused({"modbus-tcp://h:1?index=1", "modbus-tcp://h:1"}), HasSubstr("already dial A"));
}

}  // namespace
}  // namespace sixdial::acquisition
