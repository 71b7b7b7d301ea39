// The measurement rig as numbers: nominal robot, cuboid and dials (spec 1). A rig file
// (rig.toml) is read and written by session/rig_file.h. Millimetre, radian, newton.
#pragma once

#include <Eigen/Core>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "geometry/deviations.h"
#include "geometry/instruments/contact.h"
#include "geometry/robots/five_bar.h"

namespace sixdial::geometry {

/// What the cuboid turns with.
enum class Mount {
  kDistal1,  // with the distal link of leg 1
  kDistal2,  // with the distal link of leg 2
  kFree,     // gamma is an unknown of each sample
};

struct Robot {
  /// What it is; never null.
  std::shared_ptr<const RobotModel> model = five_bar_model();
  /// In the order of model->parameters.
  Eigen::VectorXd nominal = Eigen::VectorXd::Zero(kParameterCount);
  WorkingMode working_mode{};
  Assembly assembly = Assembly::kLeft;
  std::string connection;  // "modbus-tcp://host:port", "manual" or empty
};

struct Cuboid {
  double side_mm = 80.0;
  Mount mount = Mount::kDistal2;
  Eigen::Vector2d reference_pose_mm{28.0, 48.0};  // gamma = clamp angle here
  CuboidDeviations deviations{};
};

struct Dial {
  std::string id;
  DialGeometry geometry;
  double resolution_mm = 0.001;
  double accuracy_mm = 0.006;
  double repeatability_mm = 0.002;  // standard deviation of one reading at rest
  double force_n = 1.0;             // at zero displacement
  double spring_n_per_mm = 0.03;
  std::string connection;
  DialDeviations deviations{};
};

/// A point that an instrument refers to: on the tool, an anchor, a socket.
struct ReferencePoint {
  std::string name;
  std::optional<Eigen::Vector3d> at_mm{};  // in W, or in the tool's frame; empty: nobody knows
  double sd_mm = 0.0;                      // how well `at_mm` is known, each axis; 0: exactly
};

/// A surface that a probe touches: a plane through `at_mm`, or a sphere about it.
struct Surface {
  ReferencePoint place{};
  std::optional<double> radius_mm{};  // of a sphere; empty: a plane
  Eigen::Vector3d normal{0, 0, 1};    // of a plane, towards the probe
};

/// Known distance of two sockets.
struct SocketDistance {
  std::string first, second;
  double mm = 0.0;
  double sd_mm = 0.0;
};

/// What measures, by the name of its kind in the registry.
struct Instrument {
  std::string kind = "dials_on_cuboid";
  double sd_mm = 0.0;   // of a measured position, distance or touch; 0: nobody knows
  double sd_rad = 0.0;  // of a measured orientation; 0: nobody knows
  int dimensions = 2;   // of a measured position
  std::string orientation = "rotation vector";  // what three angles in a file mean
  std::vector<ReferencePoint>
      tool_points{};  // measured beside the tool's own point, in the tool's frame
  std::vector<ReferencePoint> anchors{};
  std::vector<ReferencePoint> sockets{};
  std::vector<SocketDistance> socket_distances{};
  std::vector<Surface> surfaces{};
};

struct Rig {
  std::string name;
  Robot robot;
  Instrument instrument;
  Cuboid cuboid;
  std::vector<Dial> dials;
  /// Largest position error that the user accepts; empty: none is stated.
  std::optional<double> tolerance_mm{};
  /// Dials on a cuboid measure it, or positions that were computed from such.
  [[nodiscard]] bool on_cuboid() const { return instrument.kind == Instrument{}.kind; }
  /// Index of a dial by id.
  [[nodiscard]] std::optional<std::size_t> find_dial(std::string_view id) const;
  [[nodiscard]] std::vector<DialGeometry> dial_geometries() const;
  /// Whether the file says anywhere how well the rig's own geometry is known.
  [[nodiscard]] bool states_deviations() const;
};

/// The rig and robot of spec 1: centre (28, 48), side 80, dials A..F.
[[nodiscard]] Rig default_rig();
/// Table 2's identified parameters [mm, rad].
[[nodiscard]] ParameterVector table_2_robot();

/// The robot's frame that the cuboid turns with; empty for a free mount or a robot without
/// such a link.
[[nodiscard]] std::optional<int> cuboid_link(const Rig& rig);

/// Angle in W [rad] of the cuboid's link at the reference pose by nominal parameters; 0 where
/// there is none. Fails if the reference pose cannot be reached.
[[nodiscard]] tl::expected<double, KinematicTrouble> reference_link_angle(const Rig& rig);

/// gamma [rad] at a pose: link angle now minus at the reference, plus the clamp angle;
/// continuous around the reference (within +-pi). 0 + clamp for a free mount.
[[nodiscard]] double cuboid_angle(
    const Rig& rig, double reference_angle_rad, double link_rad, double clamp_rad);
/// The same of a five-bar.
[[nodiscard]] double cuboid_angle(
    const Rig& rig, double reference_angle_rad, const ForwardPose& pose, double clamp_rad);

}  // namespace sixdial::geometry
