// The gain's interval is over poses: a pose that is measured again says nothing new of others.
#include <gtest/gtest.h>

#include <algorithm>

#include "diagnosis/gain.h"
#include "tests/diagnosis/made_session.h"

namespace sixdial::diagnosis {
namespace {

/// Width of the interval of what a backlash gains, with so many readings of each pose.
double width_mm(int repeats) {
  Recipe recipe{.points = 40, .repeats = repeats, .seed = 12};
  const simulation::ActiveEffect backlash =
      effect_of(geometry::default_rig(), "joint_backlash", "joint2", {1e-3});
  recipe.effects = {backlash};
  const Session session = session_of(recipe);
  Readings readings(session.model, session.trials);
  const JointFit baseline = fit_jointly(readings, session.model.nominal(), {});
  readings.place_tool(baseline.model);
  const JointFit extended = fit_jointly(readings, baseline.model, {backlash});
  std::vector<bool> fitted = session.held_out;
  fitted.flip();
  const GainQuestion question{
      readings,
      {readings.counting(fitted), readings.counting(session.held_out)},
      std::nullopt,
      baseline,
      extended};
  const GainStudy study = study_gain(question, {.networks = false});
  const auto row = std::ranges::find(study.rows, GainModel::kExtended, &GainRow::model);
  if (row == study.rows.end()) return 0.0;
  EXPECT_LT(row->difference_mm, 0.0);
  EXPECT_GT(row->high_mm, row->low_mm);
  return row->high_mm - row->low_mm;
}

TEST(GainInterval, IsNotNarrowedByRepeatsOfTheSamePoses) {
  const double once = width_mm(1);
  ASSERT_GT(once, 0.0);
  // Four repeats drawn one by one would halve it; the noise that they average is small here.
  constexpr double kLeastShare = 0.8;
  EXPECT_GT(width_mm(4), kLeastShare * once);
}

}  // namespace
}  // namespace sixdial::diagnosis
