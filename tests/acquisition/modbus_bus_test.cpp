// Gauge boxes over real Modbus bytes: our own servers, and Debian's pymodbus as a stranger.
#include "acquisition/modbus_bus.h"

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <signal.h>
#include <spawn.h>
#include <sys/wait.h>
#include <unistd.h>

#include <memory>
#include <set>

#include "acquisition/dial_bank.h"
#include "session/reason.h"
#include "tests/acquisition/answered.h"
#include "tests/acquisition/wire.h"
#include "tests/support/paths.h"

namespace sixdial::acquisition {
namespace {

using namespace std::chrono_literals;
using session::Quality;
using std::chrono::steady_clock;
using test::answered;
using test::eventually;
using test::ModbusRtuServer;
using test::ModbusTable;
using test::ModbusTcpServer;
using testing::HasSubstr;

constexpr double kExact_mm = 1e-12;
constexpr double kFloat_mm = 1e-6;  // single precision below 10 mm

geometry::Rig rig_on(const std::string& connection) {
  geometry::Rig rig = geometry::default_rig();
  for (auto& dial : rig.dials) dial.connection = connection;
  return rig;
}

std::unique_ptr<DialBank> open(const geometry::Rig& rig, Clock& clock) {
  auto bank = DialBank::open(rig, clock);
  if (!bank) throw std::runtime_error(bank.error());
  return std::move(*bank);
}

// Six gauges at 1.345, 2.345 .. mm with status words and a scan counter that counts each read.
void fill(ModbusTable& table, bool with_extras = true) {
  for (int k = 0; k < 6; ++k) {
    test::put_int32(table.input, 2 * k, 1000 * (k + 1) + 345);
    if (with_extras) table.input[100 + k] = 0;
  }
  if (!with_extras) return;
  table.input[106] = 0;
  table.before_read = [&table](int) { ++table.input[106]; };
}

double shown_mm(std::size_t k) { return static_cast<double>(k) + 1.345; }

class ModbusDials : public testing::Test {
 protected:
  std::string tcp(const ModbusTcpServer& server, const std::string& options = "unit=1") {
    return fmt::format("modbus-tcp://127.0.0.1:{}?{}", server.port(), options);
  }
  void expect_all(const std::vector<Reading>& readings) {
    ASSERT_EQ(readings.size(), 6u);
    for (std::size_t k = 0; k < 6; ++k) {
      ASSERT_TRUE(readings[k].value_mm) << readings[k].reason << " " << readings[k].detail;
      EXPECT_NEAR(*readings[k].value_mm, shown_mm(k), kExact_mm);
      EXPECT_EQ(readings[k].quality, Quality::kGood);
    }
  }

