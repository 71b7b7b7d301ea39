// What a rig file says stays said when it is written anew: every example of the tree, and files
// with every key that the reader knows.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <string>
#include <vector>

#include "session/csv.h"
#include "session/rig_file.h"
#include "session/rig_write.h"
#include "tests/session/same_rig.h"
#include "tests/support/paths.h"

namespace sixdial::session {
namespace {

using ::testing::HasSubstr;

/// Every file of the tree that is a rig file: it has a table [robot].
std::vector<std::string> rig_files() {
  std::vector<std::string> files;
  for (const char* const folder : {"/examples", "/tests/data"}) {
    for (const auto& each :
         std::filesystem::recursive_directory_iterator(test_paths::source_dir() + folder)) {
      if (each.path().extension() != ".toml") continue;
      const std::string text = read_file(each.path().string());
      if (text.find("\n[robot]") != std::string::npos) files.push_back(each.path().string());
    }
  }
  std::ranges::sort(files);
  return files;
}

void expect_as_traced(const Traceability& a, const Traceability& b) {
  EXPECT_EQ(a.operator_name, b.operator_name);
  ASSERT_EQ(a.parts.size(), b.parts.size());
  for (std::size_t i = 0; i < a.parts.size(); ++i) {
    EXPECT_EQ(a.parts[i].what, b.parts[i].what);
    EXPECT_EQ(a.parts[i].words(), b.parts[i].words());
  }
}

std::string written_anew(const std::string& text, const std::string& file) {
  const geometry::Rig rig = parse_rig(text, file);
  std::string written = write_rig(rig, traceability_of(text));
  expect_same(parse_rig(written, "written"), rig);
  expect_as_traced(traceability_of(written), traceability_of(text));
  EXPECT_EQ(write_rig(parse_rig(written, "again"), traceability_of(written)), written);
  return written;
}

TEST(EveryRig, IsTheSameAfterItWasReadAndWritten) {
  const std::vector<std::string> files = rig_files();
  ASSERT_GE(files.size(), 30U);
  for (const std::string& file : files) {
    SCOPED_TRACE(file);
    written_anew(read_file(file), file);
  }
}

/// Every line "key = value" of the text stands in the other.
void expect_every_line(const std::string& text, const std::string& written) {
  int lines = 0;
  for (std::size_t at = 0; at < text.size(); ++lines) {
    const std::size_t end = text.find('\n', at);
    EXPECT_THAT(written, HasSubstr(text.substr(at, end - at) + "\n"));
    at = end + 1;
  }
  EXPECT_GT(lines, 20) << "the law was tried";
}

constexpr const char* kOnDials = R"(name = "all keys"
tolerance_mm = 0.05
operator = "A. Person"
[robot]
model = "five_bar"
working_mode = "++"
assembly = 1
l11_mm = 60.5
l12_mm = 60.25
l21_mm = 59.5
l22_mm = 60.0
d_mm = 90.0
x0_mm = 0.5
y0_mm = -0.5
alpha_deg = 1.5
theta1_offset_deg = 0.25
theta2_offset_deg = -0.25
connection = "manual"
serial = "R-7"
certificate = "R 1"
certified = 2026-01-14
due = 2027-01-14
[cuboid]
side_mm = 79.5
mount = "distal1"
reference_pose_mm = [27.0, 47.0]
side_sd_mm = 0.005
squareness_sd_deg = 0.02
offset_sd_mm = 0.03
serial = "Q-12"
certificate = "K 4711"
certified = 2026-01-15
due = 2027-01-15
[dials]
travel_mm = 50.8
resolution_mm = 0.002
accuracy_mm = 0.005
repeatability_mm = 0.003
tip_radius_mm = 1.25
force_n = 0.75
spring_n_per_mm = 0.04
position_sd_mm = [0.03, 0.1]
axis_sd_deg = 0.2
tip_radius_sd_mm = 0.01
[[dial]]
id = "A"
position_mm = [52.0, 48.0]
axis = [-1.0, 0.0]
connection = "serial:/dev/a"
serial = "12345"
certificate = "K 4712"
certified = 2026-01-16
due = 2027-01-16
[[dial]]
id = "B"
position_mm = [4.0, 48.0]
axis = [1.0, 0.0]
[thermometer]
serial = "T-3"
certificate = "T 99"
certified = 2025-11-01
due = 2026-11-01
)";

constexpr const char* kWithPlaces = R"(name = "places"
[robot]
model = "serial"
convention = "modified_dh"
tool = "frame"
parameters = "all"
base_x_mm = 1.5
tool_z_mm = 107.0
[[joint]]
name = "pan"
d_mm = 333.0
a_mm = 3.0
alpha_deg = 5.0
theta_deg = 7.0
beta_deg = 0.5
low_deg = -170.0
high_deg = 160.0
[[joint]]
name = "slide"
kind = "prismatic"
low_mm = 10.0
high_mm = 200.0
[[joint]]
name = "copy"
follows = "pan"
ratio = 0.5
offset_deg = 3.0
[instrument]
kind = "socket"
sd_mm = 0.2
sd_deg = 0.05
dimensions = 2
orientation = "intrinsic xyz"
[[tool_point]]
name = "P2"
at_mm = [1.0, 2.0, 3.0]
[[anchor]]
name = "K1"
at_mm = [4.0, 5.0, 6.0]
at_sd_mm = 0.25
[[socket]]
name = "S0"
[[socket]]
name = "S1"
distance_mm = { "S0" = 50.0 }
distance_sd_mm = 0.05
[[surface]]
name = "bed"
normal = [0.0, 1.0, 0.0]
[[surface]]
name = "ball"
radius_mm = 12.5
[cuboid]
side_mm = 81.0
mount = "free"
reference_pose_mm = [1.0, 2.0]
serial = "Q-13"
)";

TEST(EveryRig, KeepsEveryKeyThatTheReaderKnows) {
  for (const char* const text : {kOnDials, kWithPlaces}) {
    SCOPED_TRACE(std::string(text).substr(0, 20));
    expect_every_line(text, written_anew(text, "rig.toml"));
  }
}

TEST(EveryRig, KeepsAnInstrumentsKeysBesideDials) {
  std::string text = kOnDials;
  text += "[instrument]\nkind = \"dials_on_cuboid\"\nsd_mm = 0.5\n";
  text += "[[anchor]]\nname = \"K1\"\n";
  EXPECT_THAT(written_anew(text, "rig.toml"), HasSubstr("sd_mm = 0.5\n"));
}

}  // namespace
}  // namespace sixdial::session
