// An arm as most programs say it: each joint a fixed frame in the one before, and an axis that
// it turns about or slides along; whatever rows its rig file has.
//
//   X_WE = base * origin 1 * move 1(q1) * ... * origin n * move n(qn) * tool
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "geometry/pose.h"
#include "studies/exported_model.h"

namespace sixdial::report {

struct ChainJoint {
  std::string name{};
  geometry::JointKind kind = geometry::JointKind::kRevolute;
  geometry::Pose<double> origin{};   // the joint at its value 0, in the frame before [mm]
  Eigen::Vector3d axis{0, 0, 1};     // unit vector in its own frame
  Eigen::Vector3d mark_mm{0, 0, 0};  // where our link's frame is, in its own frame
  std::size_t joint = 0;             // whose value moves it; its own unless it follows one
  std::string follows{};             // name of that joint, empty: its own
  double ratio = 1.0, offset = 0.0;  // of one that follows
  std::optional<double> low{}, high{};
};

struct JointChain {
  geometry::Pose<double> base{}, upright{};  // in W; as weight is reckoned by (Weight)
  std::vector<ChainJoint> joints{};
  geometry::Pose<double> tool{};  // the measured point, in the last joint's frame
};

/// Of a robot of the kind `serial`, with the model's parameters and, unless asked for without,
/// the zeros that its settled shifts have moved.
[[nodiscard]] JointChain joint_chain(
    const studies::ExportedModel& model, bool with_shifts = true);
/// The same of the robot that the rig file describes.
[[nodiscard]] JointChain nominal_chain(const studies::ExportedModel& model);
[[nodiscard]] bool is_arm(const studies::ExportedModel& model);
/// Turns the frames of the joints so that each has its axis along z.
[[nodiscard]] JointChain along_z(JointChain chain);

/// Why a controller that knows six turning joints cannot hold it; empty: it can.
[[nodiscard]] std::string not_six_turning_joints(const JointChain& chain);

[[nodiscard]] geometry::Pose<double> behind(
    const geometry::Pose<double>& a, const geometry::Pose<double>& b);
[[nodiscard]] geometry::Pose<double> inverse(const geometry::Pose<double>& pose);
/// Roll, pitch, yaw: R = Rz(yaw) Ry(pitch) Rx(roll), exact also where the pitch is upright.
[[nodiscard]] Eigen::Vector3d roll_pitch_yaw(const Eigen::Matrix3d& R);

/// Where the robot stands, and what it carries, in lines for a comment: for formats that have
/// no place for them [mm, degrees].
[[nodiscard]] std::string pose_in_words(const geometry::Pose<double>& pose);

/// Parameters of the base and of the tool: not of the links.
[[nodiscard]] bool is_of_base(const geometry::ParameterInfo& info);
[[nodiscard]] bool is_of_tool(const geometry::ParameterInfo& info);

}  // namespace sixdial::report
