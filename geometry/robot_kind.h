// What a kind of robot is. A kind is one file in geometry/robots/ and one row in
// geometry/robot_kind.cpp (or a row added at run time): names of joints, parameters and
// branches, and one function from joint values and parameters to where the tool and the frames
// on the way are. Calibration, simulation and diagnosis know no more of a robot than this.
//
//   q, v, assembly --forward--> frames: [0] the tool E, then the kind's own (links, elbows)
//
// Frame W (the table), mm and rad. A revolute joint's value is in rad, a prismatic one's in mm.
//
// Example:
//   const auto robot = find_robot_kind("five_bar")->example();
//   const Eigen::Vector2d q(2.2, 0.9);  // theta1, theta2 [rad]
//   Frames at(*robot);
//   if (robot->forward(robot->nominal, q, Assembly::kLeft, at.X)) show(at.X[0].p);  // p_WE
//   robot->parameters[0].name;  // -> "l11"
#pragma once

#include <Eigen/Core>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <tl/expected.hpp>
#include <utility>
#include <variant>
#include <vector>

#include "geometry/parameter.h"
#include "geometry/pose.h"

namespace sixdial::geometry {

/// Why a pose does not exist, or exists without a usable derivative.
enum class KinematicTrouble {
  kOutOfReach,        // the links cannot close
  kStretched,         // a dyad is straight: position exists, its branch and derivative do not
  kFolded,            // a dyad is folded onto itself
  kCoincidentElbows,  // D = 0: E is anywhere on a circle
  kBadParameters,     // a length is not positive or a number is not finite
  kNoInverse,         // this kind of robot cannot say which joint values reach a pose
};
/// A clause for messages: "the legs cannot reach this pose".
[[nodiscard]] std::string_view describe(KinematicTrouble trouble);

/// Which solution of the forward kinematics: the same joint values may allow several poses. The
/// number is that of the rig file. Each kind lists its own; a serial arm has one. The two names
/// are the five-bar's (beta
/// of equation (3): E to the left or to the right of O3 -> O4).
enum class Assembly : int { kLeft = +1, kRight = -1 };

/// Which solution of the inverse kinematics: several joint values may put the tool at the same
/// pose. A number of the robot's `modes`. A kind with two legs numbers them by elbow sides: +1
/// turns the proximal link counter-clockwise from the line O -> E; {+1, +1} is 0, {-1, -1}
/// is 3.
struct WorkingMode {
  constexpr WorkingMode() = default;
  constexpr explicit WorkingMode(int a_number) : number(a_number) {}
  constexpr WorkingMode(int leg1, int leg2) : number((leg1 < 0 ? 2 : 0) + (leg2 < 0 ? 1 : 0)) {}
  int number = 0;
  /// Elbow side of leg 0 or 1.
  [[nodiscard]] constexpr int leg(int i) const {
    return (number & (i == 0 ? 2 : 1)) != 0 ? -1 : +1;
  }
  friend bool operator==(const WorkingMode&, const WorkingMode&) = default;
};

enum class JointKind { kRevolute, kPrismatic };

struct JointInfo {
  std::string name;  // "theta1", "q3", or what a URDF calls it
  JointKind kind = JointKind::kRevolute;
  /// Values that this robot usually takes [rad or mm]: tests draw from here. It is no limit of
  /// the joint.
  double low = -1.0;
  double high = 1.0;
  bool geared = false;  // another link follows by gears: after a whole turn the pose is another
  [[nodiscard]] std::string_view unit() const {
    return kind == JointKind::kRevolute ? "rad" : "mm";
  }
};

/// One of several solutions, by the number or the text that a rig file gives.
struct BranchInfo {
  int number = 0;
  std::string name;  // "left"; "++"
};

/// Parameters that together move nothing, or almost nothing, and how people say it.
struct NamedDirection {
  std::vector<std::pair<std::string, double>> parts;  // name, change in scaled parameters
  std::string words;
};

/// A number of the robot that does the same as other parameters together: it keeps its nominal
/// value and is not fitted.
struct SaidTwice {
  std::string name;  // "d1"
  std::string by;    // "base_z": what moves the tool just so
};

/// A robot in one pose as a drawing of the plane shows it [mm, W].
struct Sketch {
  enum class Part { kBase, kProximal, kDistal, kMotor, kJoint, kTool };
  struct Line {
    Eigen::Vector2d from, to;
    Part part;
  };
  struct Dot {
    Eigen::Vector2d at;
    Part part;
    std::string name;
    Eigen::Vector2d name_off;  // where its name stands, from the dot
    std::string anchor;        // "start", "middle" or "end" of the name stands there
  };
  std::vector<Line> lines;
  std::vector<Dot> dots;
  Eigen::Vector2d base{0, 0};               // origin of frame B
  double base_rad = 0.0;                    // its turn in W
  std::optional<KinematicTrouble> trouble;  // why there are neither lines nor dots
};

struct RobotKind;
struct RobotModel;

/// Poses of all frames of a robot, and their derivatives once these were asked for.
struct Frames {
  Frames() = default;
  explicit Frames(const RobotModel& robot);
  std::vector<Pose<double>> X;
  std::vector<Twists> by_q;  // frame by frame, one column a joint
  std::vector<Twists> by_v;  // one column a parameter
  /// Nobody asks for the derivatives of other frames than the tool's: a kind may leave them.
  bool tool_only = false;
};

using Reached = tl::expected<void, KinematicTrouble>;
/// A vector, or a part of one, without a copy.
using Values = Eigen::Ref<const Eigen::VectorXd>;

/// The robot at hand: what its kind and its rig file fix and calibration leaves alone, and what
/// its parameters are. Immutable; shared by all that use the rig.
struct RobotModel {
  const RobotKind* kind = nullptr;
  std::vector<JointInfo> joints;
  std::vector<ParameterInfo> parameters;
  Eigen::VectorXd nominal;             // where a rig file gives no other value
  std::vector<std::string> frames;     // names; the first is the tool, "E"
  std::vector<BranchInfo> assemblies;  // poses that the same joint values allow, at least one
  std::vector<BranchInfo> modes;       // joint values that the same pose allows, at least one
  std::string mode_in_words;           // what a mode's name tells; empty: there is one mode
  std::vector<NamedDirection> named_directions;
  std::vector<SaidTwice> said_twice;
  int axes = 2;                         // of its work: 2 in the plane z = 0, 3 in space
  bool from_other_file = false;         // made with a file that lies beside rig.toml
  std::shared_ptr<const void> details;  // what else the kind keeps, such as a URDF's chain

