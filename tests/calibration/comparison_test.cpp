// Any identifier with any residual model, in either space, as one table.
#include "calibration/comparison.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <set>

#include "tests/calibration/support.h"

namespace sixdial::calibration {
namespace {

constexpr double kSameError_mm = 1e-15;  // the same figures taken twice

ComparisonSettings quick() {
  ComparisonSettings settings;
  settings.identify.qpso1 = {10, 8};
  settings.identify.qpso2 = {30, 100};
  settings.residual.anfis.epochs = 20;
  settings.residual.bpnn_epochs = 200;
  return settings;
}

std::vector<MethodChoice> every_combination() {
  std::vector<MethodChoice> choices{method_choice("before").value()};
  for (const Identifier* identifier : all_identifiers()) {
    choices.push_back(method_choice(identifier->name).value());
    for (const ResidualModel* model : all_residual_models()) {
      choices.push_back(
          method_choice(std::string(identifier->name) + "+" + std::string(model->name))
              .value());
    }
  }
  return choices;
}

struct Session {
  testing::DialSession measured;
  PositionObservations g1, g2;
  ObservationSpace space;
};

Session session_in(bool dials) {
  testing::SessionPlan plan;
  plan.g1_points = 60;
  plan.g2_points = 30;
  plan.noise_mm = 0.002;
  plan.non_kinematic = 1.0;
  Session session{testing::simulate_dials(plan, 31), {}, {}, {}};
  session.g1 = position_observations(session.measured.g1);
  session.g2 = position_observations(session.measured.g2);
  session.space = dials ? dial_space(session.measured.g1, session.measured.rig)
                        : position_space(session.g1, session.measured.rig.robot.nominal, 0.002);
  return session;
}

class ComparisonIn : public ::testing::TestWithParam<bool> {};

TEST_P(ComparisonIn, AnyIdentifierGoesWithAnyResidualModel) {
  const Session session = session_in(GetParam());
  const auto choices = every_combination();
  ASSERT_EQ(choices.size(), 1 + all_identifiers().size() * (1 + all_residual_models().size()));
  const auto compared = compare_methods(
      session.space, session.g1, session.g2, session.measured.rig.robot.nominal, choices,
      quick());
  ASSERT_TRUE(compared) << compared.error().message;
  ASSERT_EQ(compared->methods.size(), choices.size());
  // each identifier ran once, whatever came after it
  EXPECT_EQ(compared->robots.size(), all_identifiers().size());
  const MethodErrors& before = compared->methods.front().errors;
  EXPECT_FALSE(compared->methods.front().robot.has_value());
  EXPECT_GT(before.g2.mean_mm, 1.0);
  const ComparedMethod* alone = nullptr;
  for (std::size_t i = 1; i < choices.size(); ++i) {
    const ComparedMethod& method = compared->methods[i];
    SCOPED_TRACE(method.choice.id);
    EXPECT_EQ(method.choice.id, choices[i].id);
    EXPECT_EQ(method.errors.method, choices[i].id);
    ASSERT_TRUE(method.robot.has_value());
    EXPECT_EQ(compared->robots[*method.robot].identifier, method.choice.identifier);
    EXPECT_EQ(method.errors.g1.count, 60);
    EXPECT_EQ(method.errors.g2.count, 30);
    EXPECT_EQ(method.errors.g1.unreachable + method.errors.g2.unreachable, 0);
    EXPECT_LT(method.errors.g2.mean_mm, 0.1 * before.g2.mean_mm);
    EXPECT_GE(method.errors.g2.max_mm, method.errors.g2.mean_mm);
    if (method.choice.residual == nullptr) {
      alone = &method;
      EXPECT_FALSE(method.residual.correction);
      continue;
    }
    ASSERT_NE(alone, nullptr);
    EXPECT_EQ(alone->choice.identifier, method.choice.identifier);
    EXPECT_TRUE(method.residual.correction);
    EXPECT_FALSE(method.residual.note.empty());
    if (method.choice.residual->name == "none") {
      EXPECT_LT(std::abs(method.errors.g2.mean_mm - alone->errors.g2.mean_mm), kSameError_mm);
    } else {
      // it learned something of G1
      EXPECT_NE(method.errors.g1_mm, alone->errors.g1_mm);
    }
  }
}

TEST_P(ComparisonIn, ErrorsAreThoseOfTheParametersAndTheCorrection) {
  const Session session = session_in(GetParam());
  const auto compared = compare_methods(
      session.space, session.g1, session.g2, session.measured.rig.robot.nominal,
      {method_choice("lm+gp").value()}, quick());
  ASSERT_TRUE(compared);
  const ComparedMethod& method = compared->methods.front();
  const geometry::ParameterVector v =
      compared->robots.front().found.x.head<geometry::kParameterCount>();
  for (int i = 0; i < session.g2.size(); ++i) {
    const Eigen::Vector2d q = session.g2.q_rad.col(i);
    const auto pose =
        geometry::forward(v, q, session.g2.assembly[static_cast<std::size_t>(i)]).value();
    const double error =
        (session.g2.p_WE.col(i) - pose.p_WE - method.residual.correction(q)).norm();
    EXPECT_LT(std::abs(error - method.errors.g2_mm[static_cast<std::size_t>(i)]), 1e-12) << i;
  }
}

TEST_P(ComparisonIn, TellsEveryStageAndEndsAtOne) {
  const Session session = session_in(GetParam());
  std::set<std::string> stages;
  double last = 0.0;
  const auto compared = compare_methods(
      session.space, session.g1, session.g2, session.measured.rig.robot.nominal,
      {method_choice("ekf_dqpso").value(), method_choice("lm+rbf").value()}, quick(),
      [&](const ComparisonProgress& now) {
        stages.insert(now.stage);
        EXPECT_GE(now.fraction, 0.0);
        EXPECT_LE(now.fraction, 1.0);
        last = now.fraction;
      });
  ASSERT_TRUE(compared);
  EXPECT_EQ(last, 1.0);
  EXPECT_TRUE(stages.contains("ekf_dqpso"));
  EXPECT_TRUE(stages.contains("lm+rbf"));
}

INSTANTIATE_TEST_SUITE_P(, ComparisonIn, ::testing::Bool(), [](const auto& each) {
  return each.param ? "Dials" : "Positions";
});

TEST(MethodChoice, SaysWhichWordItDoesNotKnow) {
  const auto first = method_choice("lmm+gp");
  ASSERT_FALSE(first);
  EXPECT_EQ(first.error().word, "lmm");
  EXPECT_NE(std::ranges::find(first.error().known, "lm"), first.error().known.end());
  const auto second = method_choice("lm+gpp");
  ASSERT_FALSE(second);
  EXPECT_EQ(second.error().word, "gpp");
  EXPECT_NE(std::ranges::find(second.error().known, "gp"), second.error().known.end());
  EXPECT_FALSE(method_choice(""));
  EXPECT_FALSE(method_choice("lm+"));
  EXPECT_FALSE(method_choice("before+gp"));
  for (const std::string_view id : kComparedMethods) EXPECT_TRUE(method_choice(id)) << id;
}

TEST(Comparison, RefusesTooFewSamplesInWords) {
  const Session session = session_in(false);
  const std::vector<int> four{0, 1, 2, 3};
  const auto few = session.g1.subset(four);
  const auto& nominal = session.measured.rig.robot.nominal;
  const auto compared = compare_methods(
      position_space(few, nominal), few, session.g2, nominal, {method_choice("lm+gp").value()},
      quick());
  ASSERT_FALSE(compared);
  EXPECT_EQ(compared.error().kind, Trouble::Kind::kTooFewSamples);
  EXPECT_NE(compared.error().message.find("lm+gp"), std::string::npos);
}

TEST(Comparison, CanBeCancelled) {
  const Session session = session_in(false);
  const auto& nominal = session.measured.rig.robot.nominal;
  std::stop_source stop;
  stop.request_stop();
  const auto compared = compare_methods(
      session.space, session.g1, session.g2, nominal, {method_choice("lm").value()}, quick(),
      {}, stop.get_token());
  ASSERT_FALSE(compared);
  EXPECT_EQ(compared.error().kind, Trouble::Kind::kCancelled);
}

}  // namespace
}  // namespace sixdial::calibration
