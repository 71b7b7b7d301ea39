// The uncertainty budget against a Monte Carlo of rigs: drawn dials, curves and noise, the file
// stating how well each is known. What it says is what happens, and what nobody states is not
// counted as nothing.
#include "studies/uncertainty_budget.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <string>

#include "geometry/tool.h"
#include "mock_devices/workshop.h"
#include "session/trials.h"
#include "studies/calibrate.h"
#include "tests/support/simulated.h"

namespace sixdial::studies {
namespace {

using Eigen::Vector2d;
using mock_devices::Misplaced;

geometry::Rig stating(const Misplaced& by) {
  geometry::Rig rig = geometry::default_rig();
  for (geometry::Dial& dial : rig.dials) {
    dial.deviations = {Vector2d(by.along_mm, by.across_mm), by.axis_rad, by.tip_radius_mm};
  }
  rig.cuboid.deviations = {by.side_mm, by.squareness_rad, by.offset_mm};
  return rig;
}

/// A drawn rig without faults of the robot: dials elsewhere, with curves and noise.
mock_devices::Workshop drawn(const Misplaced& by, double curve_mm, std::uint64_t seed) {
  mock_devices::Workshop result = mock_devices::drawn_workshop(stating(by), seed, by);
  std::erase_if(
      result.world.effects, [](const auto& each) { return !each.cause.starts_with("cuboid"); });
  result.world.robot.parameters = geometry::table_2_robot();
  result.world.dials.curve_mm = curve_mm;
  result.world.dials.hysteresis_mm = 0.0;
  return result;
}

struct Tried {
  CalibrationResult result;
  session::Session session;
  double measured_mm2 = 0.0, commanded_mm2 = 0.0;  // mean over the poses of G1
};

Tried tried(const Misplaced& by, double curve_mm, std::uint64_t seed) {
  const mock_devices::Workshop workshop = drawn(by, curve_mm, seed);
  const auto plan = mock_devices::random_plan(workshop.file, 1, 60, 0);
  Tried out;
  out.session = session::parse_session(
      mock_devices::session_csv(
          mock_devices::generate_session(workshop.world, plan), workshop.file,
          "2026-03-02T08:30:00.000Z"),
      "session.csv", mock_devices::rig_toml(workshop.file), "rig.toml");
  out.result = calibrate(out.session, {.method = "lm", .keep_gross_errors = true});
  const geometry::Tool tool(out.session.rig);
  int count = 0;
  for (const simulation::Trial& trial : session::trials_of(out.session, "G1")) {
    if (!trial.position_mm) continue;
    const auto truth = tool.position(workshop.world.robot.parameters, trial.q, trial.assembly);
    const auto said = tool.position(out.result.identified(), trial.q, trial.assembly);
    const Vector2d measured = out.result.points.at(static_cast<std::size_t>(count)).measured_mm;
    out.measured_mm2 += (measured - *truth).squaredNorm();
    out.commanded_mm2 += (*said - *truth).squaredNorm();
    ++count;
  }
  out.measured_mm2 /= count;
  out.commanded_mm2 /= count;
  return out;
}

struct Ratio {
  double measured = 0.0, commanded = 0.0;  // budget over Monte Carlo
};

Ratio over_monte_carlo(const Misplaced& by, double curve_mm, int sessions) {
  double measured = 0.0, commanded = 0.0, said_measured = 0.0, said_commanded = 0.0;
  for (int i = 0; i < sessions; ++i) {
    const Tried each = tried(by, curve_mm, 100 + static_cast<std::uint64_t>(i));
    measured += each.measured_mm2;
    commanded += each.commanded_mm2;
    const auto& budgets = each.result.uncertainty_budgets.value();
    said_measured += std::pow(budgets.at(0).combined_mm, 2);
    said_commanded += std::pow(budgets.at(1).combined_mm, 2);
  }
  const Ratio ratio{std::sqrt(said_measured / measured), std::sqrt(said_commanded / commanded)};
  std::printf(
      "budget over Monte Carlo: measured %.3f (%.1f um), commanded %.3f (%.1f um)\n",
      ratio.measured, 1e3 * std::sqrt(said_measured / sessions), ratio.commanded,
      1e3 * std::sqrt(said_commanded / sessions));
  return ratio;
}

constexpr int kSessions = 60;  // sd of such a ratio: about 0.06, as the quantities are few

TEST(UncertaintyBudget, IsWhatAMonteCarloOfWorkshopRigsFinds) {
  const Misplaced by{
      .tip_radius_mm = 0.01, .side_mm = 0.01, .squareness_rad = 1e-4, .offset_mm = 0.02};
  const Ratio ratio = over_monte_carlo(by, 0.004, kSessions);
  EXPECT_NEAR(ratio.measured, 1.0, 0.2);
  EXPECT_NEAR(ratio.commanded, 1.0, 0.2);
}

TEST(UncertaintyBudget, OfDialsAloneIsNotTooSmall) {
  // The mock's curves lie within the limit of 6 um; a rectangle (GUM 4.3.7) takes all of it as
  // likely, which is more than smooth curves are, never less.
  const Ratio ratio = over_monte_carlo(mock_devices::kPlacedExactly, 0.006, kSessions);
  EXPECT_GT(ratio.measured, 0.95);
  EXPECT_LT(ratio.measured, 1.8);
  EXPECT_GT(ratio.commanded, 0.95);
  EXPECT_LT(ratio.commanded, 2.2);
}

const UncertaintyBudget& budget_of(const CalibrationResult& result, Measurand measurand) {
  return *std::ranges::find(
      result.uncertainty_budgets.value(), measurand, &UncertaintyBudget::measurand);
}

TEST(UncertaintyBudget, SharesAddUpAndContributionsAreSensitivityTimesUncertainty) {
  const CalibrationResult result = tried({}, 0.004, 7).result;
  for (const UncertaintyBudget& budget : result.uncertainty_budgets.value()) {
    double shares = 0.0, variance = 0.0;
    int parts = 0;
    for (const BudgetRow& row : budget.rows) {
      EXPECT_GE(row.share, 0.0);
      EXPECT_LE(row.share, 1.0 + 1e-9);
      parts += row.state == BudgetState::kPart ? 1 : 0;
      if (row.state != BudgetState::kCounted) continue;
      shares += row.share;
      variance += row.contribution_mm * std::abs(row.contribution_mm);
      if (row.standard > 0.0) {
        EXPECT_NEAR(row.sensitivity * row.standard, row.contribution_mm, 1e-12);
      }
    }
    EXPECT_NEAR(shares, 1.0, 1e-9);
    EXPECT_NEAR(std::sqrt(variance), budget.combined_mm, 1e-12);
    EXPECT_NEAR(budget.expanded_mm, 2.0 * budget.combined_mm, 1e-12);
    EXPECT_EQ(budget.places, 60);
    EXPECT_GT(parts, 6) << "curves of six dials, and kinds of the rig";
  }
}

TEST(UncertaintyBudget, WhatNobodyStatesIsNamedAndNotCountedAsZero) {
  Tried each = tried({}, 0.004, 8);
  std::string& text = each.session.rig_text;
  for (std::size_t at = 0; (at = text.find("accuracy_mm", at)) != std::string::npos;) {
    text.erase(at, text.find('\n', at) - at + 1);
  }
  each.session.rig.dials[2].deviations.axis_rad.reset();
  each.session.rig.cuboid.deviations.side_mm.reset();
  const CalibrationResult result = calibrate(each.session, {.method = "lm"});
  const UncertaintyBudget& budget = budget_of(result, Measurand::kMeasured);
  EXPECT_FALSE(budget.complete);
  int curves = 0, rig = 0;
  for (const BudgetRow& row : budget.rows) {
    if (row.state != BudgetState::kNotStated) continue;
    EXPECT_TRUE(std::isnan(row.contribution_mm));
    EXPECT_EQ(row.share, 0.0);
    curves += row.source == BudgetSource::kDialCurve ? 1 : 0;
    if (row.source != BudgetSource::kRig) continue;
    ++rig;
    EXPECT_TRUE(
        row.of == "side of the cuboid" ||
        (row.of == "axes of the dials" && row.not_stated == "C"))
        << row.of << row.not_stated;
  }
  EXPECT_EQ(curves, 6);
  EXPECT_EQ(rig, 2);
}

TEST(UncertaintyBudget, OfAnInstrumentThatGivesPositionsIsItsOwnDeviation) {
  Tried each = tried({}, 0.004, 9);
  const std::size_t dials = each.session.rig.dials.size();
  for (session::Sample& sample : each.session.samples) {
    const auto trial = session::trial_of(each.session.rig, sample, 0, std::nullopt);
    for (std::size_t k = 0; k < dials; ++k) sample.channels[k] = {};
    if (trial.position_mm) session::set_position(sample, dials, *trial.position_mm);
  }
  each.session.rig.instrument.sd_mm = 0.005;
  const CalibrationResult result = calibrate(each.session, {.method = "lm"});
  const UncertaintyBudget& budget = budget_of(result, Measurand::kMeasured);
  EXPECT_EQ(budget.rows.front().source, BudgetSource::kInstrument);
  EXPECT_NEAR(budget.rows.front().contribution_mm, 0.005 * std::sqrt(2.0), 1e-9);
}

}  // namespace
}  // namespace sixdial::studies
