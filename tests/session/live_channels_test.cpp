// Draw wires and dials on stands: what is collected, and what studies see of it.
#include "session/live_channels.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>

#include "session/bundle.h"
#include "session/data_error.h"
#include "session/plan.h"
#include "session/rig_file.h"
#include "session/rig_write.h"
#include "session/trials.h"

namespace sixdial::session {
namespace {

using testing::HasSubstr;

constexpr const char* kArm = R"(name = "arm under wires"
[robot]
model = "serial"
tool_x_mm = 50.0
connection = "manual"
[[joint]]
d_mm = 300.0
alpha_deg = 90.0
[[joint]]
a_mm = 250.0
[[joint]]
a_mm = 200.0
)";
constexpr const char* kWires = R"([instrument]
kind = "distance"
sd_mm = 0.05
[[anchor]]
name = "K1"
at_mm = [1000.0, 0.0, 0.0]
[[anchor]]
name = "K2"
[dials]
travel_mm = 2500.0
resolution_mm = 0.01
repeatability_mm = 0.02
[[dial]]
id = "K2"
connection = "modbus-tcp://127.0.0.1:1502"
[[dial]]
id = "K1"
connection = "modbus-tcp://127.0.0.1:1502"
)";

geometry::Rig rig() { return parse_rig(std::string(kArm) + kWires, "rig.toml"); }

std::string refusal(std::string text, const std::string& from, const std::string& to) {
  text.replace(text.find(from), from.size(), to);
  try {
    (void)parse_rig(std::string(kArm) + text, "rig.toml");
  } catch (const DataError& error) {
    return error.what();
  }
  return "";
}

Sample sample_of_dials() {
  Sample sample;
  sample.set = "G1";
  sample.q = Eigen::Vector3d(0.1, 0.2, 0.3);
  sample.channels = {{.value = 812.34}, {.value = 640.5}};  // K2, K1
  return sample;
}

TEST(LiveChannels, EachDialReadsThePlaceOfItsName) {
  ASSERT_TRUE(has_live_channels(rig()));
  const Sample seen = as_instrument(rig(), sample_of_dials());
  EXPECT_TRUE(seen.channels.empty());
  ASSERT_EQ(seen.others.size(), 2u);
  EXPECT_EQ(seen.others[0], 640.5) << "K1 is the first anchor and the second dial";
  EXPECT_EQ(seen.others[1], 812.34);
  const Sample back = as_dials(rig(), seen);
  EXPECT_EQ(back.channels[0].value, 812.34);
  EXPECT_EQ(back.channels[1].value, 640.5);
}

TEST(LiveChannels, ABadReadingIsNoneAndAnEmptyOneStaysEmpty) {
  Sample sample = sample_of_dials();
  sample.channels[0].quality = Quality::kBad;
  sample.channels[1].value.reset();
  const Sample seen = as_instrument(rig(), sample);
  EXPECT_FALSE(seen.others[0]);
  EXPECT_FALSE(seen.others[1]);
}

TEST(LiveChannels, ADialThatIsPushedInIsBehindTheSurface) {
  const geometry::Rig probe = parse_rig(
      std::string(kArm) +
          "[instrument]\nkind = \"probe\"\n[[surface]]\nname = \"bed\"\n[[dial]]\nid = "
          "\"bed\"\n"
          "travel_mm = 12.7\nresolution_mm = 0.001\nrepeatability_mm = 0.002\n",
      "rig.toml");
  Sample sample = sample_of_dials();
  sample.channels = {{.value = 1.25}};
  EXPECT_EQ(as_instrument(probe, sample).others.at(0), -1.25);
}

TEST(LiveChannels, TheRigOfTheStudiesHasNoDialsAndOthersStayAsTheyAre) {
  EXPECT_TRUE(as_instrument(rig()).dials.empty());
  EXPECT_EQ(layout_of(as_instrument(rig())).others.size(), 2u);
  const geometry::Rig cuboid = geometry::default_rig();
  EXPECT_FALSE(has_live_channels(cuboid));
  EXPECT_EQ(as_instrument(cuboid).dials.size(), 6u);
}

constexpr const char* kFourWires = R"([instrument]
kind = "position"
[[anchor]]
name = "K1"
at_mm = [1000.0, 0.0, 0.0]
[[anchor]]
name = "K2"
at_mm = [0.0, 1200.0, 800.0]
[[anchor]]
name = "K3"
at_mm = [-900.0, 100.0, 100.0]
[[anchor]]
name = "K4"
at_mm = [50.0, -1000.0, 900.0]
[dials]
travel_mm = 2500.0
resolution_mm = 0.01
repeatability_mm = 0.02
[[dial]]
id = "K1"
[[dial]]
id = "K2"
[[dial]]
id = "K3"
[[dial]]
id = "K4"
)";

