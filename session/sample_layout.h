// What one sample of a rig holds: a value for each joint of its robot, a value for each channel
// of its instrument. Files, the store, the socket and the report take names and units from
// here.
//
//   const SampleLayout layout = layout_of(session.rig);
//   for (std::size_t i = 0; i < layout.joints.size(); ++i) {
//     fmt::print("{} = {}\n", layout.joints[i].column(), sample.q[i]);  // theta1_rad = 1.5
//   }
#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include "geometry/rig.h"
#include "session/session.h"

namespace sixdial::session {

/// A joint's value is an angle [rad] or a length [mm].
struct Joint {
  std::string name;  // "theta1"
  std::string unit;  // "rad" or "mm"
  /// A file may give this angle in degrees too ("q1_deg").
  bool degrees_too = false;
  /// True: the alias q1 (q2, ...) is not accepted.
  bool known_by_name_only = true;
  [[nodiscard]] std::string column() const { return name + '_' + unit; }
  /// Of the value that it was told, beside the one that was read back.
  [[nodiscard]] std::string command_column() const { return name + "_command_" + unit; }
};

struct Channel {
  std::string name;  // "dial_A"; "x", "y", "z": the tool's position as an instrument gives it
  std::string unit;  // "mm"
  double resolution = 0.0;  // in `unit`; 0: not known
  [[nodiscard]] std::string column() const { return name + '_' + unit; }
};

struct SampleLayout {
  std::vector<Joint> joints;
  std::vector<Channel> channels;  // the dials in the rig's order, then the coordinates
  std::size_t dials = 0;          // so many of `channels`
  /// Of the tool's position and of a target: "x", "y" and, of a robot in space, "z".
  std::vector<std::string> axes;
  /// What the instrument shows beside them: "rx" [rad], "distance_K1", "probe_bed",
  /// "socket_S1_x".
  std::vector<Channel> others{};
  bool gives_position = true;          // the coordinates are channels of the instrument
  std::vector<std::string> sockets{};  // that a row may name
  std::string orientation{};           // what three angles of a row mean
};

/// What the three angles rx, ry, rz of a file mean, as rig.toml says it (`orientation`).
inline constexpr std::string_view kRotationVector = "rotation vector";
/// Rotation vector of three angles [rad]: "intrinsic xyz" (turns about the moving axes in this
/// order), "extrinsic xyz" (about fixed ones), any order of axes. Empty: no such convention.
[[nodiscard]] std::optional<Eigen::Vector3d> turn_of_angles(
    std::string_view convention, const Eigen::Vector3d& angles_rad);

[[nodiscard]] SampleLayout layout_of(const geometry::Rig& rig);

/// A layout from its parts, for any number of joints, dials and coordinates.
[[nodiscard]] SampleLayout make_layout(
    std::vector<Joint> joints, const std::vector<geometry::Dial>& dials,
    std::vector<std::string> axes);

/// "joint angles (1.5, 3) rad"; with lengths among them "joints (1.5 rad, 20 mm)".
[[nodiscard]] std::string joints_in_words(const SampleLayout& layout, const Eigen::VectorXd& q);

/// The tool's position [mm] in W as an instrument gave it: the channels after the `dials` first
/// ones. Empty: the sample has none.
[[nodiscard]] std::optional<Position> position_of(const Sample& sample, std::size_t dials);
/// Sets the position of a sample; empty: removes it.
void set_position(
    Sample& sample, std::size_t dials, const std::optional<Position>& position_mm);

}  // namespace sixdial::session
