// The document of everything: enough for a program of another hand to compute the tool's pose,
// with the causes, from the document alone.
#include "report/documents/json.h"

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "report/export/export_format.h"
#include "tests/export/made_models.h"

namespace sixdial::report {
namespace {

using studies::ExportedModel;

/// Of an arm by its chain, of a five-bar by its ten parameters: written from doc/robots.md.
constexpr const char* kReader = R"py(
import json, math
from math import sin, cos, pi, sqrt
document = json.load(open("robot.json"))
robot, chain = document["robot"], document["chain"]
value = {each["name"]: each["value"] for each in robot["parameters"]}

def times(a, b):
    return [[sum(a[i][k] * b[k][j] for k in range(len(b))) for j in range(len(b[0]))] for i in range(len(a))]

def matrix(pose):
    return [row + [each] for row, each in zip(pose["R"], pose["p_mm"])] + [[0, 0, 0, 1]]

def move(joint, at):
    x, y, z = joint["axis"]
    if joint["kind"] == "prismatic":
        return [[1, 0, 0, x * at], [0, 1, 0, y * at], [0, 0, 1, z * at], [0, 0, 0, 1]]
    c, s = cos(at), sin(at)
    return [[c + x * x * (1 - c), x * y * (1 - c) - z * s, x * z * (1 - c) + y * s, 0],
            [y * x * (1 - c) + z * s, c + y * y * (1 - c), y * z * (1 - c) - x * s, 0],
            [z * x * (1 - c) - y * s, z * y * (1 - c) + x * s, c + z * z * (1 - c), 0], [0, 0, 0, 1]]

def smooth_value(x, at):
    u = max(-1, min(1, (at - (x[0] + x[1]) / 2) / ((x[1] - x[0]) / 2)))
    return sum(c * sin((u + x[2]) * pi * (j + 1) / (2 * x[2])) / sqrt(x[2]) for j, c in enumerate(x[3:]))

def tool(q, assembly):
    if chain is None:
        a = [q[0] + value["dtheta1"], q[1] + value["dtheta2"]]
        one = complex(value["l11"] * cos(a[0]) - value["d"] / 2, value["l11"] * sin(a[0]))
        two = complex(value["l21"] * cos(a[1]) + value["d"] / 2, value["l21"] * sin(a[1]))
        D = abs(two - one)
        along = (value["l12"] ** 2 - value["l22"] ** 2 + D * D) / (2 * D)
        e = one + (two - one) / D * complex(along, assembly * sqrt(value["l12"] ** 2 - along * along))
        e = complex(value["x0"], value["y0"]) + e * complex(cos(value["alpha"]), sin(value["alpha"]))
        return [e.real, e.imag, 0.0]
    at = matrix(chain["base"])
    for joint in chain["joints"]:
        at = times(at, matrix(joint["origin"]))
        at = times(at, move(joint, joint["ratio"] * q[joint["q"]] + joint["offset"]))
    return [row[3] for row in times(at, matrix(chain["tool"]))][:3]

most = 0.0
for pose in document["poses"]:
    names = dict(q=list(pose["q"]), approach=pose["approach"], sin=sin, cos=cos, smooth_value=smooth_value)
    for effect in document["effects"]:
        names["x"] = effect["x"]
        for line in effect["joint_statements"]:
            exec(line, names)
    p = tool(names["q"], pose["assembly"])
    most = max(most, math.dist(p, pose["tool"]["p_mm"]))
print(len(document["poses"]), repr(most))
)py";

TEST(Json, IsEnoughForAProgramOfAnotherHand) {
  for (const bool arm : {false, true}) {
    const ExportedModel plain =
        studies::made_model(arm ? studies::slanted_arm() : studies::example_of("five_bar"));
    std::vector<simulation::ActiveEffect> effects;
    for (const char* const cause : {"joint_curve", "joint_gain", "joint_backlash"}) {
      const simulation::Effect* effect = simulation::find_effect(cause);
      for (const simulation::Place& place : effect->places(plain.base->rig())) {
        effects.push_back({effect, place, studies::three_sizes_of(*effect, place)});
      }
    }
    const ExportedModel bent = studies::with_effects(plain, effects);
    const Exported exported = export_model(bent, "json");
    EXPECT_TRUE(exported.left_out.empty());
    const TemporaryFolder folder;
    put(folder, "robot.json", exported.text);
    put(folder, "reader.py", kReader);
    const auto ran =
        run_program(fmt::format("cd {} && python3 reader.py", folder.path().string()));
    ASSERT_EQ(ran.exit_code, 0) << ran.err;
    const auto numbers = studies::numbers_in(ran.out);
    EXPECT_EQ(numbers[0][0], 12.0);
    EXPECT_LT(numbers[0][1], 1e-9);
  }
}

TEST(Json, SaysOfWhichDataItIs) {
  const ExportedModel model = studies::made_model(studies::example_of("stewart"));
  const Json document = Json::parse(export_model(model, "json").text);
  EXPECT_EQ(document["schema"], "sixdial.robot");
  EXPECT_EQ(document["model"], "kinematics");
  EXPECT_EQ(document["made_from"]["session"], "made");
  EXPECT_EQ(document["made_from"]["data_hash"], "sha256:0123456789abcdef0123");
  EXPECT_EQ(document["robot"]["parameters"].size(), 42U);
  EXPECT_TRUE(document["chain"].is_null());
  for (std::size_t k = 0; k < 42; ++k) {
    EXPECT_EQ(
        document["robot"]["parameters"][k]["value"], model.model[static_cast<Eigen::Index>(k)]);
  }
}

}  // namespace
}  // namespace sixdial::report
