// Exported C and Python, compiled and run by Debian's own compiler and interpreter: forward
// kinematics equal to ours, inverse kinematics that close; every kind of robot, every effect.
#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <random>

#include "report/export/export_format.h"
#include "simulation/effect_in_code.h"
#include "tests/export/made_models.h"

namespace sixdial::report {
namespace {

using studies::ExportedModel;
using studies::ModelPose;
using ::testing::HasSubstr;

constexpr double kSame_mm = 1e-9;
constexpr double kSameTurn = 1e-11;

/// Of each line: joints, start of the inverse, sides, travel, temperature, time, assembly.
constexpr const char* kDriverInC = R"c(
#include "robot.c"
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static double next(void) {
  double value;
  if (scanf("%lf", &value) != 1) exit(0);
  return value;
}

int main(int count, char **words) {
  const int with_turn = count > 1 && strcmp(words[1], "turn") == 0;
  for (;;) {
    double q[SIXDIAL_JOINTS], start[SIXDIAL_JOINTS], found[SIXDIAL_JOINTS], p[3], R[9], again[3];
    sixdial_moment at;
    int i, closes, trouble;
    for (i = 0; i < SIXDIAL_JOINTS; ++i) q[i] = next();
    for (i = 0; i < SIXDIAL_JOINTS; ++i) start[i] = next();
    for (i = 0; i < SIXDIAL_JOINTS; ++i) at.approach[i] = next();
    for (i = 0; i < 3; ++i) at.travel[i] = next();
    at.temperature_degC = next();
    at.time_h = next();
    at.assembly = (int)next();
    trouble = sixdial_forward(q, &at, p, R);
    closes = sixdial_inverse(p, with_turn ? R : NULL, start, &at, found);
    if (sixdial_forward(found, &at, again, NULL) != 0) closes = 9;
    printf("%d %.17g %.17g %.17g", trouble, p[0], p[1], p[2]);
    for (i = 0; i < 9; ++i) printf(" %.17g", R[i]);
    printf(" %d %.17g %.17g %.17g\n", closes, again[0], again[1], again[2]);
  }
}
)c";

constexpr const char* kDriverInPython = R"py(
import sys
import robot
with_turn = sys.argv[1] == "turn"
n = robot.JOINTS
for line in sys.stdin:
    v = [float(word) for word in line.split()]
    q, start, sides, rest = v[:n], v[n:2 * n], v[2 * n:3 * n], v[3 * n:]
    at = robot.Moment(sides, rest[3], rest[4], rest[:3], int(rest[5]))
    p, R = robot.forward(q, at)
    found = robot.inverse(p, R if with_turn else None, start, at)
    again = robot.forward(found, at)[0]
    print(0, *map(repr, p), *(repr(each) for row in R for each in row), 0, *map(repr, again))
)py";

std::string lines_for(const std::vector<ModelPose>& poses, double away) {
  std::mt19937_64 engine(3);
  std::uniform_real_distribution<double> drawn(-1.0, 1.0);
  std::string text;
  for (const ModelPose& pose : poses) {
    for (const double each : pose.q) text += fmt::format("{} ", each);
    for (const double each : pose.q) text += fmt::format("{} ", each + away * drawn(engine));
    for (const double each : pose.sample.approach) text += fmt::format("{} ", each);
    for (const double each : pose.sample.travel) text += fmt::format("{} ", each);
    text += fmt::format(
        "{} {} {}\n", pose.sample.temperature_degC, pose.sample.time_h,
        static_cast<int>(pose.assembly));
  }
  return text;
}

enum class In { kC, kPython };

