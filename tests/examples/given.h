// What the examples in headers may use: a rig, a session that was measured on it (mock dials
// with noise, 60 points in G1 and 20 in G2), and what calibration makes of it.
#pragma once

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <string>
#include <vector>

#include "calibration/five_bar/positions.h"
#include "calibration/five_bar/spaces.h"
#include "calibration/pipeline.h"
#include "session/rig_file.h"
#include "session/trials.h"
#include "studies/calibrate.h"
#include "tests/support/live_rig.h"
#include "tests/support/simulated.h"

namespace sixdial::testing {

/// Where an example shows a figure, it is made and no more.
void show(const auto&...) {}

class HeaderExample : public ::testing::Test {
 protected:
  static mock_devices::World world() { return simple_world(7); }

  const session::Session session = session::parse_session(
      mock_devices::session_csv(
          mock_devices::generate_session(
              world(), mock_devices::random_plan(world().rig, 7, 60, 20)),
          world().rig, "2026-03-02T08:30:00.000Z"),
      "session.csv", mock_devices::rig_toml(world().rig), "rig.toml", {.name = "monday"});
  const geometry::Rig& rig = session.rig;
  const std::string rig_text = session::rig_toml(session);
  static session::Session measured(const session::Plan& plan) {
    return testing::measured(world(), plan);
  }

  /// By sample; `in_g2` says which were not fitted.
  const std::vector<simulation::Trial> trials = session::trials_of(session, "");
  const std::vector<bool> in_g2 = [this] {
    std::vector<bool> result;
    for (const simulation::Trial& each : trials) {
      result.push_back(session.samples[static_cast<std::size_t>(each.sample)].set == "G2");
    }
    return result;
  }();
  /// Positions of G1.
  const calibration::ObservationSpace space = calibration::position_space(
      calibration::position_observations(session::trials_of(session, "G1")), rig.robot.nominal);
  /// What a fit leaves of them: samples x joints, samples x axes.
  const Eigen::MatrixXd joints = space.joints.transpose();
  const Eigen::MatrixXd residual_mm = calibration::errors_before(space, false).transpose();

  TempDirectory directory;
  const std::filesystem::path& folder = directory.path();
  RunningService running;
  const std::filesystem::path socket_path = running.socket_path();
};

}  // namespace sixdial::testing

namespace sixdial {
using testing::show;
}  // namespace sixdial
