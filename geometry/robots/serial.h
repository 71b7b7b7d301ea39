// An arm: joints one after the other, by Denavit-Hartenberg rows (Craig's or the classic ones)
// or by the origins of a URDF. doc/robots.md has the conventions, parameters and keys of
// rig.toml.
//
//   X_WE = base * link 1(q1) * ... * link n(qn) * tool
//
// Degenerate: none; every joint value has a pose. A base turned by a whole turn has no
// derivative by its rotation vector.
//
// Example:
//   SerialRobot arm;
//   arm.rows = {{.name = "q1", .d_mm = 300.0}, {.name = "q2", .a_mm = 250.0}};
//   const auto robot = serial_model(arm);
//   robot->joint_count();  // -> 2
//   for (const SaidTwice& each : robot->said_twice) show(each.name, each.by);
#pragma once

#include <Eigen/Core>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <tl/expected.hpp>
#include <vector>

#include "geometry/robot_kind.h"

namespace sixdial::geometry {

enum class RowForm {
  kDh,          // Rz(q + theta) Tz(d) Tx(a) Rx(alpha) Ry(beta)
  kModifiedDh,  // Tx(a) Rx(alpha) Ry(beta) Rz(q + theta) Tz(d)
  kOrigin,      // T(origin) R(turn) Rot(axis, q)
};

struct SerialRow {
  std::string name{};
  JointKind kind = JointKind::kRevolute;
  RowForm form = RowForm::kDh;
  double a_mm = 0.0;
  double alpha_rad = 0.0;
  double d_mm = 0.0;
  double theta_rad = 0.0;
  double beta_rad = 0.0;
  Eigen::Vector3d origin_mm{0, 0, 0};
  Eigen::Vector3d turn_rad{0, 0, 0};  // rotation vector
  Eigen::Vector3d axis{0, 0, 1};      // unit vector in the frame of the origin
  /// A mimic joint: its value is ratio * (value of that joint) + offset, and it is no joint of
  /// its own.
  std::string follows{};
  double ratio = 1.0;
  double offset = 0.0;  // [rad or mm]
  std::optional<double> low{};
  std::optional<double> high{};
};

struct SerialRobot {
  std::vector<SerialRow> rows{};
  Eigen::Vector3d base_mm{0, 0, 0};
  Eigen::Vector3d base_turn_rad{0, 0, 0};
  Eigen::Vector3d tool_mm{0, 0, 0};
  Eigen::Vector3d tool_turn_rad{0, 0, 0};
  bool tool_is_frame = false;    // its turn is among the parameters
  bool all_parameters = false;   // also those that say the same twice
  bool from_other_file = false;  // a URDF that lies beside the rig file
};

/// The model of an arm. At least one row, names of joints that differ, `follows` names one of
/// them or a joint that is no row (then it becomes one that moves nothing else).
[[nodiscard]] std::shared_ptr<const RobotModel> serial_model(const SerialRobot& robot);

/// The arm that a model was made from, with the values of `v` in it. `model` is of this kind.
[[nodiscard]] SerialRobot serial_robot(const RobotModel& model, const Values& v);

/// Rows from the first to the last link of a URDF. Empty `base` or `tip`: its root, its one
/// leaf. The error says what is wrong with the text or which link there is not.
[[nodiscard]] tl::expected<SerialRobot, std::string> read_urdf(
    std::string_view text, const std::string& base, const std::string& tip);

/// The row of the registry.
extern const RobotKind serial;

}  // namespace sixdial::geometry
