// The whole method on measured and simulated sessions.
#include "calibration/pipeline.h"

#include <gtest/gtest.h>

#include <cstdio>

#include "tests/calibration/support.h"

namespace sixdial::calibration {
namespace {

using testing::measured_session_00;
using testing::simulate;

// Issue 2: DQPSO's RMSE must be within this of the least-squares minimum.
constexpr double kAboveMinimum_mm = 1e-5;

void print(const Result& r) {
  for (const MethodErrors& e : r.table_6) {
    std::printf(
        "%-16s G1 %.4f %.4f %.4f rmse %.6f   G2 %.4f %.4f %.4f\n", e.method.c_str(),
        e.g1.mean_mm, e.g1.std_mm, e.g1.max_mm, e.g1.rmse_mm, e.g2.mean_mm, e.g2.std_mm,
        e.g2.max_mm);
  }
  for (const StageResult& s : r.stages)
    std::printf("%s %.2f ms  ", s.name.c_str(), s.seconds * 1e3);
  std::printf(
      "anfis %.2f ms total %.2f ms; above minimum %.3g mm, condition %.0f, lm it %d, not "
      "finite %lld\n",
      r.anfis_seconds * 1e3, r.total_seconds * 1e3, r.above_minimum_mm,
      r.identifiability.condition, r.lm_iterations, static_cast<long long>(r.not_finite));
  for (const AnfisReport* a : {&r.anfis_x, &r.anfis_y}) {
    std::printf(
        "anfis m=%d ridge %.0e eff %.1f best epoch %d gain %.2f se %.1f\n", a->model.functions,
        a->model.ridge, a->model.effective_parameters, a->best_epoch,
        a->selection ? a->selection->gain : 1.0,
        a->selection ? a->selection->standard_errors : 0.0);
  }
}

TEST(Pipeline, EndsAtTheLeastSquaresMinimumOnTheMeasuredSession) {
  const auto session = measured_session_00();
  for (const Profile profile : {Profile::kDefault, Profile::kPaper}) {
    const auto result =
        run_dqpso_anfis(session.g1, session.g2, session.nominal, settings_for(profile));
    ASSERT_TRUE(result) << result.error().message;
    print(*result);
    if (profile == Profile::kDefault) {
      EXPECT_LT(std::abs(result->above_minimum_mm), kAboveMinimum_mm);
    }
  }
}

TEST(Pipeline, Simulated) {
  for (double nk : {0.0, 1.45}) {
    testing::SessionPlan plan;
    plan.non_kinematic = nk;
    const auto session = simulate(plan, 7);
    for (const Profile profile : {Profile::kDefault, Profile::kPaper}) {
      const auto result =
          run_dqpso_anfis(session.g1, session.g2, session.nominal, settings_for(profile));
      ASSERT_TRUE(result) << result.error().message;
      print(*result);
    }
  }
}

}  // namespace
}  // namespace sixdial::calibration