/// What the exported source prints for these poses, or what went wrong as one line of nothing.
std::vector<std::vector<double>> run_source(
    const ExportedModel& model, In language, const std::string& input, bool with_turn) {
  const TemporaryFolder folder;
  const Exported source = export_model(model, language == In::kC ? "c" : "python");
  put(folder, source.file_name, source.text);
  put(folder, "input", input);
  const std::string go = fmt::format("cd {} && ", folder.path().string());
  const std::string turn = with_turn ? "turn" : "place";
  if (language == In::kC) {
    put(folder, "driver.c", kDriverInC);
    const auto built =
        run_program(go + "cc -std=c99 -O1 -Wall -Wextra -Werror driver.c -o run -lm");
    EXPECT_EQ(built.exit_code, 0) << built.err;
    if (built.exit_code != 0) return {};
  } else {
    put(folder, "driver.py", kDriverInPython);
  }
  const auto ran = run_program(
      go + (language == In::kC ? "./run " : "python3 driver.py ") + turn + " < input");
  EXPECT_EQ(ran.exit_code, 0) << ran.err;
  return ran.exit_code == 0 ? studies::numbers_in(ran.out) : std::vector<std::vector<double>>();
}

/// Forward as ours, and the inverse closes. Python is slow: at one pose in six.
void expect_same(const ExportedModel& model, In language) {
  std::vector<ModelPose> poses;
  const std::vector<ModelPose> all = studies::moments_of(model);
  for (std::size_t i = 0; i < all.size(); i += language == In::kC ? 1 : 6) {
    poses.push_back(all[i]);
  }
  const bool slides = model.robot().joints.front().kind == geometry::JointKind::kPrismatic;
  const bool with_turn = model.robot().joint_count() >= 6;
  const auto rows =
      run_source(model, language, lines_for(poses, slides ? 1.0 : 0.01), with_turn);
  ASSERT_EQ(rows.size(), poses.size());
  for (std::size_t i = 0; i < rows.size(); ++i) {
    ASSERT_EQ(rows[i].size(), 17U);
    ASSERT_EQ(rows[i][0], 0.0) << "pose " << i;
    const auto ours = studies::tool_pose(model, poses[i]);
    ASSERT_TRUE(ours);
    for (Eigen::Index k = 0; k < 3; ++k) {
      const auto at = static_cast<std::size_t>(k);
      ASSERT_LT(std::abs(rows[i][1 + at] - ours->p[k]), kSame_mm) << "pose " << i;
      ASSERT_LT(std::abs(rows[i][14 + at] - ours->p[k]), 2 * kSame_mm) << "pose " << i;
      for (Eigen::Index j = 0; j < 3; ++j) {
        const auto element = 4 + 3 * at + static_cast<std::size_t>(j);
        ASSERT_LT(std::abs(rows[i][element] - ours->R(k, j)), kSameTurn) << "pose " << i;
      }
    }
    ASSERT_EQ(rows[i][13], 0.0) << "the inverse of pose " << i << " does not close";
  }
}

struct SourceCase {
  const char* name;
  std::shared_ptr<const geometry::RobotModel> (*robot)();
};
const std::vector<SourceCase>& cases() {
  static const std::vector<SourceCase> kCases{
      {"FiveBar", [] { return studies::example_of("five_bar"); }},
      {"UR10", [] { return studies::ur10(); }},
      {"Panda", studies::panda},
      {"SlantedArm", studies::slanted_arm},
      {"LinearDelta", [] { return studies::example_of("linear_delta"); }},
      {"RotaryDelta", [] { return studies::example_of("rotary_delta"); }},
      {"Stewart", [] { return studies::example_of("stewart"); }}};
  return kCases;
}

class EverySource : public ::testing::TestWithParam<std::tuple<std::size_t, In>> {
 protected:
  static ExportedModel model() {
    return studies::made_model(cases().at(std::get<0>(GetParam())).robot());
  }
  static In language() { return std::get<1>(GetParam()); }
};

TEST_P(EverySource, StandsWhereOursDoesAndCloses) { expect_same(model(), language()); }

