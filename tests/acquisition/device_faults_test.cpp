// Each of the mock rig's faults, ordered while a session is collected over real bytes: what the
// operator is told, what is stored, how soon it is noticed and how long recovery takes.
#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <future>
#include <map>
#include <set>

#include "acquisition/collector.h"
#include "acquisition/dial_bank.h"
#include "acquisition/robot.h"
#include "mock_devices/mock_rig.h"
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

constexpr std::size_t kDial = 0;  // "A": its neighbour B faces it, so that mixing them shows

struct Case {
  Fault fault;
  const char* connection;
  Quality stored;
  std::set<std::string> reasons;  // any of them; "" is good
  double amount = 0.0;            // of the order; 0: the fault's own
  bool felt = true;               // a single reading shows it; else only a moved robot does
};

// What must be stored for the dial at the next point while the fault lasts.
const std::vector<Case>& cases() {
  static const std::vector<Case> kCases{
      {Fault::kSilent, "sylvac", Quality::kBad, {"timeout"}},
      {Fault::kLate, "sylvac", Quality::kBad, {"timeout"}, 0.4},
      {Fault::kTruncated, "sylvac", Quality::kBad, {"parse"}},
      {Fault::kStrayLf, "sylvac", Quality::kGood, {""}, 0, false},
      {Fault::kErrorLine, "sylvac", Quality::kBad, {"device", "range"}},
      {Fault::kBusy, "mux10", Quality::kBad, {"busy"}},
      {Fault::kWrongChannel, "mux10", Quality::kBad, {"channel"}},
      {Fault::kInch, "sylvac", Quality::kBad, {"unit"}},
      {Fault::kFrozen, "sylvac", Quality::kBad, {"frozen"}, 0, false},
      {Fault::kUnsolicitedLine, "sylvac", Quality::kBad, {"frozen"}, 0, false},
      {Fault::kPowerOnLine, "sylvac", Quality::kGood, {""}, 0, false},
      {Fault::kLowBattery, "modbus-tcp", Quality::kUncertain, {"low battery"}},
      {Fault::kZeroPressed,
       "sylvac",
       Quality::kUncertain,
       {"implausible", "no contact", "range"},
       0,
       false},
      {Fault::kHangUp, "sylvac", Quality::kBad, {"disconnected"}, 8.0},
      {Fault::kNoiseByte, "sylvac", Quality::kBad, {"parse", "range", "unit", "unsettled"}},
      {Fault::kCrcError, "modbus_rtu", Quality::kBad, {"parse"}},
      {Fault::kWrongUnitId, "modbus-tcp", Quality::kBad, {"channel"}},
      {Fault::kException, "modbus-tcp", Quality::kBad, {"device"}},
      // The same trouble on another cable.
      {Fault::kSilent, "modbus-tcp", Quality::kBad, {"timeout"}},
      {Fault::kLate, "modbus_rtu", Quality::kBad, {"timeout"}, 0.4},
      {Fault::kLate, "modbus-tcp", Quality::kBad, {"timeout"}, 0.4},
      {Fault::kHangUp, "modbus-tcp", Quality::kBad, {"disconnected", "timeout"}, 8.0},
      {Fault::kInch, "mahr", Quality::kBad, {"unit"}},
      {Fault::kFrozen, "modbus-tcp", Quality::kBad, {"frozen"}, 0, false},
      {Fault::kSilent, "mw", Quality::kBad, {"timeout"}}};
  return kCases;
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
    const auto robot = parse_robot_connection(rig_.robot.connection);
    robot_ = std::make_unique<ModbusRobot>(std::get<ModbusConnection>(robot.value()), clock_);
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
      point.target_mm = {18.0 + 3 * i, 44.0 + 4 * i};
      point.q_rad =
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

bool good_now(DialBank& bank, DeviceTime since) {
  const Reading reading = bank.latest()[kDial];
  return reading.quality == Quality::kGood && reading.value_mm && reading.requested >= since;
}

void order(Bench& bench, const Case& each, double hang_up_s) {
  mock_devices::FaultOrder order;
  order.fault = each.fault;
  order.count = 0;
  order.connection = each.connection;
  if (each.amount > 0) order.amount = each.amount;
  if (each.fault == Fault::kHangUp) order.amount = hang_up_s;
  bench.mock().order_fault("A", order);
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
  const auto good = [&] { return good_now(bench.bank(), DeviceTime{0}); };
  if (!eventually(good, 20s)) {
    outcome.broken = "the dial never answered: " + bench.bank().latest()[kDial].reason;
    return outcome;
  }
  if (!each.felt) return outcome;
  for (int i = 0; i < repeats; ++i) {
    const auto from = steady_clock::now();
    order(bench, each, 0.5);
    if (!eventually([&] { return !good(); }, 20s)) {
      outcome.broken = "never noticed";
      return outcome;
    }
    outcome.noticed_ms.push_back(ms_since(from));
    const bool comes_back_by_itself = each.fault == Fault::kHangUp;
    bench.mock().clear_faults();
    const auto well = steady_clock::now() + (comes_back_by_itself ? 500ms : 0ms);
    if (!eventually(good, 30s)) {
      outcome.broken = "did not recover: " + bench.bank().latest()[kDial].reason;
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
  return values[static_cast<std::size_t>(share * last + 0.5)];
}

TEST(DeviceFaults, EachOfTheEighteenIsNoticedStoredWithItsReasonAndGotOver) {
  const int repeats = test::size_of_run("SIXDIAL_FAULT_REPEATS", 1);
  const double speed = test::size_of_run("SIXDIAL_FAULT_SPEED", 20);
  std::vector<std::future<Outcome>> running;
  std::set<Fault> tried;
  for (const Case& each : cases()) {
    tried.insert(each.fault);
    running.push_back(std::async(std::launch::async, [&each, repeats, speed] {
      return try_fault(each, repeats, speed);
    }));
  }
  EXPECT_EQ(tried.size(), mock_devices::fault_names().size());
  std::vector<double> all_recovered;
  for (std::size_t i = 0; i < cases().size(); ++i) {
    const Case& each = cases()[i];
    const Outcome outcome = running[i].get();
    SCOPED_TRACE(name_of(each));
    EXPECT_EQ(outcome.broken, "");
    ASSERT_EQ(outcome.stored.size(), 3U) << "no point may be dropped: " << outcome.failed;
    EXPECT_EQ(outcome.stored[0].sample.dials[kDial].quality, Quality::kGood)
        << outcome.stored[0].sample.dials[kDial].reason;
    // The fault came after the first point: at the second or the third it must be on record.
    const auto shows = [&](const CollectedSample& collected) {
      const session::DialValue& stored = collected.sample.dials[kDial];
      const bool quality = each.stored == Quality::kGood ? stored.quality == Quality::kGood
                                                         : stored.quality != Quality::kGood;
      return quality && each.reasons.contains(stored.reason);
    };
    const auto seen = std::find_if(outcome.stored.begin() + 1, outcome.stored.end(), shows);
    ASSERT_NE(seen, outcome.stored.end())
        << outcome.stored[1].sample.dials[kDial].reason << ", "
        << outcome.stored[2].sample.dials[kDial].reason;
    const session::DialValue& stored = seen->sample.dials[kDial];
    if (stored.quality == Quality::kBad && stored.reason != "frozen") {
      EXPECT_FALSE(stored.value_mm) << "an old or doubtful value must not be kept as one";
    }
    // And a person is told which dial and why.
    std::string told = outcome.paused;
    for (const std::string& remark : seen->remarks) told += (told.empty() ? "" : "; ") + remark;
    if (each.stored != Quality::kGood) {
      EXPECT_THAT(told, HasSubstr("dial A: " + stored.reason));
    }
    std::printf(
        "FAULT %s|%s|%s|%s|%s|%.0f|%.0f|%.0f|%.0f\n",
        std::string(to_string(each.fault)).c_str(), each.connection,
        std::string(to_string(stored.quality)).c_str(),
        stored.reason.empty() ? "-" : stored.reason.c_str(), told.substr(0, 110).c_str(),
        quantile(outcome.noticed_ms, 0.5), quantile(outcome.noticed_ms, 0.99),
        quantile(outcome.recovered_ms, 0.5), quantile(outcome.recovered_ms, 0.99));
    all_recovered.insert(
        all_recovered.end(), outcome.recovered_ms.begin(), outcome.recovered_ms.end());
  }
  test::figure("faults.orderable", mock_devices::fault_names().size());
  test::figure("faults.recoveries", all_recovered.size());
  test::figure("faults.recovery_median_ms", quantile(all_recovered, 0.5));
  test::figure("faults.recovery_p99_ms", quantile(all_recovered, 0.99));
}

TEST(DeviceFaults, TwoCablesPluggedTheWrongWayAreNamed) {
  Bench bench("sylvac", 20.0);
  std::swap(bench.rig().dials[0].connection, bench.rig().dials[1].connection);
  bench.connect();
  const auto stored = bench.collect([] {});
  ASSERT_EQ(stored.size(), 3U);
  // At x = 18 mm A and B are 20 mm apart; at 28 mm both would fit.
  const CollectedSample& first = stored.front();
  EXPECT_EQ(first.sample.dials[0].reason, "implausible");
  EXPECT_EQ(first.sample.dials[1].reason, "implausible");
  EXPECT_EQ(first.sample.dials[0].quality, Quality::kUncertain);
  EXPECT_THAT(fmt::format("{}", fmt::join(first.remarks, "; ")), HasSubstr("swapped"));
}

}  // namespace
}  // namespace sixdial::acquisition
