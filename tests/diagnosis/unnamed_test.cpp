// How large causes are on one robot, from all of them together; and what a dial's curve goes
// by.
#include "diagnosis/unnamed.h"

#include <gtest/gtest.h>

#include <cmath>

#include "diagnosis/unknown_search.h"
#include "geometry/instruments/contact.h"
#include "simulation/forward_model.h"

namespace sixdial::diagnosis {
namespace {

double mean_scale(const Eigen::VectorXd& size, const Eigen::VectorXd& sd) {
  const SizesOnARobot here = sizes_on_a_robot(size, sd);
  EXPECT_NEAR(here.weight.sum(), 1.0, 1e-12);
  return here.scale.dot(here.weight);
}

TEST(SizesOnARobot, AreSmallWhereNothingShowsAndLargeWhereSeveralDo) {
  const Eigen::VectorXd sd = Eigen::VectorXd::Constant(12, 0.02);
  const Eigen::VectorXd nothing = Eigen::VectorXd::Constant(12, 0.01);  // half an sd each
  Eigen::VectorXd several = nothing;
  several.head(6).setConstant(0.3);
  EXPECT_LT(mean_scale(nothing, sd), 0.01);
  EXPECT_GT(mean_scale(several, sd), 0.05);
}

TEST(OwnReading, IsTheSimulatedOneSoThatACurveCannotExplainADialsNoise) {
  const simulation::ForwardModel model(geometry::default_rig());
  simulation::Trial trial;
  trial.q = Eigen::Vector2d(2.2, 0.9);
  trial.reading.assign(model.rig().dials.size(), 1.0);
  const Readings readings(model, {trial});
  const Eigen::VectorXd simulated = Eigen::VectorXd::Constant(readings.count(), 1.5);
  EXPECT_EQ(own_reading_mm(readings, simulated, 0)[0], 1.5);
  const Eigen::VectorXd nowhere = Eigen::VectorXd::Constant(readings.count(), std::nan(""));
  EXPECT_EQ(own_reading_mm(readings, nowhere, 0)[0], 1.0) << "no pose: the measured one";
}

}  // namespace
}  // namespace sixdial::diagnosis