// The tool at (120, -80, 410); the first length is worked out by hand.
TEST(LiveChannels, FourWiresFromKnownAnchorsGiveThePosition) {
  const geometry::Rig wires = parse_rig(std::string(kArm) + kFourWires, "rig.toml");
  ASSERT_TRUE(has_live_positions(wires));
  const Eigen::Vector3d p(120, -80, 410);
  Sample sample = sample_of_dials();
  sample.channels.clear();
  for (const auto& anchor : wires.instrument.anchors) {
    sample.channels.push_back({.value = (p - *anchor.at_mm).norm()});
  }
  EXPECT_NEAR(*sample.channels[0].value, std::sqrt(880.0 * 880 + 80 * 80 + 410 * 410), 1e-9);
  const Sample seen = as_instrument(wires, sample);
  const auto found = position_of(seen, 0);
  ASSERT_TRUE(found);
  EXPECT_LT((*found - p).norm(), 1e-9);
  ASSERT_EQ(seen.position_sd_mm.size(), 3u);
  for (const auto& sd_mm : seen.position_sd_mm) {
    EXPECT_GT(*sd_mm, 0.009);
    EXPECT_LT(*sd_mm, 0.1);
  }
  // Three wires are no position; a sample that came with one keeps it.
  Sample three = sample;
  three.channels[2].quality = Quality::kBad;
  EXPECT_FALSE(position_of(as_instrument(wires, three), 0));
  const Sample back = as_dials(wires, seen);
  EXPECT_EQ(back.channels.size(), 7u);
  EXPECT_EQ(*position_of(as_instrument(wires, back), 0), *found);
}

TEST(LiveChannels, PositionsNeedFourWiresWithKnownPlaces) {
  EXPECT_THAT(
      refusal(kFourWires, "at_mm = [50.0, -1000.0, 900.0]\n", ""),
      HasSubstr("'K4' has no at_mm"));
  EXPECT_THAT(refusal(kFourWires, "[[dial]]\nid = \"K4\"\n", ""), HasSubstr("need 4 wires"));
}

TEST(LiveChannels, NamesThatDoNotFitAreRefused) {
  EXPECT_THAT(
      refusal(kWires, "id = \"K2\"", "id = \"K3\""), HasSubstr("'K3' is the name of no"));
  EXPECT_THAT(
      refusal(
          kWires, "[[dial]]\nid = \"K2\"\nconnection = \"modbus-tcp://127.0.0.1:1502\"\n", ""),
      HasSubstr("no [[dial]] reads anchor 'K2'"));
  EXPECT_THAT(refusal(kWires, "travel_mm = 2500.0\n", ""), HasSubstr("travel_mm"));
}

TEST(LiveChannels, TheRigFileThatIsWrittenReadsTheSame) {
  const geometry::Rig again = parse_rig(write_rig(rig()), "rig.toml");
  ASSERT_EQ(again.dials.size(), 2u);
  EXPECT_EQ(again.dials[0].id, "K2");
  EXPECT_EQ(again.dials[1].connection, "modbus-tcp://127.0.0.1:1502");
  EXPECT_EQ(again.dials[0].geometry.travel_mm, 2500.0);
  EXPECT_EQ(write_rig(again), write_rig(rig()));
}

TEST(LiveChannels, ATrialHasTheInstrumentsReadings) {
  Session session;
  session.rig = rig();
  session.samples = {sample_of_dials()};
  session = as_instrument(std::move(session));
  const simulation::Trial trial = trial_of(session.rig, session.samples[0]);
  ASSERT_EQ(trial.reading.size(), 2u);
  EXPECT_EQ(trial.reading[0], 640.5);
  // With the dials nothing is taken for a dial on a cuboid.
  EXPECT_FALSE(trial_of(rig(), sample_of_dials()).position_mm);
}

TEST(LiveChannels, ABundleHasTheChannelsAndReadsTheSame) {
  Session session;
  session.rig = rig();
  session.rig_text = std::string(kArm) + kWires;
  session.samples = {sample_of_dials()};
  session = as_instrument(std::move(session));
  const std::string csv = session_csv(session);
  EXPECT_THAT(csv, HasSubstr("distance_K1_mm"));
  EXPECT_THAT(csv, testing::Not(HasSubstr("dial_")));
  const Session again = parse_session(csv, "session.csv", session.rig_text, "rig.toml");
  ASSERT_EQ(again.samples.size(), 1u);
  EXPECT_EQ(again.samples[0].others[0], 640.5);
  EXPECT_TRUE(again.rig.dials.empty());
}

TEST(LiveChannels, PlansAreMadeAsWithoutDials) {
  const auto with = plan_random(rig(), 10, {});
  const auto without = plan_random(as_instrument(rig()), 10, {});
  ASSERT_TRUE(with) << describe(with.error());
  ASSERT_TRUE(without);
  EXPECT_EQ(*with, *without);
}

}  // namespace
}  // namespace sixdial::session
