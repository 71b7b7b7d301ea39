// How well a rig file knows its own geometry is read as it was written, and refused where it
// makes no sense.
#include "session/rig_deviations.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <string>

#include "geometry/units.h"
#include "session/csv.h"
#include "session/rig_file.h"
#include "tests/support/paths.h"

namespace sixdial::session {
namespace {

using testing::HasSubstr;

std::string with(std::string text, const std::string& after, const std::string& line) {
  const auto at = text.find(after);
  EXPECT_NE(at, std::string::npos) << after;
  return text.insert(at + after.size(), "\n" + line + "\n");
}

std::string silent_rig() {
  return read_file(test_paths::test_data() + "/sessions/00/rig.toml");
}

TEST(RigDeviations, AFileThatSaysNothingHasNone) {
  const geometry::Rig rig = parse_rig(silent_rig(), "rig.toml");
  EXPECT_FALSE(rig.states_deviations());
  EXPECT_EQ(rig.dials[0].deviations, geometry::DialDeviations{});
}

TEST(RigDeviations, AreWrittenAndReadBack) {
  geometry::Rig rig = geometry::default_rig();
  rig.dials[1].deviations.position_mm = Eigen::Vector2d(0.03, 0.1);
  rig.dials[1].deviations.axis_rad = 0.1 * geometry::kRadPerDeg;
  rig.dials[4].deviations.tip_radius_mm = 0.0;  // exact, and said so
  rig.cuboid.deviations = {0.01, 0.02 * geometry::kRadPerDeg, 0.05};
  const geometry::Rig again = parse_rig(write_rig(rig), "rig.toml");
  EXPECT_TRUE(again.states_deviations());
  for (std::size_t i = 0; i < rig.dials.size(); ++i) {
    EXPECT_EQ(again.dials[i].deviations, rig.dials[i].deviations) << i;
  }
  EXPECT_EQ(again.cuboid.deviations, rig.cuboid.deviations);
}

TEST(RigDeviations, ADialOverridesWhatIsSaidOfAll) {
  std::string text = with(silent_rig(), "[dials]", "position_sd_mm = [0.03, 0.1]");
  text = with(text, "[[dial]]", "position_sd_mm = [0.5, 0.6]");  // the first
  const geometry::Rig rig = parse_rig(text, "rig.toml");
  EXPECT_EQ(*rig.dials[0].deviations.position_mm, Eigen::Vector2d(0.5, 0.6));
  EXPECT_EQ(*rig.dials[5].deviations.position_mm, Eigen::Vector2d(0.03, 0.1));
}

TEST(RigDeviations, ANegativeOneIsRefusedWithItsLine) {
  try {
    (void)parse_rig(with(silent_rig(), "[cuboid]", "side_sd_mm = -0.01"), "rig.toml");
    FAIL() << "read";
  } catch (const std::exception& error) {
    EXPECT_THAT(error.what(), HasSubstr("side_sd_mm"));
    EXPECT_THAT(error.what(), HasSubstr("may not be negative"));
    EXPECT_THAT(error.what(), HasSubstr("rig.toml:"));
  }
}

}  // namespace
}  // namespace sixdial::session