  [[nodiscard]] std::optional<int> find_frame(std::string_view name) const;
  [[nodiscard]] std::optional<int> find_parameter(std::string_view name) const;
  /// Name of a mode, as "++"; empty if there is none of that number.
  [[nodiscard]] std::string_view mode_name(WorkingMode mode) const;
  [[nodiscard]] std::optional<WorkingMode> find_mode(std::string_view name) const;
  [[nodiscard]] int joint_count() const { return static_cast<int>(joints.size()); }
  [[nodiscard]] int parameter_count() const { return static_cast<int>(parameters.size()); }

  /// Poses of all frames. `X` has one element for each of `frames`.
  [[nodiscard]] Reached forward(
      const Values& v, const Values& q, Assembly assembly, std::span<Pose<double>> X) const;
  /// The same with derivatives by joints and by parameters. `at` was made for this robot.
  [[nodiscard]] Reached forward_derivative(
      const Values& v, const Values& q, Assembly assembly, Frames& at) const;
};

/// [robot] of a rig file as a kind reads it.
struct FileValue {
  using Table = std::map<std::string, FileValue, std::less<>>;
  std::variant<bool, double, std::string, std::vector<FileValue>, Table> value;
};
struct RobotFile {
  FileValue::Table robot;                // keys of [robot]
  std::vector<FileValue::Table> joints;  // [[joint]] rows
  /// The text of a file that lies beside rig.toml; throws what the reader of rig.toml throws.
  std::function<std::string(const std::string& name)> text_beside;
};
/// A key that cannot be used, for a message that names its line.
struct RobotFileFault {
  std::string key;
  std::string what;  // "is not a file name"
  std::string hint;
  std::optional<std::size_t> joint{};  // the [[joint]] row that has it, from 0
};

/// What a kind writes of a robot beside the parameters that have a key of their own.
struct RobotFileText {
  FileValue::Table robot{};                // keys of [robot]
  std::vector<FileValue::Table> joints{};  // [[joint]] rows
};

/// One row of the registry.
struct RobotKind {
  std::string_view name;      // "five_bar", as in [robot] model
  std::string_view in_words;  // "planar five-bar"
  /// Some of its joints have no drive and no encoder.
  bool has_passive_joints = false;
  /// A typical robot of this kind with sensible nominal values. Not null.
  std::shared_ptr<const RobotModel> (*example)() = nullptr;
  /// What the keys of [robot] make of it, beyond parameter values. Null: `example` is the one
  /// robot of this kind. Parameter values are read by each parameter's own rig_key.
  tl::expected<std::shared_ptr<const RobotModel>, RobotFileFault> (*from_file)(
      const RobotFile& file) = nullptr;
  /// Keys of [robot] that from_file reads.
  std::span<const std::string_view> file_keys{};
  /// The opposite of from_file: keys of [robot] that give this robot, with `nominal` in place
  /// of the model's values. Null: there is nothing to write.
  RobotFileText (*to_file)(const RobotModel& robot, const Eigen::VectorXd& nominal) = nullptr;

