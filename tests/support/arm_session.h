// Sessions of a small arm of five joints whose ranges are known, measured by an instrument that
// gives places. Seeded.
#pragma once

#include <random>

#include "geometry/tool.h"
#include "session/plan.h"
#include "session/rig_file.h"
#include "session/sample_layout.h"

namespace sixdial::session {

inline constexpr const char* kSmallArm =
    "name = \"arm\"\n[robot]\nmodel = \"serial\"\ntool_x_mm = 20\ntool_z_mm = 100\n"
    "[[joint]]\nd_mm = 300\nalpha_deg = 90\nlow_deg = -120\nhigh_deg = 120\n"
    "[[joint]]\na_mm = 250\nlow_deg = 10\nhigh_deg = 80\n"
    "[[joint]]\na_mm = 200\nalpha_deg = 90\nlow_deg = -90\nhigh_deg = -10\n"
    "[[joint]]\nd_mm = 120\nalpha_deg = -90\nlow_deg = -90\nhigh_deg = 90\n"
    "[[joint]]\nalpha_deg = 90\nlow_deg = -90\nhigh_deg = 90\n"
    "[instrument]\nkind = \"position\"\nsd_mm = 0.01\n";

/// `count` poses drawn in joint space, of an arm that is off by tenths, measured with 0.01 mm
/// of noise: the first `g1` of them are of G1, the others of G2.
inline Session arm_session(int count, int g1) {
  Session session;
  session.name = "small arm";
  session.rig_text = kSmallArm;
  session.rig = parse_rig(session.rig_text, "rig.toml");
  const geometry::Tool tool(session.rig);
  const geometry::Robot& robot = session.rig.robot;
  std::mt19937_64 engine(5);
  std::normal_distribution<double> normal;
  Eigen::VectorXd truth = robot.nominal;
  for (Eigen::Index i = 0; i < truth.size(); ++i) {
    truth[i] +=
        0.2 * robot.model->parameters[static_cast<std::size_t>(i)].change * normal(engine);
  }
  const Plan plan = plan_random(session.rig, count, {.seed = 3}).value();
  for (const PlanPoint& point : plan.points) {
    Sample sample;
    sample.set = point.point < g1 ? "G1" : "G2";
    sample.point = point.point;
    sample.q = point.q;
    sample.target_mm = point.target_mm;
    geometry::Position p = tool.position(truth, point.q, robot.assembly).value();
    for (double& each : p) each += 0.01 * normal(engine);
    set_position(sample, 0, p);
    session.samples.push_back(sample);
  }
  return session;
}

}  // namespace sixdial::session
