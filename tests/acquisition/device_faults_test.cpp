// Each of the mock rig's faults, ordered while a session is collected over real bytes: what the
// operator is told, what is stored, how soon it is noticed and how long recovery takes.
#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <future>
#include <map>
#include <set>

#include "acquisition/collector.h"
#include "acquisition/dial_bank.h"
#include "acquisition/robots/modbus_robot.h"
#include "mock_devices/mock_rig.h"
#include "session/reason.h"
#include "tests/acquisition/device_fault_cases.h"
#include "tests/acquisition/wire.h"
#include "tests/support/figure.h"

namespace sixdial::acquisition {
namespace {

using namespace std::chrono_literals;
using mock_devices::Fault;
using session::Quality;
using std::chrono::steady_clock;
using test::eventually;
using test::TemporaryFolder;
using testing::HasSubstr;

// Each dial has its turn; the first of a fault is the same dial in every run.
std::size_t dial_of(const Case& each) {
  return each.dial.value_or(static_cast<std::size_t>(&each - kCases.data()) % 6);
}

std::string name_of(const Case& each) {
  return fmt::format("{}.{}", to_string(each.fault), each.connection);
}

// A mock rig on one kind of cable, with everything that reads it.
class Bench {
 public:
  Bench(const std::string& connection, double speed)
      : clock_(speed, session::from_iso8601("2026-03-02T08:30:00Z").value()),
        mock_(options(connection, speed)) {
    mock_.start();
    rig_ = mock_.connected_rig(connection);
  }
  void connect() {
    const auto robot = parse_modbus_robot(rig_.robot.connection);
    robot_ = std::make_unique<ModbusRobot>(robot.value(), clock_);
    bank_ = std::move(DialBank::open(rig_, clock_).value());
  }
  mock_devices::MockRig& mock() { return mock_; }
  geometry::Rig& rig() { return rig_; }
  DialBank& bank() { return *bank_; }

  /// Three points; `between` is called once the first is stored.
  std::vector<CollectedSample> collect(const std::function<void()>& between) {
    session::Plan plan;
    const Eigen::Vector2d near =
        geometry::inverse(rig_.robot.nominal, {28, 48}, rig_.robot.working_mode).value();
    for (int i = 0; i < 3; ++i) {
      session::PlanPoint point;
      point.set = "G1";
      point.point = i;
      point.target_mm = Eigen::Vector2d(18.0 + 3 * i, 44.0 + 4 * i);
      point.q =
          geometry::inverse(rig_.robot.nominal, point.target_mm, rig_.robot.working_mode, near)
              .value();
      plan.points.push_back(point);
    }
    std::vector<CollectedSample> stored;
    Collector::Callbacks callbacks;
    callbacks.store = [&](const CollectedSample& sample) {
      stored.push_back(sample);
      if (stored.size() == 1) between();
    };
    std::stop_source stop;
    callbacks.progress = [&](const CollectorProgress& progress) {
      if (on_stage && progress.plan_index) on_stage(progress.stage, *progress.plan_index);
      if (progress.stage == CollectorStage::kPaused) {
        paused_ = progress.message;  // no dial answers at all
        accept_();
      }
    };
    CollectorSettings settings;
    settings.settle_timeout = 60s;
    settings.fault_retries = 1;
    Collector collector(rig_, plan, *robot_, *bank_, clock_, callbacks, settings);
    accept_ = [&collector] { collector.accept(); };
    const CollectorResult result = collector.run(stop.get_token());
    for (const CollectorResult::Point& point : result.failed) failed_ += point.why + "; ";
    return stored;
  }
  std::function<void(CollectorStage stage, std::size_t index)> on_stage;  // while it collects
  [[nodiscard]] const std::string& id(std::size_t dial) const { return rig_.dials[dial].id; }
  [[nodiscard]] const std::string& paused() const { return paused_; }
  [[nodiscard]] const std::string& failed() const { return failed_; }

