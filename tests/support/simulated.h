// Sessions as the mock rig would have measured them, without cables and without waiting.
#pragma once

#include "mock_devices/session_generator.h"
#include "session/bundle.h"
#include "session/plan.h"

namespace sixdial::testing {

/// The robot of Table 2 on the default rig; dials with noise alone.
inline mock_devices::World simple_world(std::uint64_t seed) {
  mock_devices::World world;
  world.robot.parameters = geometry::table_2_robot();
  world.dials.curve_mm = 0.0;
  world.dials.hysteresis_mm = 0.0;
  world.seed = seed;
  return world;
}

/// `plan` measured, point by point in its order, 8 s apart.
inline session::Session measured(const mock_devices::World& world, const session::Plan& plan) {
  std::vector<mock_devices::PlannedPose> poses;
  for (const session::PlanPoint& point : plan.points) {
    mock_devices::PlannedPose pose;
    pose.set = point.set;
    pose.point = point.point;
    pose.repeat = point.repeat;
    pose.time_s = 8.0 * static_cast<double>(poses.size());
    pose.q_rad = point.q;
    pose.target_mm = point.target_mm;
    pose.assembly = session::branch_of(world.rig, point).assembly;
    poses.push_back(pose);
  }
  session::Session session = session::parse_session(
      mock_devices::session_csv(
          mock_devices::generate_session(world, poses), world.rig, "2026-03-02T08:30:00.000Z"),
      "session.csv", mock_devices::rig_toml(world.rig), "rig.toml");
  session.name = "simulated";
  return session;
}

}  // namespace sixdial::testing