  Reached (*forward)(
      const RobotModel& robot, std::span<const double> v, std::span<const double> q,
      Assembly assembly, std::span<Pose<double>> X) = nullptr;
  Reached (*forward_derivative)(
      const RobotModel& robot, std::span<const double> v, std::span<const double> q,
      Assembly assembly, Frames& at) = nullptr;
  /// Optional: inverse kinematics. Gives the joint values that put the tool at X_WE (a planar
  /// robot only its position; R of NaN: turned as it comes) in a working mode. With `near`,
  /// each angle is shifted by whole turns to come as close to it as it can.
  tl::expected<Eigen::VectorXd, KinematicTrouble> (*inverse)(
      const RobotModel& robot, std::span<const double> v, const Pose<double>& X_WE,
      WorkingMode mode, std::span<const double> near) = nullptr;
  /// Optional. The mode that a pose is in. Null: the one whose inverse comes nearest to it.
  tl::expected<WorkingMode, KinematicTrouble> (*mode_of)(
      const RobotModel& robot, std::span<const double> v, std::span<const double> q,
      Assembly assembly) = nullptr;
  /// Optional, for speed: what planar_pose of tool.h says.
  tl::expected<PlanarPose, KinematicTrouble> (*in_plane)(
      const RobotModel& robot, std::span<const double> v, std::span<const double> q,
      Assembly assembly, std::optional<int> link, Eigen::Matrix2Xd* J_q) = nullptr;
  /// Optional. A drawing with its tool at p_WE in the plane. Null: none can be made.
  Sketch (*sketch)(
      const RobotModel& robot, std::span<const double> v, const Eigen::Vector2d& p_WE,
      WorkingMode mode) = nullptr;
};

/// Every kind. Rows added at run time come last and stay for the rest of the program.
[[nodiscard]] std::span<const RobotKind* const> robot_kinds();
[[nodiscard]] const RobotKind* find_robot_kind(std::string_view name);
/// Adds a row, which then stays for the rest of the program. Throws std::invalid_argument if
/// the name is taken or a needed member is missing. No other thread may use the registry
/// meanwhile.
const RobotKind& add_robot_kind(RobotKind kind);

}  // namespace sixdial::geometry
