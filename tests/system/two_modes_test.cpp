// One session in two working modes, from the plan to the result, by the commands a person
// types: mock rig, service, command line.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <fstream>
#include <sstream>

#include "cli/cli.h"
#include "mock_devices/iso_time.h"
#include "mock_devices/mock_rig.h"
#include "session/csv.h"
#include "session/plan.h"
#include "session/rig_file.h"
#include "tests/support/rig_for_tests.h"

namespace sixdial {
namespace {

using sixdial::Json;
using ::testing::HasSubstr;

constexpr double kSpeed = 80.0;  // rig seconds a wall second
// The instant of a reading draws its noise, so no two runs are the same. With ten parameters
// four standard deviations are exceeded once in some 750 runs, six in none that anyone will
// see.
constexpr double kSigmas = 6.0;
// A position from three dials of 0.002 mm noise, and what 50 points leave of the parameters.
constexpr double kPosition_mm = 0.008;

struct Outcome {
  int code = -1;
  std::string out, err;
};

Outcome sixdial_command(std::vector<std::string> words, const std::string& socket) {
  words.insert(words.begin(), "sixdial");
  words.insert(words.end(), {"--socket", socket});
  std::vector<const char*> arguments;
  for (const std::string& word : words) arguments.push_back(word.c_str());
  std::ostringstream out;
  std::ostringstream err;
  Outcome outcome;
  outcome.code = cli::run(static_cast<int>(arguments.size()), arguments.data(), out, err);
  outcome.out = out.str();
  outcome.err = err.str();
  return outcome;
}

TEST(TwoModes, FromThePlanToTheResultOnTheMockRig) {
  mock_devices::MockRigOptions options;
  options.world.rig = geometry::default_rig();
  options.world.robot.parameters = geometry::table_2_robot();
  options.world.dials.curve_mm = 0.0;
  options.world.dials.hysteresis_mm = 0.0;
  options.world.seed = 31;
  options.clock_speed = kSpeed;
  mock_devices::MockRig mock(options);
  mock.start();
  service::ServiceOptions service_options;
  service_options.clock_speed = kSpeed;
  service_options.clock_start = session::from_iso8601(mock_devices::iso8601(mock.utc_ms()));
  testing::RunningService running({}, service_options);
  const std::string socket = running.socket_path().string();
  const auto path = [&](const char* name) { return (running.directory() / name).string(); };
  std::ofstream(path("rig.toml")) << session::write_rig(mock.connected_rig("modbus-tcp"));

  const Outcome planned = sixdial_command(
      {"plan", "grid", "--rig", path("rig.toml"), "--mode=++,-+", "--nx", "4", "--ny", "6",
       "-o", path("g1.csv")},
      socket);
  ASSERT_EQ(planned.code, 0) << planned.err;
  EXPECT_THAT(planned.err, HasSubstr("48 points in"));
  EXPECT_THAT(planned.err, HasSubstr("before G1 point 24 an operator"));
  const Outcome judged = sixdial_command(
      {"plan", "random", "--rig", path("rig.toml"), "--mode=-+,++", "--count", "5", "--set",
       "G2", "-o", path("g2.csv")},
      socket);
  ASSERT_EQ(judged.code, 0) << judged.err;
  const std::string g2 = session::read_file(path("g2.csv"));
  std::ofstream(path("plan.csv"))
      << session::read_file(path("g1.csv")) << g2.substr(g2.find('\n') + 1);

  const Outcome refused =
      sixdial_command({"plan", "grid", "--rig", path("rig.toml"), "--mode=++,+-"}, socket);
  EXPECT_EQ(refused.code, 5);
  EXPECT_THAT(refused.err, HasSubstr("in working mode +-"));

  const Outcome collected = sixdial_command(
      {"collect", path("plan.csv"), "--session", "both", "--rig", path("rig.toml"),
       "--on-mode-change", "go"},
      socket);
  ASSERT_EQ(collected.code, 0) << collected.err;
  EXPECT_THAT(collected.out, HasSubstr("58 of 58 points, 58 stored now"));
  EXPECT_THAT(
      collected.err, HasSubstr("estimate after 48 samples: positions are known to 0.0"));
  EXPECT_THAT(collected.err, HasSubstr("working mode -+ (assembly -1) follows on ++"));
  EXPECT_THAT(collected.out, HasSubstr("l11 "));

  const Outcome shown = sixdial_command({"session", "show", "both"}, socket);
  EXPECT_THAT(shown.out, HasSubstr(": every point of the plan was measured"));

  const Outcome calibrated = sixdial_command({"calibrate", "both", "--json", "-q"}, socket);
  ASSERT_EQ(calibrated.code, 0) << calibrated.err;
  const Json document = Json::parse(calibrated.out);
  const Json& assessment = document["assessment"];
  EXPECT_EQ(assessment["samples"], 48) << "every point has a position";
  ASSERT_EQ(assessment["working_modes"].size(), 2U);
  const auto pooled = assessment["identifiability"]["condition"].get<double>();
  for (const Json& mode : assessment["working_modes"]) {
    EXPECT_EQ(mode["samples"], 24);
    EXPECT_LT(pooled, 0.8 * mode["condition"].get<double>());
  }
  const geometry::ParameterVector robot = geometry::table_2_robot();
  for (int i = 0; i < geometry::kParameterCount; ++i) {
    const Json& each = assessment["parameters"][static_cast<std::size_t>(i)];
    EXPECT_LT(
        std::abs(each["identified"].get<double>() - robot[i]),
        kSigmas * each["sd"].get<double>())
        << each;
  }
  bool found = false;
  for (const Json& method : document["methods"]) {
    if (method["id"] != "ekf_dqpso") continue;
    found = true;
    EXPECT_EQ(method["g2"]["points"], 10) << method;
    EXPECT_LT(method["g2"]["mean_mm"].get<double>(), kPosition_mm);
  }
  EXPECT_TRUE(found);

  const Outcome compared =
      sixdial_command({"compare", "both", "--methods", "before,lm,ekf"}, socket);
  ASSERT_EQ(compared.code, 0) << compared.err;
  EXPECT_THAT(compared.out, HasSubstr("condition number by working mode: ++ "));
  EXPECT_THAT(compared.out, HasSubstr("pooled "));

  const Outcome next = sixdial_command(
      {"plan", "next", "both", "--points", "6", "-o", path("next.csv")}, socket);
  ASSERT_EQ(next.code, 0) << next.err;
  EXPECT_THAT(next.err, HasSubstr("48 samples of G1"));
  const Outcome more = sixdial_command(
      {"collect", path("next.csv"), "--session", "both", "--on-mode-change", "go"}, socket);
  EXPECT_EQ(more.code, 0) << more.err;
  EXPECT_THAT(more.out, HasSubstr("6 stored now"));
  EXPECT_THAT(more.out, HasSubstr("estimate after 54 samples"));
}

}  // namespace
}  // namespace sixdial