  SystemClock clock_;
  ModbusTable table_;
};

TEST_F(ModbusDials, AllSixComeFromOneReadWithOneTime) {
  fill(table_);
  ModbusTcpServer server(table_);
  const auto bank = open(rig_on(tcp(server)), clock_);
  const auto readings = answered(*bank);
  expect_all(readings);
  for (const Reading& each : readings) EXPECT_EQ(each.time_utc, readings[0].time_utc);
  EXPECT_EQ(bank->buses().size(), 1u);
}

TEST_F(ModbusDials, ReachFortyScansASecond) {
  fill(table_);
  ModbusTcpServer server(table_);
  const auto bank = open(rig_on(tcp(server)), clock_);
  (void)bank->scan({});
  constexpr int kScans = 20;
  // 25 ms a scan; a scan that begins just before another was asked for waits for the next. A
  // machine that is busy with other things may need more than one try to show it.
  EXPECT_TRUE(eventually([&] {
    const auto before = steady_clock::now();
    for (int i = 0; i < kScans; ++i) expect_all(answered(*bank));
    return steady_clock::now() - before < kScans * 200ms;
  }));
}

TEST_F(ModbusDials, ABoxWithoutStatusAndCounterIsReadAllTheSame) {
  fill(table_, false);
  ModbusTcpServer server(table_);
  const auto bank = open(rig_on(tcp(server)), clock_);
  expect_all(answered(*bank));
  expect_all(answered(*bank));
  EXPECT_EQ(server.connections(), 1);  // exceptions are answers, no reason to reconnect
}

TEST_F(ModbusDials, MapsWithOtherOrderScaleFunctionAndPlace) {
  for (int k = 0; k < 6; ++k) {
    test::put_int32(table_.holding, 40 + 2 * k, 10 * (1000 * (k + 1) + 345));
    std::swap(table_.holding[40 + 2 * k], table_.holding[41 + 2 * k]);
  }
  ModbusTcpServer server(table_);
  geometry::Rig rig = rig_on("");
  for (int k = 0; k < 6; ++k) {
    rig.dials[static_cast<std::size_t>(k)].connection = tcp(
        server, fmt::format(
                    "unit=9&base=40&scale=0.0001&word_order=low&function=3&status=none&counter="
                    "none&index={}",
                    5 - k));
  }
  const auto bank = open(rig, clock_);
  const auto readings = answered(*bank);
  for (std::size_t k = 0; k < 6; ++k) {
    ASSERT_TRUE(readings[k].value_mm) << readings[k].reason;
    EXPECT_NEAR(*readings[k].value_mm, shown_mm(5 - k), kExact_mm);
  }
}

TEST_F(ModbusDials, StatusWordsBecomeReasons) {
  fill(table_);
  table_.set([](ModbusTable& table) {
    table.input[100] = 1;
    table.input[101] = 2;
    table.input[102] = 18;
    table.input[103] = 246;
    table.input[104] = 247;
    test::put_int32(table.input, 10, std::numeric_limits<std::int32_t>::min());
  });
  ModbusTcpServer server(table_);
  const auto bank = open(rig_on(tcp(server)), clock_);
  const auto readings = answered(*bank);
  EXPECT_FALSE(readings[0].value_mm);
  EXPECT_EQ(readings[0].quality, Quality::kGood);
  EXPECT_EQ(readings[0].reason, session::reason::kNoContact);
  EXPECT_TRUE(readings[1].value_mm);
  EXPECT_EQ(readings[1].quality, Quality::kUncertain);
  EXPECT_EQ(readings[1].reason, session::reason::kLowBattery);
  EXPECT_EQ(readings[2].reason, session::reason::kRange);
  EXPECT_EQ(readings[3].reason, session::reason::kWrongDial);
  EXPECT_EQ(readings[4].reason, session::reason::kNoDial);
  EXPECT_EQ(readings[5].reason, session::reason::kDevice);
  for (std::size_t k = 2; k < 6; ++k) EXPECT_EQ(readings[k].quality, Quality::kBad);
}

TEST_F(ModbusDials, AWrongWordOrderIsNoticedByItsValues) {
  fill(table_);
  ModbusTcpServer server(table_);
  const auto bank = open(rig_on(tcp(server, "word_order=low")), clock_);
  const auto reading = answered(*bank)[0];
  EXPECT_FALSE(reading.value_mm);
  EXPECT_EQ(reading.reason, session::reason::kRange);
  EXPECT_THAT(reading.detail, HasSubstr("88145.920"));
}

TEST_F(ModbusDials, AnEndStopIsNoContact) {
  fill(table_);
  table_.set([](ModbusTable& table) { test::put_int32(table.input, 0, 4); });
  ModbusTcpServer server(table_);
  const auto bank = open(rig_on(tcp(server)), clock_);
  const auto reading = answered(*bank)[0];
  EXPECT_FALSE(reading.value_mm);
  EXPECT_EQ(reading.reason, session::reason::kNoContact);
  EXPECT_EQ(reading.quality, Quality::kGood);
}

// A box whose own scan stands still must not pass for one that measures.
TEST_F(ModbusDials, AnOldScanIsNotHandedOutAgain) {
  fill(table_);
  ModbusTcpServer server(table_);
  const auto bank = open(rig_on(tcp(server)), clock_);
  expect_all(answered(*bank));
  expect_all(answered(*bank));
  table_.set([](ModbusTable& table) { table.before_read = nullptr; });
  (void)bank->scan({});  // may still be the last that counted
  const auto reading = answered(*bank)[0];
  EXPECT_FALSE(reading.value_mm);
  EXPECT_EQ(reading.reason, session::reason::kStale);
  table_.set(
      [](ModbusTable& table) { table.before_read = [&table](int) { ++table.input[106]; }; });
  ASSERT_TRUE(eventually([&] { return bank->latest()[0].value_mm.has_value(); }));
}

TEST_F(ModbusDials, ALateReplyNeverEndsUpInAnotherReading) {
  fill(table_);
  ModbusTcpServer server(table_);
  server.set_delay([](int k) { return k == 6 ? 600 : 0; });
  const auto bank = open(rig_on(tcp(server)), clock_);
  ASSERT_TRUE(eventually([&] { return bank->buses()[0].faults > 0; }));
  EXPECT_THAT(bank->buses()[0].last_fault, HasSubstr("timeout"));
  for (int i = 0; i < 5; ++i) expect_all(answered(*bank));
  EXPECT_GE(server.connections(), 2);
  EXPECT_GE(bank->buses()[0].reconnections, 1u);
}

TEST_F(ModbusDials, RepliesToAnotherRequestOrOfAnotherUnitAreRefused) {
  fill(table_);
  struct Case {
    std::string reason;
    std::function<void(std::vector<std::uint8_t>&)> spoil;
  };
  const std::vector<Case> cases{
      {"parse", [](auto& reply) { ++reply[1]; }},      // another transaction
      {"channel", [](auto& reply) { reply[6] = 7; }},  // another unit
      {"parse", [](auto& reply) { reply[7] = 3; }},    // another function
      {"parse",
       [](auto& reply) {
         reply[5] = static_cast<std::uint8_t>(reply[5] - 2);
         reply[8] = static_cast<std::uint8_t>(reply[8] - 2);
         reply.resize(reply.size() - 2);
       }},
      {"timeout", [](auto& reply) { reply.resize(reply.size() - 3); }},  // cut off
      {"disconnected",
       [](auto& reply) {
         reply[2] = 9;
         reply.clear();
       }},
  };
  for (const Case& each : cases) {
    ModbusTcpServer server(table_);
    server.set_spoil([&](int, std::vector<std::uint8_t>& reply) { each.spoil(reply); });
    const auto bank = open(rig_on(tcp(server)), clock_);
    std::vector<Reading> readings;
    // On a busy machine the first reply may come too late to be looked at.
    const bool told = eventually([&] {
      readings = bank->scan({});
      for (const Reading& reading : readings) EXPECT_FALSE(reading.value_mm) << each.reason;
      return readings[0].reason == each.reason ||
             each.reason == session::reason::kDisconnected;  // an empty reply is a timeout
    });
    EXPECT_TRUE(told) << readings[0].reason << " " << readings[0].detail;
  }
}

TEST_F(ModbusDials, AServerThatComesBackIsTakenUpAgain) {
  fill(table_);
  auto server = std::make_unique<ModbusTcpServer>(table_);
  const int port = server->port();
  const auto bank = open(rig_on(tcp(*server)), clock_);
  expect_all(answered(*bank));
  server.reset();
  ASSERT_TRUE(
      eventually([&] { return bank->latest()[0].reason == session::reason::kDisconnected; }));
  const auto gone = bank->scan({});
  EXPECT_FALSE(gone[0].value_mm);
  EXPECT_EQ(bank->buses()[0].state, LinkState::kDown);
  server = std::make_unique<ModbusTcpServer>(table_, port);
  ASSERT_TRUE(eventually([&] { return bank->latest()[0].value_mm.has_value(); }));
  expect_all(answered(*bank));
  EXPECT_EQ(bank->buses()[0].state, LinkState::kOk);
}

TEST_F(ModbusDials, StopInTimeWhateverTheServerDoes) {
  fill(table_);
  ModbusTcpServer server(table_);
  server.set_delay([](int) { return 600'000; });
  auto bank = open(rig_on(tcp(server)), clock_);
  ASSERT_TRUE(eventually([&] { return server.requests() > 0; }));
  const auto before = steady_clock::now();
  bank.reset();
  EXPECT_LT(steady_clock::now() - before, test::kInTime);  // 300 ms on a machine at rest
}

TEST_F(ModbusDials, AreReadOverARtuLine) {
  fill(table_);
  ModbusRtuServer server(table_, 1);
  const auto bank =
      open(rig_on(fmt::format("modbus-rtu:{}?baud=19200&unit=1", server.path())), clock_);
  expect_all(answered(*bank));
  expect_all(answered(*bank));
}

// libmodbus's trap: after one late RTU reply every later one is the answer to the question
// before.
TEST_F(ModbusDials, ALateRtuReplyNeverEndsUpInAnotherReading) {
  fill(table_);
  table_.set([](ModbusTable& table) {
    // Each read of the values shows which it is: gauge k at k + n micrometres.
    table.before_read = [&table, n = 0](int address) mutable {
      ++table.input[106];
      if (address != 0) return;
      ++n;
      for (int k = 0; k < 6; ++k) test::put_int32(table.input, 2 * k, 1000 * (k + 1) + n);
    };
  });
  ModbusRtuServer server(table_, 1, [](int k) { return k == 5 ? 700 : 0; });
  const auto bank = open(rig_on(fmt::format("modbus-rtu:{}?unit=1", server.path())), clock_);
  ASSERT_TRUE(eventually([&] { return bank->buses()[0].faults > 0; }));
  std::set<double> seen;
  for (int i = 0; i < 5; ++i) {
    const auto readings = answered(*bank);
    for (std::size_t k = 0; k < 6; ++k) {
      ASSERT_TRUE(readings[k].value_mm) << readings[k].reason;
      EXPECT_NEAR(
          *readings[k].value_mm - *readings[0].value_mm, static_cast<double>(k), kExact_mm);
    }
    EXPECT_TRUE(seen.insert(*readings[0].value_mm).second) << "an old value, again";
  }
}

TEST_F(ModbusDials, AnotherUnitOnTheLineDoesNotAnswer) {
  fill(table_);
  ModbusRtuServer server(table_, 2);
  const auto bank = open(rig_on(fmt::format("modbus-rtu:{}?unit=1", server.path())), clock_);
  EXPECT_EQ(bank->scan({})[0].reason, session::reason::kTimeout);
}

// A stranger's server, started as a program of its own.
class Pymodbus {
 public:
  Pymodbus() {
    test::ModbusTable nothing;
    port_ = test::ModbusTcpServer(nothing).port();  // a free one
    int ends[2];
    if (::pipe(ends) != 0) throw std::runtime_error("no pipe");
    posix_spawn_file_actions_t actions;
    ::posix_spawn_file_actions_init(&actions);
    ::posix_spawn_file_actions_adddup2(&actions, ends[1], STDOUT_FILENO);
    ::posix_spawn_file_actions_addclose(&actions, ends[0]);
    std::string python = "/usr/bin/python3";
    std::string script = test_paths::source_dir() + "/tests/peers/pymodbus_gauges.py";
    std::string port = std::to_string(port_);
    char* arguments[] = {python.data(), script.data(), port.data(), nullptr};
    const int failed =
        ::posix_spawn(&pid_, python.c_str(), &actions, nullptr, arguments, environ);
    ::posix_spawn_file_actions_destroy(&actions);
    ::close(ends[1]);
    char byte = 0;
    ready_ = failed == 0 && ::read(ends[0], &byte, 1) == 1 && byte == 'r';
    out_ = ends[0];  // open to the end: it may print more
  }
  ~Pymodbus() {
    ::close(out_);
    if (pid_ <= 0) return;
    ::kill(pid_, SIGKILL);
    ::waitpid(pid_, nullptr, 0);
  }
  Pymodbus(const Pymodbus&) = delete;
  Pymodbus& operator=(const Pymodbus&) = delete;
  [[nodiscard]] bool ready() const { return ready_; }
  [[nodiscard]] int port() const { return port_; }

 private:
  pid_t pid_ = -1;
  int out_ = -1;
  int port_ = 0;
  bool ready_ = false;
};

TEST_F(ModbusDials, ReadTheIndependentServerOfPymodbus) {
  const Pymodbus peer;
  ASSERT_TRUE(peer.ready()) << "needs Debian's python3-pymodbus";
  const std::vector<double> shown{1.345, 2.345, 3.345, 4.345, 5.345, -0.045};
  for (const auto& [options, tolerance_mm] :
       {std::pair{"unit=1", kExact_mm},
        std::pair{"unit=1&base=200&word_order=low&function=3", kExact_mm},
        std::pair{"unit=1&format=float32", kFloat_mm}}) {
    const auto bank =
        open(rig_on(fmt::format("modbus-tcp://127.0.0.1:{}?{}", peer.port(), options)), clock_);
    std::vector<Reading> readings;
    ASSERT_TRUE(eventually([&] {
      readings = bank->scan({});
      return readings[0].value_mm.has_value();
    })) << readings[0].reason
        << " " << readings[0].detail;
    for (std::size_t k = 0; k < 6; ++k) {
      ASSERT_TRUE(readings[k].value_mm) << options << " " << readings[k].reason;
      EXPECT_NEAR(*readings[k].value_mm, shown[k], tolerance_mm) << options;
    }
  }
}

}  // namespace
}  // namespace sixdial::acquisition
