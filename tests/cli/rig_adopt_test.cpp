// sixdial rig adopt through the command line, from a calibration of a rig whose file states how
// well its dials stand.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <sstream>

#include "cli/cli.h"
#include "mock_devices/session_generator.h"
#include "session/rig_file.h"
#include "tests/support/command_line.h"
#include "tests/support/rig_for_tests.h"

namespace sixdial::cli {
namespace {

using testing::Outcome;
using testing::sixdial;

using ::testing::HasSubstr;
using testing::TempDirectory;

const Eigen::Vector2d kKnown_mm{0.03, 0.1};  // stated, along and across

class RigAdopt : public ::testing::Test {
 protected:
  void SetUp() override {
    folder_ = directory_.path() / "monday";
    mock_devices::World world;
    world.rig.dials[2].geometry.position_mm += Eigen::Vector2d(0.05, 0.02);
    world.seed = 3;
    const auto measured =
        mock_devices::generate_session(world, mock_devices::random_plan(world.rig, 4, 60, 20));
    geometry::Rig file = geometry::default_rig();
    for (geometry::Dial& dial : file.dials) dial.deviations.position_mm = kKnown_mm;
    mock_devices::write_bundle(folder_, measured, file, "2026-03-02T08:30:00.000Z");
    std::ofstream(folder_ / "rig.toml") << session::write_rig(file);
    const Outcome calibrated = sixdial(
        {"calibrate", folder_.string(), "-q", "--method", "lm", "-o", result_.string()});
    ASSERT_TRUE(std::filesystem::exists(result_)) << calibrated.err;
  }

  [[nodiscard]] Outcome adopt(
      const std::filesystem::path& rig, const std::string& output,
      const std::vector<std::string>& more = {}) const {
    std::vector<std::string> words{
        "rig",
        "adopt",
        result_.string(),
        "--rig",
        rig.string(),
        "-o",
        (directory_.path() / output).string()};
    words.insert(words.end(), more.begin(), more.end());
    return sixdial(words);
  }

  TempDirectory directory_;
  std::filesystem::path folder_;
  std::filesystem::path result_ = directory_.path() / "result.json";
};

TEST_F(RigAdopt, PlacesComeInOnceAndAreNeverBetterKnownThanTheyAre) {
  const Outcome once = adopt(folder_ / "rig.toml", "adopted.toml");
  ASSERT_EQ(once.code, 0) << once.err;
  const geometry::Rig rig =
      session::read_rig_file((directory_.path() / "adopted.toml").string());
  const geometry::Rig before = geometry::default_rig();
  double moved_mm = 0.0;
  for (std::size_t d = 0; d < rig.dials.size(); ++d) {
    moved_mm +=
        (rig.dials[d].geometry.position_mm - before.dials[d].geometry.position_mm).norm();
    const auto& sd_mm = rig.dials[d].deviations.position_mm;
    ASSERT_TRUE(sd_mm);
    EXPECT_LE(sd_mm->x(), kKnown_mm.x());
    EXPECT_LE(sd_mm->y(), kKnown_mm.y());
    // A shift of all dials together is not seen: 0.03 mm of each, independent, is as little of
    // their mean (0.03 / sqrt(2) for a pair) as what is left of it.
    EXPECT_GT(sd_mm->x(), kKnown_mm.x() / 2);
  }
  EXPECT_GT(moved_mm, 0.02);

  // The places count from the file that was calibrated with.
  const Outcome twice = adopt(directory_.path() / "adopted.toml", "again.toml");
  EXPECT_NE(twice.code, 0);
  EXPECT_THAT(twice.err, HasSubstr("is not the rig file that"));
  EXPECT_FALSE(std::filesystem::exists(directory_.path() / "again.toml"));
}

TEST_F(RigAdopt, ParametersWithoutTheirPlacesAreTold) {
  const Outcome base = adopt(folder_ / "rig.toml", "base.toml", {"--only", "x0,y0,alpha"});
  EXPECT_EQ(base.code, 0) << base.err;
  EXPECT_THAT(base.err, HasSubstr("take \"dials\" too"));
}

TEST_F(RigAdopt, PlacesThatNobodyFoundAreRefused) {
  std::ofstream(folder_ / "rig.toml") << session::write_rig(geometry::default_rig());
  const Outcome calibrated =
      sixdial({"calibrate", folder_.string(), "-q", "--method", "lm", "-o", result_.string()});
  const Outcome dials = adopt(folder_ / "rig.toml", "dials.toml", {"--only", "dials"});
  EXPECT_NE(dials.code, 0) << calibrated.err;
  EXPECT_THAT(dials.err, HasSubstr("found no places of dials"));
}

}  // namespace
}  // namespace sixdial::cli
