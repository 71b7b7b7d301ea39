// What the estimate that grows with a collection says of each sample: worth another look or
// not.
#include "studies/live_estimate.h"

#include <gtest/gtest.h>

#include <cmath>

#include "geometry/long_work.h"
#include "mock_devices/workshop.h"
#include "studies/calibrate.h"
#include "tests/support/simulated.h"

namespace sixdial::studies {
namespace {

using testing::measured;
using testing::simple_world;

const geometry::Rig kRig = geometry::default_rig();

// With few samples nobody knows what is usual: a warped robot is off by many times its dials'
// noise, everywhere, and no sample of it is worth another look.
TEST(LiveEstimate, SuspectsNoSampleOfARobotThatIsBentEverywhere) {
  int told = 0;
  int suspected = 0;
  for (std::uint64_t seed = 1; seed <= 12; ++seed) {
    mock_devices::World world = simple_world(seed);
    world.warp.amplitude_mm = 0.02;
    world.warp.wavelength_mm = 40;
    const session::Session session =
        measured(world, session::plan_random(kRig, 40, {.seed = seed}).value());
    LiveEstimate estimate(kRig, points_of(session));
    for (const session::Sample& sample : session.samples) {
      if (!estimate.add(sample)) continue;
      ++told;
      suspected += estimate.last_unusual();
    }
  }
  EXPECT_GT(told, 400);
  EXPECT_LE(suspected, told / 100);
}

TEST(LiveEstimate, SuspectsAWrongReadingOnceTenSamplesAreThere) {
  for (const int at : {10, 20, 35}) {
    session::Session session =
        measured(simple_world(3), session::plan_random(kRig, 40, {.seed = 4}).value());
    for (auto& dial : session.samples[static_cast<std::size_t>(at)].channels) {
      if (dial.value) *dial.value += 0.5;
    }
    LiveEstimate estimate(kRig, points_of(session));
    for (int i = 0; i <= at; ++i) {
      estimate.add(session.samples[static_cast<std::size_t>(i)]);
      EXPECT_EQ(estimate.last_unusual(), i == at) << i;
    }
  }
}

// P(F(2, n) > f) = (1 + 2 f / n)^(-n / 2) is one in a million.
TEST(LiveEstimate, SaysFromWhereOnByTheSamplesThatThereAre) {
  const auto freedom = [](int samples) { return 2 * samples - geometry::kParameterCount; };
  EXPECT_TRUE(std::isinf(unusual_from(freedom(0))));
  EXPECT_TRUE(std::isinf(unusual_from(freedom(5))));
  const int n = freedom(9);
  const double early = unusual_from(n);
  EXPECT_NEAR(std::pow(1 + 2 * early * early / n, -n / 2.0) / 1e-6, 1.0, 1e-6);
  EXPECT_EQ(unusual_from(freedom(100)), kUnusual);
  for (int samples = 6; samples < 60; ++samples) {
    EXPECT_LE(unusual_from(freedom(samples + 1)), unusual_from(freedom(samples)));
  }
}

/// The default rig by a file that says how well it knows its dials.
geometry::Rig stating_rig() {
  const mock_devices::Misplaced by;
  geometry::Rig says = geometry::default_rig();
  for (geometry::Dial& dial : says.dials) {
    dial.deviations = {Eigen::Vector2d(by.along_mm, by.across_mm), by.axis_rad, std::nullopt};
  }
  return says;
}

session::Session session_of(
    const mock_devices::Workshop& workshop, const geometry::Rig& says, std::uint64_t seed,
    int points) {
  return session::parse_session(
      mock_devices::session_csv(
          mock_devices::generate_session(
              workshop.world, mock_devices::random_plan(says, seed, points, 0)),
          says, "2026-03-02T08:30:00.000Z"),
      "session.csv", mock_devices::rig_toml(says), "rig.toml");
}

TEST(LiveEstimate, SeesTheRigThatACalibrationSees) {
  const geometry::Rig says = stating_rig();
  const auto session = session_of(mock_devices::drawn_workshop(says, 8), says, 8, 60);
  LiveEstimate one_by_one(says, points_of(session)), at_once(says, points_of(session));
  at_once.see_rig(session.samples);
  for (const session::Sample& sample : session.samples) {
    one_by_one.add(sample);
    at_once.add(sample);
  }
  const CalibrationResult calibrated = calibrate(session, {.method = "lm"});
  const EstimateSummary said = at_once.summary();
  ASSERT_TRUE(calibrated.rig && said.rig);
  ASSERT_EQ(said.rig->size(), calibrated.rig->size());
  for (std::size_t k = 0; k < said.rig->size(); ++k) {
    const diagnosis::RigSeen& by = calibrated.rig->at(k);
    EXPECT_EQ(said.rig->at(k).name, by.name);
    EXPECT_NEAR(said.rig->at(k).off, by.off, 1e-3 * by.sd) << by.name;
    EXPECT_NEAR(said.rig->at(k).sd, by.sd, 1e-3 * by.sd) << by.name;
  }
  for (std::size_t k = 0; k < said.parameters.size(); ++k) {
    const ParameterRow& row = calibrated.parameters[k];
    EXPECT_NEAR(said.parameters[k].value, row.identified, 0.5 * row.sd) << row.name;
    EXPECT_GT(said.parameters[k].sd, 0.4 * row.sd) << row.name;
    EXPECT_LT(said.parameters[k].sd, 1.5 * row.sd) << row.name;
  }
  ASSERT_TRUE(said.position_sd_rig_mm);
  EXPECT_GT(*said.position_sd_rig_mm, 0.005);
  EXPECT_LT(*said.position_sd_rig_mm, said.position_sd_max_mm);
  // As the samples came the rig was fitted a few of them ago.
  ASSERT_TRUE(one_by_one.rig().seen());
  EXPECT_EQ(one_by_one.filter().samples(), 60);
  EXPECT_LT(one_by_one.uncertainty().max_mm, 1.3 * at_once.uncertainty().max_mm);
}

/// Distance of the estimate from the true robot over the workspace, squared, over what the
/// estimate says of it.
TEST(LiveEstimate, IsAsFarOffUnderAWorkshopRigAsItSays) {
  constexpr int kRigs = 12;
  const geometry::Rig says = stating_rig();
  double normalised = 0.0, by_noise_alone = 0.0;
  int poses = 0;
  for (std::uint64_t seed = 31; seed < 31 + kRigs; ++seed) {
    const auto workshop = mock_devices::drawn_workshop(says, seed);
    const auto session = session_of(workshop, says, seed, 40);
    LiveEstimate estimate(says, points_of(session));
    for (const session::Sample& sample : session.samples) estimate.add(sample);
    const auto& filter = estimate.filter();
    for (const calibration::WorkspacePose& pose : estimate.workspace()) {
      const auto said = filter.tool().position(filter.v(), pose.q, pose.assembly);
      const auto is =
          filter.tool().position(workshop.world.robot.parameters, pose.q, pose.assembly);
      ASSERT_TRUE(said && is);
      const double off_mm2 = (*said - *is).squaredNorm();
      const auto variance_mm2 = [&](const Eigen::MatrixXd& covariance) {
        const double sd_mm =
            calibration::position_sd_mm(filter.tool(), filter.v(), covariance, pose);
        return sd_mm * sd_mm;
      };
      normalised += off_mm2 / variance_mm2(filter.covariance());
      by_noise_alone += off_mm2 / variance_mm2(filter.P());
      ++poses;
    }
  }
  // A rig that lies elsewhere takes all its poses with it: a chi-square of some 30 degrees of
  // freedom in all.
  EXPECT_NEAR(normalised / poses, 1.0, 0.6);
  EXPECT_GT(by_noise_alone / poses, 5.0);
}

TEST(LiveEstimate, TakesARigFileThatStatesNothingAsItIs) {
  const auto session =
      measured(simple_world(3), session::plan_random(kRig, 20, {.seed = 4}).value());
  LiveEstimate estimate(kRig, points_of(session));
  estimate.see_rig(session.samples);
  for (const session::Sample& sample : session.samples) estimate.add(sample);
  EXPECT_FALSE(estimate.rig().seen());
  EXPECT_EQ(estimate.filter().covariance(), estimate.filter().P());
  EXPECT_FALSE(estimate.summary().rig);
  EXPECT_FALSE(estimate.summary().position_sd_rig_mm);
}

TEST(LiveEstimate, GoesOnWhereItWasEndedAtASample) {
  const geometry::Rig says = stating_rig();
  const auto session = session_of(mock_devices::drawn_workshop(says, 9), says, 9, 30);
  LiveEstimate undisturbed(says, points_of(session)), estimate(says, points_of(session));
  std::stop_source stop;
  stop.request_stop();
  int ended = 0;
  for (std::size_t i = 0; i < session.samples.size(); ++i) {
    undisturbed.add(session.samples[i]);
    try {
      const geometry::LongWork work(i == 12 ? stop.get_token() : std::stop_token());
      estimate.add(session.samples[i]);
    } catch (const geometry::WorkEnded&) {
      ++ended;
    }
  }
  EXPECT_EQ(ended, 1);
  ASSERT_TRUE(estimate.rig().seen());
  EXPECT_EQ(estimate.filter().samples(), undisturbed.filter().samples());
  const EstimateSummary a = estimate.summary(), b = undisturbed.summary();
  for (std::size_t k = 0; k < a.parameters.size(); ++k) {
    EXPECT_NEAR(a.parameters[k].value, b.parameters[k].value, a.parameters[k].sd);
  }
}

}  // namespace
}  // namespace sixdial::studies
