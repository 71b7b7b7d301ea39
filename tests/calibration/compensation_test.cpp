// The inverse problem of compensation: closed to the last digits in every working mode, on the
// right branch, and honest where there is no answer.
#include "calibration/compensation.h"

#include <gtest/gtest.h>

#include <Eigen/LU>
#include <cmath>
#include <numbers>
#include <string>
#include <vector>

#include "calibration/anfis.h"
#include "calibration/random.h"
#include "tests/calibration/support.h"

namespace sixdial::calibration {
namespace {

using Eigen::Vector2d;
using geometry::ParameterVector;
using geometry::WorkingMode;

constexpr double kSameAngle_rad = 1e-12;  // two ways to the same angle near 2 rad
const ParameterVector kNominal = geometry::default_rig().robot.nominal;
const geometry::Tool kTool(geometry::default_rig());

/// Some hundredths of a millimetre, changing over tenths of a radian.
Vector2d smooth_correction(const Vector2d& q) {
  return {
      0.04 * std::sin(5 * q[0] + 0.3) + 0.02 * std::cos(8 * q[1]),
      0.05 * std::cos(4 * q[0] - 6 * q[1])};
}

Vector2d random_target(const testing::Rectangle& box, RandomSequence& random) {
  return {
      random.uniform(box.x_low_mm, box.x_high_mm), random.uniform(box.y_low_mm, box.y_high_mm)};
}

class EveryMode : public ::testing::TestWithParam<WorkingMode> {};

TEST_P(EveryMode, ClosesTheInverseProblemOnThousandsOfTargets) {
  const WorkingMode mode = GetParam();
  RandomSequence random(71, 5);
  int solved = 0;
  double most_moved_rad = 0.0;
  for (std::uint64_t seed = 1; seed <= 50; ++seed) {
    const CompensationModel model{
        kTool, kNominal, testing::random_robot(kNominal, seed),
        seed % 2 == 0 ? Correction(smooth_correction) : Correction{}};
    for (int i = 0; i < 50; ++i) {
      const Vector2d target = random_target(testing::workspace_of(mode), random);
      const auto found = compensate(model, target, mode);
      ASSERT_TRUE(found) << found.error().message;
      const auto assembly = geometry::assembly_at(model.v, found->q, target);
      Vector2d reached = geometry::forward(model.v, found->q, assembly.value())->p_WE;
      if (model.correction) reached += smooth_correction(found->q);
      EXPECT_LT((reached - target).norm(), kClosure_mm);
      EXPECT_EQ(geometry::working_mode_of(model.v, found->q, *assembly).value(), mode);
      most_moved_rad =
          std::max(most_moved_rad, (found->q - found->nominal_q).cwiseAbs().maxCoeff());
      ++solved;
    }
  }
  EXPECT_EQ(solved, 2500);
  EXPECT_GT(most_moved_rad, 0.01);  // the robots are about a degree off
}

TEST_P(EveryMode, AnUncalibratedRobotIsCommandedNominally) {
  const WorkingMode mode = GetParam();
  RandomSequence random(72, 5);
  for (int i = 0; i < 200; ++i) {
    const Vector2d target = random_target(testing::workspace_of(mode), random);
    const auto found = compensate({kTool, kNominal, kNominal}, target, mode);
    ASSERT_TRUE(found) << found.error().message;
    EXPECT_LT(
        (found->q - geometry::inverse(kNominal, target, mode).value()).norm(), kSameAngle_rad);
  }
}

INSTANTIATE_TEST_SUITE_P(
    , EveryMode, ::testing::ValuesIn(geometry::kWorkingModes), [](const auto& each) {
      return std::string(each.param.leg(0) > 0 ? "Plus" : "Minus") +
             (each.param.leg(1) > 0 ? "Plus" : "Minus");
    });

TEST(Compensation, OneNewtonStepFromNominalIsNotEnough) {
  const CompensationModel model{kTool, kNominal, geometry::table_2_robot(), smooth_correction};
  const Vector2d target(22, 40);
  const auto solved = compensate(model, target, {});
  ASSERT_TRUE(solved);
  const Vector2d q = solved->nominal_q;
  const auto assembly = geometry::assembly_at(model.v, q, target).value();
  const auto here = geometry::forward_derivative(model.v, q, assembly).value();
  const Vector2d step = here.J_q.inverse() * (target - here.pose.p_WE - smooth_correction(q));
  const Vector2d reached = modelled_position(model, q + step, assembly).value();
  EXPECT_GT((reached - target).norm(), 1e-2);
  EXPECT_LT(solved->closure_mm, kClosure_mm);
}

TEST(Compensation, KeepsTheTurnThatTheControllerIsOn) {
  const CompensationModel model{kTool, kNominal, geometry::table_2_robot()};
  const Vector2d target(28, 48);
  const auto plain = compensate(model, target, {});
  ASSERT_TRUE(plain);
  const Vector2d turn(2 * std::numbers::pi, -2 * std::numbers::pi);
  const auto turned = compensate(model, target, {}, plain->nominal_q + turn);
  ASSERT_TRUE(turned);
  EXPECT_LT((turned->q - plain->q - turn).norm(), 1e-9);
}

TEST(Compensation, AnswersOnTheTurnThatWasMeasuredWhoeverAsks) {
  const Vector2d target(22, 36);
  const WorkingMode mode;
  // A correction that only holds where it was learned.
  const Vector2d turn(0, 2 * std::numbers::pi);
  const Vector2d middle = geometry::inverse(kNominal, Vector2d(28, 48), mode).value() + turn;
  const auto learned = [&](const Vector2d& q) -> Vector2d {
    const bool known = (q - middle).cwiseAbs().maxCoeff() < 1.0;
    return known ? smooth_correction(q) : Vector2d(5.0, -5.0);
  };
  const CompensationModel model{
      kTool, kNominal, geometry::table_2_robot(), learned, {{mode.number, middle}}};
  const auto alone = compensate(model, target, mode);
  ASSERT_TRUE(alone) << alone.error().message;
  EXPECT_LT((alone->q - middle).cwiseAbs().maxCoeff(), 1.0);
  for (const double turns : {-2.0, -1.0, 0.0, 1.0}) {
    const auto planned = compensate(model, target, mode, middle + turns * turn);
    ASSERT_TRUE(planned);
    EXPECT_LT((planned->q - alone->q).norm(), kSameAngle_rad);
  }
}

TEST(Compensation, TargetsAreBroughtIntoTheFrameOfTheParameters) {
  geometry::Similarity X = geometry::Similarity::identity(2);
  X.t = Vector2d(4.0, -3.0);
  const CompensationModel here{kTool, kNominal, geometry::table_2_robot()};
  CompensationModel there = here;
  there.frame = X;
  const auto asked = compensate(there, Vector2d(24, 43), {});
  const auto same = compensate(here, Vector2d(28, 40), {});
  ASSERT_TRUE(asked && same);
  EXPECT_LT((asked->q - same->q).norm(), kSameAngle_rad);
  const auto far = compensate(there, Vector2d(300, 0), {});
  ASSERT_FALSE(far);
  EXPECT_NE(far.error().message.find("300.000"), std::string::npos);  // as it was asked
}

TEST(Compensation, ALearnedNetworkIsClosedEvenAtItsBounds) {
  RandomSequence random(73, 5);
  Eigen::MatrixX2d q(60, 2);
  Eigen::VectorXd x(60);
  Eigen::VectorXd y(60);
  const testing::Rectangle box = testing::kDefaultWorkspace;
  for (int i = 0; i < 60; ++i) {
    q.row(i) = geometry::inverse(kNominal, random_target(box, random), {}).value();
    const Vector2d c = smooth_correction(q.row(i).transpose());
    x[i] = c.x();
    y[i] = c.y();
  }
  AnfisSettings settings;
  settings.functions = 4;
  settings.epochs = 40;
  settings.ridge = 1e-4;
  settings.output_margin = 0.0;  // so that the bound is met inside the workspace
  const AnfisModel net_x = train_anfis(q, x, {}, {}, settings).model;
  const AnfisModel net_y = train_anfis(q, y, {}, {}, settings).model;
  const CompensationModel model{
      kTool, kNominal, geometry::table_2_robot(), [&](const Vector2d& angles) -> Vector2d {
        return {net_x.predict(angles), net_y.predict(angles)};
      }};
  int bounded = 0;
  for (int i = 0; i < 2000; ++i) {
    const auto found = compensate(model, random_target(box, random), {});
    ASSERT_TRUE(found) << found.error().message;
    EXPECT_LT(found->closure_mm, kClosure_mm);
    const Vector2d c = model.correction(found->q);
    const bool at_bound = c.x() == net_x.output_low || c.x() == net_x.output_high ||
                          c.y() == net_y.output_low || c.y() == net_y.output_high;
    bounded += at_bound ? 1 : 0;
  }
  EXPECT_GT(bounded, 0);
}

TEST(Compensation, SaysWhyThereIsNoAnswer) {
  using Kind = CompensationTrouble::Kind;
  const Vector2d inside(28, 48);
  const auto far = compensate({kTool, kNominal, kNominal}, Vector2d(300, 0), {});
  ASSERT_FALSE(far);
  EXPECT_EQ(far.error().kind, Kind::kNominalUnreachable);
  EXPECT_NE(far.error().message.find("300.000"), std::string::npos);

  ParameterVector shrunk = kNominal;
  shrunk.head<4>() *= 0.5;
  const auto beyond = compensate({kTool, kNominal, shrunk}, inside, {});
  ASSERT_FALSE(beyond);
  EXPECT_EQ(beyond.error().kind, Kind::kUnreachable);

  const Vector2d q = geometry::inverse(kNominal, inside, {}).value();
  const auto jumps = [&](const Vector2d& angles) -> Vector2d {  // has no solution
    return {angles[0] < q[0] ? 1.0 : -1.0, 0.0};
  };
  const auto torn = compensate({kTool, kNominal, kNominal, jumps}, inside, {});
  ASSERT_FALSE(torn);
  EXPECT_EQ(torn.error().kind, Kind::kNotConverged);

  const auto shifted = [](const Vector2d&) -> Vector2d { return {-12.0, 12.0}; };
  const auto moved = compensate({kTool, kNominal, kNominal, shifted}, inside, {});
  ASSERT_FALSE(moved);
  EXPECT_EQ(moved.error().kind, Kind::kOffBranch);

  const Vector2d nowhere(std::nan(""), 40);
  EXPECT_FALSE(compensate({kTool, kNominal, kNominal}, nowhere, {}));
}

TEST(Compensation, SaysOfATurnWhatIsLeftOfItInDegrees) {
  const auto arm = geometry::find_robot_kind("serial")->example();
  Eigen::VectorXd q(6);
  q << 0.2, -0.8, 1.0, -0.5, 0.9, 0.1;
  std::vector<geometry::Pose<double>> X(arm->frames.size());
  ASSERT_TRUE(arm->forward(
      arm->nominal, q, static_cast<geometry::Assembly>(arm->assemblies.front().number), X));
  CompensationModel model{
      .tool = geometry::Tool(arm, 3), .nominal = arm->nominal, .v = arm->nominal};
  constexpr double kJump_rad = 0.1;  // 5.7 degrees
  model.turn_correction = [&](const Eigen::VectorXd& at) -> Eigen::VectorXd {
    return Eigen::Vector3d(at[0] < q[0] ? kJump_rad : -kJump_rad, 0.0, 0.0);
  };
  const auto torn = compensate(model, ToolTarget{X[0].p, X[0].R}, WorkingMode(0), q);
  ASSERT_FALSE(torn);
  EXPECT_EQ(torn.error().kind, CompensationTrouble::Kind::kNotConverged);
  const std::string& said = torn.error().message;
  const std::size_t turn = said.find(" mm and ");
  ASSERT_NE(turn, std::string::npos) << said;
  EXPECT_LT(std::abs(std::stod(said.substr(turn + 8)) - 5.7), 0.05) << said;
  EXPECT_NE(said.find(" deg"), std::string::npos) << said;
  const std::size_t place = said.find("improves on ");
  ASSERT_NE(place, std::string::npos) << said;
  EXPECT_LT(std::stod(said.substr(place + 12)), 1e-6) << said;
}

}  // namespace
}  // namespace sixdial::calibration
