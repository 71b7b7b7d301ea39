// A search's fits: what was asked before is answered with the same, anything else is fitted.
#include "diagnosis/known_fits.h"

#include <gtest/gtest.h>

#include "tests/diagnosis/made_session.h"

namespace sixdial::diagnosis {
namespace {

void expect_same(const JointFit& a, const JointFit& b) {
  EXPECT_EQ(a.model, b.model);
  EXPECT_EQ(a.log_likelihood, b.log_likelihood);
  EXPECT_EQ(a.residual_mm, b.residual_mm);
  ASSERT_EQ(a.effects.size(), b.effects.size());
  for (std::size_t i = 0; i < a.effects.size(); ++i) EXPECT_EQ(a.effects[i].x, b.effects[i].x);
}

TEST(KnownFits, AnswerLikeAFitAndLikeBefore) {
  const geometry::Rig rig = geometry::default_rig();
  const auto backlash = effect_of(rig, "joint_backlash", "joint2", {6e-4});
  const Session session = session_of({.effects = {backlash}, .points = 60});
  Readings readings(session.model, session.trials);
  readings.place_tool(readings.nominal());
  const JointFit plain = fit_jointly(readings, readings.nominal(), {});
  auto from = backlash;
  from.x = {1e-4};
  auto elsewhere = effect_of(rig, "joint_backlash", "joint1", {1e-4});
  JointFit noisier = plain;
  noisier.s_mm *= 3;
  const Eigen::MatrixXd random = Eigen::MatrixXd::Ones(readings.count(), 1);

  struct Asked {
    std::vector<simulation::ActiveEffect> effects;
    const JointFit* near;
    Eigen::MatrixXd random;
  };
  const std::vector<Asked> all{{{}, nullptr, {}},         {{from}, nullptr, {}},
                               {{backlash}, nullptr, {}}, {{elsewhere}, &plain, {}},
                               {{from}, &plain, {}},      {{from}, &noisier, {}},
                               {{from}, &plain, random},  {{from, elsewhere}, &plain, {}}};
  KnownFits known;
  for (int round = 0; round < 2; ++round) {
    for (const Asked& each : all) {
      const JointFit fitted =
          fit_jointly(readings, plain.model, each.effects, each.near, each.random);
      expect_same(
          known.fit(readings, plain.model, each.effects, each.near, each.random), fitted);
    }
  }
  EXPECT_EQ(known.asked(), 2 * std::ssize(all));
  EXPECT_EQ(known.fitted(), std::ssize(all));
}

}  // namespace
}  // namespace sixdial::diagnosis