 private:
  mock_devices::MockRigOptions options(const std::string& connection, double speed) {
    mock_devices::MockRigOptions options;
    options.world.robot.parameters = geometry::table_2_robot();
    options.clock_speed = speed;
    if (connection == "modbus-tcp") return options;
    options.pty_directory = folder_.path("ptys");
    options.dialects = {connection};
    return options;
  }
  TemporaryFolder folder_;
  AcceleratedClock clock_;
  mock_devices::MockRig mock_;
  geometry::Rig rig_;
  std::unique_ptr<ModbusRobot> robot_;
  std::unique_ptr<DialBank> bank_;
  std::string paused_, failed_;
  std::function<void()> accept_;
};

struct Outcome {
  std::string broken;  // what did not come
  std::vector<CollectedSample> stored;
  std::string paused, failed;
  std::vector<double> noticed_ms, recovered_ms;
};

double ms_since(steady_clock::time_point from) {
  return std::chrono::duration<double, std::milli>(steady_clock::now() - from).count();
}

bool good_now(DialBank& bank, std::size_t dial, DeviceTime since) {
  const Reading reading = bank.latest()[dial];
  return reading.quality == Quality::kGood && reading.value_mm && reading.requested >= since;
}

void order(Bench& bench, const Case& each, double hang_up_s) {
  mock_devices::FaultOrder order;
  order.fault = each.fault;
  order.count = 0;
  order.connection = each.connection;
  if (each.amount > 0) order.amount = each.amount;
  if (each.fault == Fault::kHangUp) order.amount = hang_up_s;
  bench.mock().order_fault(bench.id(dial_of(each)), order);
}

Outcome try_fault(const Case& each, int repeats, double speed) {
  Outcome outcome;
  {
    Bench bench(each.connection, speed);
    bench.connect();
    outcome.stored = bench.collect([&] { order(bench, each, each.amount); });
    outcome.paused = bench.paused();
    outcome.failed = bench.failed();
  }
  Bench bench(each.connection, speed);
  bench.connect();
  const auto good = [&] { return good_now(bench.bank(), dial_of(each), DeviceTime{0}); };
  if (!eventually(good)) {
    outcome.broken = "the dial never answered: " + bench.bank().latest()[dial_of(each)].reason;
    return outcome;
  }
  if (!each.felt) return outcome;
  for (int i = 0; i < repeats; ++i) {
    const auto from = steady_clock::now();
    order(bench, each, 0.5);
    if (!eventually([&] { return !good(); })) {
      outcome.broken = "never noticed";
      return outcome;
    }
    outcome.noticed_ms.push_back(ms_since(from));
    const bool comes_back_by_itself = each.fault == Fault::kHangUp;
    bench.mock().clear_faults();
    const auto well = steady_clock::now() + (comes_back_by_itself ? 500ms : 0ms);
    if (!eventually(good)) {
      outcome.broken = "did not recover: " + bench.bank().latest()[dial_of(each)].reason;
      return outcome;
    }
    outcome.recovered_ms.push_back(std::max(0.0, ms_since(well)));
  }
  return outcome;
}

double quantile(std::vector<double> values, double share) {
  if (values.empty()) return 0.0;
  std::ranges::sort(values);
  const auto last = static_cast<double>(values.size() - 1);
  return values[static_cast<std::size_t>(std::lround(share * last))];
}

// What concerns one dial in "no dial answers: dial A: timeout, ...; dial B: ...".
std::string told_of(const std::string& dial, const std::string& told) {
  const std::size_t from = told.find("dial " + dial + ":");
  if (from == std::string::npos) return told;
  return told.substr(from, told.find("; dial ", from) - from);
}

void judge(const Case& each, const Outcome& outcome, const std::string& id) {
  EXPECT_EQ(outcome.broken, "");
  ASSERT_EQ(outcome.stored.size(), 3U) << "no point may be dropped: " << outcome.failed;
  const std::size_t dial = dial_of(each);
  EXPECT_EQ(outcome.stored[0].sample.channels[dial].quality, Quality::kGood)
      << outcome.stored[0].sample.channels[dial].reason;
  // The fault came after the first point: at the second or the third it must be on record.
  const auto shows = [&](const CollectedSample& collected) {
    const session::ChannelValue& stored = collected.sample.channels[dial];
    const bool quality = each.stored == Quality::kGood ? stored.quality == Quality::kGood
                                                       : stored.quality != Quality::kGood;
    return quality && each.reasons.contains(stored.reason);
  };
  const auto seen = std::find_if(outcome.stored.begin() + 1, outcome.stored.end(), shows);
  ASSERT_NE(seen, outcome.stored.end())
      << outcome.stored[1].sample.channels[dial].reason << ", "
      << outcome.stored[2].sample.channels[dial].reason;
  const session::ChannelValue& stored = seen->sample.channels[dial];
  if (stored.quality == Quality::kBad && stored.reason != "frozen") {
    EXPECT_FALSE(stored.value) << "an old or doubtful value must not be kept as one";
  }
  // And a person is told which dial and why.
  std::string told = outcome.paused;
  for (const std::string& remark : seen->remarks) told += (told.empty() ? "" : "; ") + remark;
  if (each.stored != Quality::kGood) {
    EXPECT_THAT(told, HasSubstr("dial " + id + ": " + stored.reason));
  }
  std::printf(
      "FAULT %s|%s|%s|%s|%s|%s|%.0f|%.0f|%.0f|%.0f\n",
      std::string(to_string(each.fault)).c_str(), each.connection, id.c_str(),
      std::string(to_string(stored.quality)).c_str(),
      stored.reason.empty() ? "-" : stored.reason.c_str(),
      told_of(id, told).substr(0, 110).c_str(), quantile(outcome.noticed_ms, 0.5),
      quantile(outcome.noticed_ms, 0.99), quantile(outcome.recovered_ms, 0.5),
      quantile(outcome.recovered_ms, 0.99));
}

/// Before any fault was ordered the dial did not answer in time: the machine stood still, and
/// the trial says nothing.
bool machine_stood_still(const Case& each, const Outcome& outcome) {
  return !outcome.stored.empty() &&
         outcome.stored[0].sample.channels[dial_of(each)].reason == session::reason::kTimeout;
}

// A rig has up to eight threads, which a sanitizer makes ten times slower.
#ifdef SIXDIAL_SANITIZED
constexpr int kUsualSpeed = 4;
constexpr std::size_t kRigsAtOnce = 4;
#else
constexpr int kUsualSpeed = 20;
constexpr std::size_t kRigsAtOnce = 16;
#endif

TEST(DeviceFaults, EachOfTheEighteenIsNoticedStoredWithItsReasonAndGotOverOnEveryCable) {
  const int repeats = test::size_of_run("SIXDIAL_FAULT_REPEATS", 1);
  const double speed = test::size_of_run("SIXDIAL_FAULT_SPEED", kUsualSpeed);
  // Figures are taken with fewer: these shall not wait for each other.
  const std::size_t at_once = repeats > 1 ? 4 : kRigsAtOnce;
  std::set<Fault> tried;
  std::set<std::size_t> dials;
  std::vector<double> all_recovered;
  const geometry::Rig rig = geometry::default_rig();
  for (std::size_t from = 0; from < kCases.size(); from += at_once) {
    const std::size_t to = std::min(from + at_once, kCases.size());
    std::vector<std::future<Outcome>> running;
    for (std::size_t i = from; i < to; ++i) {
      running.push_back(std::async(std::launch::async, [i, repeats, speed] {
        return try_fault(kCases[i], repeats, speed);
      }));
    }
    for (std::size_t i = from; i < to; ++i) {
      const Case& each = kCases[i];
      tried.insert(each.fault);
      dials.insert(dial_of(each));
      Outcome outcome = running[i - from].get();
      constexpr int kMostAgain = 3;  // a dial that never answers is no loaded machine
      for (int k = 0; k < kMostAgain && machine_stood_still(each, outcome); ++k) {
        outcome = try_fault(each, repeats, speed);
      }
      SCOPED_TRACE(name_of(each));
      judge(each, outcome, rig.dials[dial_of(each)].id);
      all_recovered.insert(
          all_recovered.end(), outcome.recovered_ms.begin(), outcome.recovered_ms.end());
    }
  }
  EXPECT_EQ(tried.size(), mock_devices::fault_names().size());
  EXPECT_EQ(dials.size(), 6U) << "any dial";
  test::figure("faults.orderable", mock_devices::fault_names().size());
  test::figure("faults.pairs", kCases.size());
  test::figure("faults.recoveries", all_recovered.size());
  test::figure("faults.recovery_median_ms", quantile(all_recovered, 0.5));
  test::figure("faults.recovery_p99_ms", quantile(all_recovered, 0.99));
}

TEST(DeviceFaults, OrderedWhileTheRobotMovesOrTheDialsSettleIsOnRecordAtThatPointOnly) {
  constexpr std::size_t kD = 3;
  for (const CollectorStage when : {CollectorStage::kMoving, CollectorStage::kSettling}) {
    SCOPED_TRACE(to_string(when));
    Bench bench("sylvac", 5.0);  // a time-out of 300 ms must not be a loaded machine's own
    bench.connect();
    int ordered = 0;
    bench.on_stage = [&](CollectorStage stage, std::size_t index) {
      if (index == 1 && stage == when && ordered++ == 0) {
        bench.mock().order_fault("D", {.fault = Fault::kSilent, .count = 0});
      }
      if (index == 2 && stage == CollectorStage::kMoving) {
        bench.mock().clear_faults();
        EXPECT_TRUE(eventually(
            [&] {
              return std::ranges::all_of(bench.bank().latest(), [](const Reading& each) {
                return each.quality == Quality::kGood;
              });
            },
            20s));
      }
    };
    const auto stored = bench.collect([] {});
    ASSERT_EQ(stored.size(), 3U) << bench.failed();
    EXPECT_GT(ordered, 0);
    EXPECT_EQ(stored[1].sample.channels[kD].reason, session::reason::kTimeout);
    EXPECT_FALSE(stored[1].sample.channels[kD].value);
    EXPECT_THAT(
        fmt::format("{}", fmt::join(stored[1].remarks, "; ")), HasSubstr("dial D: timeout"));
    for (std::size_t i = 0; i < 6; ++i) {
      EXPECT_EQ(stored[1].sample.channels[i].quality, i == kD ? Quality::kBad : Quality::kGood)
          << i;
      EXPECT_EQ(stored[0].sample.channels[i].quality, Quality::kGood) << i;
      EXPECT_EQ(stored[2].sample.channels[i].quality, Quality::kGood) << i << ": not recovered";
    }
  }
}

// A cable's dial tells its battery only when asked, every half minute: half of a second here.
TEST(DeviceFaults, ALowBatteryBehindACableIsNoticedAndItsReadingKept) {
  constexpr std::size_t kC = 2;
  Bench bench("sylvac", 60.0);
  bench.connect();
  const auto newest = [&] { return bench.bank().latest()[kC]; };
  ASSERT_TRUE(eventually([&] { return newest().quality == Quality::kGood; }));
  bench.mock().order_fault("C", {.fault = Fault::kLowBattery, .count = 0});
  ASSERT_TRUE(eventually([&] { return newest().reason == session::reason::kLowBattery; }))
      << newest().reason;
  const Reading reading = newest();
  EXPECT_EQ(reading.quality, Quality::kUncertain);
  EXPECT_TRUE(reading.value_mm) << "the dial still measures";
  EXPECT_EQ(bench.bank().latest()[kC + 1].quality, Quality::kGood);
  bench.mock().clear_faults();
  EXPECT_TRUE(eventually([&] { return newest().quality == Quality::kGood; }));
}

TEST(DeviceFaults, TwoCablesPluggedTheWrongWayAreNamed) {
  Bench bench("sylvac", 20.0);
  std::swap(bench.rig().dials[0].connection, bench.rig().dials[1].connection);
  bench.connect();
  const auto stored = bench.collect([] {});
  ASSERT_EQ(stored.size(), 3U);
  // At x = 18 mm A and B are 20 mm apart; at 28 mm both would fit.
  const CollectedSample& first = stored.front();
  EXPECT_EQ(first.sample.channels[0].reason, session::reason::kImplausible);
  EXPECT_EQ(first.sample.channels[1].reason, session::reason::kImplausible);
  EXPECT_EQ(first.sample.channels[0].quality, Quality::kUncertain);
  EXPECT_THAT(fmt::format("{}", fmt::join(first.remarks, "; ")), HasSubstr("swapped"));
}

}  // namespace
}  // namespace sixdial::acquisition
