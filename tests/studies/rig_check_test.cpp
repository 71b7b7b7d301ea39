// Poses that tell the rig's geometry apart from the robot's: they can be measured, more of them
// tell more, and a session measured there tells what the plan promised.
#include "studies/rig_check.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "diagnosis/joint_fit.h"
#include "geometry/instruments/contact.h"
#include "report/documents/plan_json.h"
#include "report/words/plan_words.h"
#include "studies/error.h"

namespace sixdial::studies {
namespace {

using ::testing::HasSubstr;

geometry::Rig stated_rig() {
  geometry::Rig rig = geometry::default_rig();
  for (geometry::Dial& dial : rig.dials) {
    dial.deviations.position_mm = Eigen::Vector2d(0.03, 0.1);
    dial.deviations.axis_rad = 2e-3;
  }
  rig.cuboid.deviations.side_mm = 0.01;
  return rig;
}

/// What stated_rig() leaves out is taken as a workshop knows it.
bool says_nothing_of(const std::string& quantity) {
  return quantity.find("tip") != std::string::npos ||
         (quantity.find("cuboid") != std::string::npos &&
          quantity.find("side") == std::string::npos);
}

TEST(RigCheck, IsAPlanThatCanBeCollectedAndMoreOfItTellsMore) {
  const geometry::Rig rig = stated_rig();
  const RigCheck check = rig_check(rig, {.points = 24});
  ASSERT_EQ(check.plan.points.size(), 24U);
  EXPECT_EQ(session::parse_plan(session::plan_csv(check.plan, rig), "p.csv", rig), check.plan);
  ASSERT_GE(check.figures.stages.size(), 3U);
  for (std::size_t i = 1; i < check.figures.stages.size(); ++i) {
    EXPECT_LT(check.figures.stages[i].left, check.figures.stages[i - 1].left);
    EXPECT_LT(check.figures.stages[i].position_mm, check.figures.stages[i - 1].position_mm);
  }
  EXPECT_LT(check.figures.exact_rig_mm, check.figures.stages.back().position_mm);
  for (const RigCheckQuantity& each : check.figures.quantities) {
    EXPECT_EQ(each.stated, !says_nothing_of(each.name)) << each.name;
    EXPECT_GT(each.left, 0.0) << each.name;
    EXPECT_LE(each.left, 1.0 + 1e-9) << each.name;
  }
}

TEST(RigCheck, PromisesWhatASessionAtThesePosesTells) {
  const geometry::Rig rig = stated_rig();
  const RigCheck check = rig_check(rig, {.points = 40});
  const simulation::ForwardModel model(rig);
  std::mt19937_64 engine(4);
  std::normal_distribution<double> normal(0.0, 0.002);
  std::vector<simulation::Trial> trials;
  for (const session::PlanPoint& point : check.plan.points) {
    simulation::Trial trial;
    trial.sample = trial.point = static_cast<int>(trials.size());
    trial.q = point.q;
    trial.assembly = session::branch_of(rig, point).assembly;
    const auto seen =
        model.predict(model.nominal(), trial.q, trial.assembly, std::nullopt, true);
    ASSERT_TRUE(seen);
    for (std::size_t d = 0; d < rig.dials.size(); ++d) {
      const double reading_mm = seen->reading[static_cast<Eigen::Index>(d)] + normal(engine);
      trial.reading.push_back(seen->in_contact[d] ? std::optional(reading_mm) : std::nullopt);
    }
    trials.push_back(std::move(trial));
  }
  const diagnosis::Readings readings = diagnosis::Readings(model, trials).allowing_rig(1.0);
  const diagnosis::JointFit fit = diagnosis::fit_jointly(readings, model.nominal(), {});
  ASSERT_TRUE(fit.converged);
  const auto quantities = readings.rig_quantities();
  ASSERT_EQ(quantities.size(), check.figures.quantities.size());
  // The fit's noise comes from some 150 readings less their parameters: known to 7 %.
  constexpr double kOfNoise = 0.2;
  for (std::size_t k = 0; k < quantities.size(); ++k) {
    const double left = fit.u_sd_mm[static_cast<Eigen::Index>(k)] / fit.known_sd_mm;
    EXPECT_NEAR(left, check.figures.quantities[k].left, kOfNoise * left) << quantities[k].name;
  }
}

TEST(RigCheck, OfASilentFileTakesAWorkshopsDeviationsAndSaysSo) {
  const RigCheck check = rig_check(geometry::default_rig(), {.points = 12});
  const std::string text = report::rig_check_text(check.figures);
  EXPECT_THAT(text, HasSubstr("states no deviations"));
  EXPECT_THAT(text, HasSubstr("12 points"));
  const auto again = report::rig_check_from_json(report::to_json(check.figures));
  EXPECT_EQ(report::rig_check_text(again), text);
}

TEST(RigCheck, WithoutDialsIsRefusedInWords) {
  geometry::Rig rig = geometry::default_rig();
  rig.dials.clear();
  try {
    (void)rig_check(rig, {});
    FAIL() << "there is no rig of dials";
  } catch (const StudyError& error) {
    EXPECT_THAT(error.what(), HasSubstr("no dials"));
  }
}

}  // namespace
}  // namespace sixdial::studies
