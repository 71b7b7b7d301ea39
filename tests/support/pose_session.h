// A session of an arm under an instrument of poses: a UR10 that is not as its file says, with a
// probe whose frame sits turned on the flange, as the file does not know.
#pragma once

#include <Eigen/Core>
#include <cmath>
#include <cstdint>
#include <random>
#include <string>

#include "geometry/robots/serial.h"
#include "geometry/rotation.h"
#include "geometry/tool_turn.h"
#include "geometry/units.h"
#include "session/measured_turn.h"
#include "session/session.h"

namespace sixdial::testing {

struct PoseCase {
  std::uint64_t seed = 5;
  int g1 = 60;
  int g2 = 30;
  double sd_mm = 0.02;
  double sd_rad = 4e-5;
  bool tool_is_frame = true;
  /// Rotation vector of the probe on the flange, against the file.
  Eigen::Vector3d probe_rad{0.35, -0.6, 1.9};
  /// Plausible changes that its parameters are off by; 0: as the file says.
  double off = 0.6;
  /// Joint 6 at 0 in all rows: what turns the link before it then turns the tool as well.
  bool last_joint_rests = false;
};

struct PoseSession {
  session::Session session;
  Eigen::VectorXd truth;  // the arm's parameters

  /// Where the true tool is.
  [[nodiscard]] geometry::Pose<double> at(const Eigen::VectorXd& q) const {
    const geometry::Robot& robot = session.rig.robot;
    std::vector<geometry::Pose<double>> X(robot.model->frames.size());
    static_cast<void>(robot.model->forward(truth, q, robot.assembly, X));
    return X[0];
  }
};

inline PoseSession pose_session(const PoseCase& of = {}) {
  const auto example = geometry::find_robot_kind("serial")->example();
  geometry::SerialRobot arm = geometry::serial_robot(*example, example->nominal);
  arm.tool_is_frame = of.tool_is_frame;
  PoseSession made;
  session::Session& session = made.session;
  session.name = "poses";
  geometry::Rig& rig = session.rig;
  rig.name = "an arm under a tracker";
  rig.robot.model = geometry::serial_model(arm);
  rig.robot.nominal = rig.robot.model->nominal;
  rig.robot.working_mode = geometry::WorkingMode(0);
  rig.instrument.kind = "pose";
  rig.instrument.dimensions = 3;
  rig.instrument.sd_mm = of.sd_mm;
  rig.instrument.sd_rad = of.sd_rad;
  std::mt19937_64 random(of.seed);
  std::uniform_real_distribution<double> draw(-1.0, 1.0);
  std::normal_distribution<double> normal;
  made.truth = rig.robot.nominal;
  for (Eigen::Index i = 0; i < made.truth.size(); ++i) {
    const auto& info = rig.robot.model->parameters[static_cast<std::size_t>(i)];
    made.truth[i] += of.off * draw(random) * info.change;
  }
  const Eigen::Matrix3d probe = geometry::turned_by<double>(of.probe_rad);
  if (of.tool_is_frame) {
    made.truth = geometry::with_tool_turned(*rig.robot.model, made.truth, probe).value();
  }
  const session::SampleLayout layout = session::layout_of(rig);
  for (int i = 0; i < of.g1 + of.g2; ++i) {
    session::Sample sample;
    sample.set = i < of.g1 ? "G1" : "G2";
    sample.point = i < of.g1 ? i : i - of.g1;
    sample.q.resize(6);
    for (double& each : sample.q) each = 1.6 * draw(random);
    if (of.last_joint_rests) sample.q[5] = 0.0;
    geometry::Pose<double> X = made.at(sample.q);
    // A tool that is a point has no turn among its parameters: the probe's is put on it here.
    if (!of.tool_is_frame) X.R = X.R * probe;
    sample.others.resize(layout.others.size());
    for (const double each : X.p) {
      sample.channels.push_back({.value = each + of.sd_mm * normal(random)});
    }
    const Eigen::Vector3d noise(normal(random), normal(random), normal(random));
    const Eigen::Vector3d wobble = of.sd_rad * noise;
    const Eigen::Matrix3d seen = geometry::turned_by<double>(wobble) * X.R;
    session::set_turn(sample, layout, geometry::rotation_vector(seen));
    session.samples.push_back(std::move(sample));
  }
  return made;
}

/// Joint values of the arm of pose_session() about which its workspace is wide open.
inline Eigen::VectorXd open_joints() {
  Eigen::VectorXd q(6);
  q << 0.2, -0.8, 1.0, -0.5, 0.9, 0.1;
  return q;
}
/// Drawn within half a radian of these.
inline Eigen::VectorXd any_open_joints(std::mt19937_64& random) {
  std::uniform_real_distribution<double> draw(-0.5, 0.5);
  Eigen::VectorXd q = open_joints();
  for (double& each : q) each += draw(random);
  return q;
}

/// The same session from an instrument whose frame stands elsewhere: p -> R p + t.
inline void seen_from(
    session::Session& session, const Eigen::Matrix3d& R, const Eigen::Vector3d& t) {
  const session::SampleLayout layout = session::layout_of(session.rig);
  for (session::Sample& sample : session.samples) {
    const Eigen::Vector3d p(
        *sample.channels[0].value, *sample.channels[1].value, *sample.channels[2].value);
    const Eigen::Vector3d moved = R * p + t;
    for (std::size_t k = 0; k < 3; ++k) {
      sample.channels[k].value = moved[static_cast<Eigen::Index>(k)];
    }
    const Eigen::Matrix3d turned =
        R * geometry::turned_by<double>(*session::turn_of(sample, layout));
    session::set_turn(sample, layout, geometry::rotation_vector(turned));
  }
}

}  // namespace sixdial::testing
