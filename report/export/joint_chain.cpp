#include "report/export/joint_chain.h"

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <utility>

#include "geometry/robots/serial.h"
#include "geometry/rotation.h"
#include "geometry/units.h"
#include "report/export/holding.h"

namespace sixdial::report {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;
using geometry::JointKind;
using geometry::Pose;
using geometry::SerialRow;

Pose<double> turn(int axis, double angle_rad) {
  Pose<double> X;
  geometry::turn_about<double>(X.R, axis, angle_rad);
  return X;
}
Pose<double> shift(const Vector3d& p) { return {p}; }

/// Fixed parts of a link before and behind its joint.
struct Link {
  Pose<double> before, after;
  Vector3d axis{0, 0, 1};
};

Link link_of(const SerialRow& row) {
  if (row.form == geometry::RowForm::kOrigin) {
    return {{row.origin_mm, geometry::turned_by<double>(row.turn_rad)}, {}, row.axis};
  }
  const Pose<double> along = behind(turn(2, row.theta_rad), shift({0.0, 0.0, row.d_mm}));
  const Pose<double> across = behind(
      behind(shift({row.a_mm, 0.0, 0.0}), turn(0, row.alpha_rad)), turn(1, row.beta_rad));
  if (row.form == geometry::RowForm::kDh) return {along, across};
  return {behind(across, along), {}};
}

Pose<double> moved(const ChainJoint& joint, double value) {
  if (joint.kind == JointKind::kPrismatic) return {joint.axis * value};
  return {Vector3d::Zero(), Eigen::AngleAxisd(value, joint.axis).toRotationMatrix()};
}

std::size_t index_of(const geometry::RobotModel& robot, const std::string& name) {
  const auto found = std::ranges::find(robot.joints, name, &geometry::JointInfo::name);
  return static_cast<std::size_t>(found - robot.joints.begin());
}

/// What settled shifts have moved the zero of a joint by.
double shift_of(const studies::ExportedModel& model, std::size_t joint) {
  double sum = 0.0;
  for (const simulation::ActiveEffect& each : model.effects) {
    const bool own = each.place.joint == static_cast<int>(joint);
    if (own && is_settled_shift(each, model)) sum += each.x.front();
  }
  return sum;
}

}  // namespace

Pose<double> behind(const Pose<double>& a, const Pose<double>& b) {
  return {a.p + a.R * b.p, a.R * b.R};
}

Pose<double> inverse(const Pose<double>& pose) {
  return {-(pose.R.transpose() * pose.p), pose.R.transpose()};
}

bool is_arm(const studies::ExportedModel& model) {
  return model.robot().kind == &geometry::serial;
}

JointChain joint_chain(const studies::ExportedModel& model, bool with_shifts) {
  const geometry::RobotModel& robot = model.robot();
  Eigen::VectorXd v = model.parameters();
  const geometry::SerialRobot arm = geometry::serial_robot(robot, v);
  JointChain chain;
  const auto frame = [](const Vector3d& p, const Vector3d& turn_rad) -> Pose<double> {
    return {p, geometry::turned_by<double>(turn_rad)};
  };
  chain.base = frame(arm.base_mm, arm.base_turn_rad);
  for (std::size_t k = 0; k < robot.parameters.size(); ++k) {
    if (robot.parameters[k].stands) v[static_cast<Eigen::Index>(k)] = 0.0;
  }
  const geometry::SerialRobot upright = geometry::serial_robot(robot, v);
  chain.upright = frame(upright.base_mm, upright.base_turn_rad);
  Pose<double> before;
  for (const SerialRow& row : arm.rows) {
    const Link link = link_of(row);
    ChainJoint joint{
        .name = row.name,
        .kind = row.kind,
        .origin = behind(before, link.before),
        .axis = link.axis,
        .mark_mm = link.after.p,
        .joint = index_of(robot, row.follows.empty() ? row.name : row.follows),
        .follows = row.follows,
        .ratio = row.ratio,
        .offset = row.offset,
        .low = row.low,
        .high = row.high};
    const double zero = with_shifts ? shift_of(model, joint.joint) : 0.0;
    if (row.follows.empty()) {
      if (zero != 0.0) joint.origin = behind(joint.origin, moved(joint, zero));
    } else {
      joint.offset += joint.ratio * zero;
    }
    before = link.after;
    chain.joints.push_back(std::move(joint));
  }
  chain.tool = behind(before, frame(arm.tool_mm, arm.tool_turn_rad));
  return chain;
}

JointChain nominal_chain(const studies::ExportedModel& model) {
  studies::ExportedModel nominal{.base = model.base, .model = model.model};
  nominal.model.head(model.nominal.size()) = model.nominal;
  return joint_chain(nominal);
}

JointChain along_z(JointChain chain) {
  const auto turned = [](const Vector3d& axis) -> Pose<double> {
    if (axis == Vector3d::UnitZ()) return {};
    return {
        Vector3d::Zero(),
        Eigen::Quaterniond::FromTwoVectors(Vector3d::UnitZ(), axis).toRotationMatrix()};
  };
  Pose<double> last;
  for (ChainJoint& joint : chain.joints) {
    const Pose<double> own = turned(joint.axis);
    joint.origin = behind(behind(inverse(last), joint.origin), own);
    joint.mark_mm = own.R.transpose() * joint.mark_mm;
    joint.axis = Vector3d::UnitZ();
    last = own;
  }
  chain.tool = behind(inverse(last), chain.tool);
  return chain;
}

std::string not_six_turning_joints(const JointChain& chain) {
  for (const ChainJoint& joint : chain.joints) {
    if (!joint.follows.empty()) {
      return fmt::format("its joint {} follows another one", joint.name);
    }
    if (joint.kind != JointKind::kRevolute) {
      return fmt::format("its joint {} slides", joint.name);
    }
  }
  if (chain.joints.size() == 6) return "";
  return fmt::format("it has {} joints, and six are needed", chain.joints.size());
}

Vector3d roll_pitch_yaw(const Matrix3d& R) {
  const double roll = std::atan2(R(2, 1), R(2, 2));
  // Where the pitch is upright any roll will do; yaw and pitch are then those of what is left.
  const Matrix3d left = R * turn(0, -roll).R;
  const double yaw = std::atan2(-left(0, 1), left(1, 1));
  const double along = std::cos(yaw) * left(0, 0) + std::sin(yaw) * left(1, 0);
  return {roll, std::atan2(-left(2, 0), along), yaw};
}

std::string pose_in_words(const Pose<double>& pose) {
  const Vector3d rpy = roll_pitch_yaw(pose.R) * geometry::kDegPerRad;
  return fmt::format(
      "x y z = {} mm, roll pitch yaw = {} deg", exactly(pose.p, " "), exactly(rpy, " "));
}

bool is_of_base(const geometry::ParameterInfo& info) { return info.stands; }
bool is_of_tool(const geometry::ParameterInfo& info) {
  return info.rig_key.starts_with("tool_");
}

}  // namespace sixdial::report
