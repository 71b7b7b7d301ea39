// Gears and strain-wave drives err many times a turn: waves far shorter than a smooth curve of
// so many poses can follow.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <random>

#include "geometry/tool.h"
#include "studies/diagnose.h"
#include "tests/support/arm_session.h"

namespace sixdial::studies {
namespace {

constexpr int kPoses = 180;
constexpr int kOfG1 = 120;

struct Wave {
  int joint = 0;
  double waves = 0.0;  // a turn
  double size_rad = 0.0;
  double phase = 0.0;
};

/// The arm of arm_session whose joint stands elsewhere than its encoder says, by this wave.
session::Session session_with(const Wave& wave, std::uint64_t seed) {
  session::Session session = session::arm_session(kPoses, kOfG1);
  const geometry::Tool tool(session.rig);
  const geometry::Robot& robot = session.rig.robot;
  std::mt19937_64 engine(seed);
  std::normal_distribution<double> noise_mm(0.0, 0.01);
  for (session::Sample& sample : session.samples) {
    Eigen::VectorXd q = sample.q;
    q[wave.joint] += wave.size_rad * std::sin(wave.waves * q[wave.joint] + wave.phase);
    geometry::Position at = tool.position(robot.nominal, q, robot.assembly).value();
    for (double& each : at) each += noise_mm(engine);
    session::set_position(sample, 0, at);
  }
  return session;
}

const FoundCause* curve_at(const DiagnosisResult& result, int joint) {
  const std::string where = "joint" + std::to_string(joint + 1);
  const auto found = std::ranges::find_if(result.causes, [&](const FoundCause& each) {
    return each.id.cause == "joint_curve" && each.id.where == where;
  });
  return found == result.causes.end() ? nullptr : &*found;
}

TEST(GearWave, IsACurveOfItsJointWithItsPeriod) {
  constexpr double kShareOfPeriod =
      0.03;  // the range holds some ten waves, each told to a part
  for (std::uint64_t seed = 1; seed <= 4; ++seed) {
    std::mt19937_64 engine(seed * 7919);
    std::uniform_real_distribution<double> any;
    const int joint = static_cast<int>(any(engine) * 3);  // the wrist moves the tool too little
    const Wave wave{
        joint, 20.0 * std::pow(10.0, any(engine)), 2e-4, 2 * std::numbers::pi * any(engine)};
    SCOPED_TRACE(
        "seed " + std::to_string(seed) + ", joint " + std::to_string(joint + 1) + ", " +
        std::to_string(wave.waves) + " waves a turn");
    const DiagnosisResult result =
        diagnose(session_with(wave, seed), {.bootstrap = 0, .with_gain = false, .threads = 1});
    const FoundCause* curve = curve_at(result, joint);
    ASSERT_NE(curve, nullptr);
    EXPECT_EQ(result.causes.size(), 1U);
    const auto period =
        std::ranges::find(curve->estimate, "period", &diagnosis::Estimate::name);
    ASSERT_NE(period, curve->estimate.end());
    const double truth = 2 * std::numbers::pi / wave.waves;
    EXPECT_NEAR(period->value, truth, kShareOfPeriod * truth);
  }
}

/// Other names have their own false alarms (doc/diagnosis.md counts them); a curve that is not
/// there is none of these.
TEST(GearWave, IsNotSeenWhereThereIsNone) {
  for (std::uint64_t seed = 11; seed <= 18; ++seed) {
    const DiagnosisResult result =
        diagnose(session_with({}, seed), {.bootstrap = 0, .with_gain = false, .threads = 1});
    for (const FoundCause& each : result.causes)
      EXPECT_NE(each.id.cause, "joint_curve") << seed;
    EXPECT_TRUE(result.unexplained.depends_on.empty()) << seed;
  }
}

}  // namespace
}  // namespace sixdial::studies