TEST_P(EverySource, HoldsEveryEffectThatMovesTheRobot) {
  const ExportedModel plain = model();
  int held = 0;
  for (const simulation::Effect* effect : simulation::all_effects()) {
    if (!simulation::moves_the_robot(*effect)) continue;
    std::vector<simulation::ActiveEffect> everywhere;
    for (const simulation::Place& place : effect->places(plain.base->rig())) {
      everywhere.push_back({effect, place, studies::three_sizes_of(*effect, place)});
    }
    if (everywhere.empty()) continue;
    SCOPED_TRACE(std::string(effect->cause));
    const ExportedModel bent = studies::with_effects(plain, everywhere);
    const Exported source = export_model(bent, language() == In::kC ? "c" : "python");
    if (simulation::find_effect_in_code(effect->cause) == nullptr) {
      // It goes by the forces of dials: told, with what it makes.
      ASSERT_EQ(source.left_out.size(), everywhere.size());
      EXPECT_NE(effect->needs & simulation::kDials, 0U);
      continue;
    }
    EXPECT_TRUE(source.left_out.empty());
    EXPECT_GT(studies::miss_between(bent, plain).max_mm, 1e-3) << "it moves nothing";
    expect_same(bent, language());
    ++held;
  }
  EXPECT_GE(held, plain.robot().axes == 3 ? 6 : 8);
}

TEST_P(EverySource, HoldsSeveralEffectsInTheirOrder) {
  const ExportedModel plain = model();
  std::vector<simulation::ActiveEffect> all;
  for (const char* const cause :
       {"joint_gain", "joint_curve", "step", "joint_eccentricity", "joint_backlash"}) {
    const simulation::Effect* effect = simulation::find_effect(cause);
    ASSERT_NE(effect, nullptr);
    for (const simulation::Place& place : effect->places(plain.base->rig())) {
      if (place.joint < 0) continue;
      all.push_back({effect, place, studies::three_sizes_of(*effect, place)});
    }
  }
  expect_same(studies::with_effects(plain, all), language());
}

INSTANTIATE_TEST_SUITE_P(
    , EverySource,
    ::testing::Combine(
        ::testing::Range(std::size_t{0}, std::size_t{7}),
        ::testing::Values(In::kC, In::kPython)),
    [](const auto& each) {
      return std::string(cases().at(std::get<0>(each.param)).name) +
             (std::get<1>(each.param) == In::kC ? "InC" : "InPython");
    });

TEST(Sources, SayWhereThereIsNoPoseInsteadOfANumber) {
  ExportedModel model = studies::made_model(studies::example_of("linear_delta"));
  const TemporaryFolder folder;
  put(folder, "robot.c", export_model(model, "c").text);
  put(folder, "main.c", R"c(
#include "robot.c"
int main(void) {
  const double far[3] = {0.0, 0.0, 5000.0}, near[3] = {300.0, 300.0, 300.0};
  const double nowhere[3] = {1e6, 0.0, 0.0};
  double p[3], q[3];
  if (sixdial_forward(far, NULL, p, NULL) != 1) return 1;
  if (sixdial_inverse(p, NULL, far, NULL, q) != 1) return 2;
  if (sixdial_inverse(nowhere, NULL, near, NULL, q) == 0) return 3;
  return 0;
}
)c");
  const auto ran = run_program(fmt::format(
      "cd {} && cc -std=c99 -Wall -Wextra -Werror main.c -o run -lm && ./run",
      folder.path().string()));
  EXPECT_EQ(ran.exit_code, 0) << ran.err;
  put(folder, "robot.py", export_model(model, "python").text);
  const auto python = run_program(fmt::format(
      "cd {} && python3 -c 'import robot; robot.forward([0.0, 0.0, 5000.0])'",
      folder.path().string()));
  EXPECT_NE(python.exit_code, 0);
  EXPECT_THAT(python.err, HasSubstr("NoPose: the rods do not meet"));
}

TEST(Sources, NamesOfSessionsDoNotEndTheirComments) {
  ExportedModel model = studies::made_model(studies::example_of("five_bar"));
  model.inputs.session = "*/ int x; \"\"\" --> \\ \n#error";
  expect_same(model, In::kC);
  expect_same(model, In::kPython);
}

}  // namespace
}  // namespace sixdial::report
