// What a kind of robot is. A kind is one file in geometry/robots/ and one row in
// geometry/robot_kinds.cpp (or a row added at run time): names of joints, parameters and
// branches, and one function from joint values and parameters to where the tool and the frames
// on the way are. Calibration, simulation and diagnosis know no more of a robot than this.
//
//   q, v, assembly --forward--> frames: [0] the tool E, then the kind's own (links, elbows)
//
//   const RobotModel& robot = *find_robot_kind("five_bar")->example();
//   Frames at(robot);
//   if (robot.forward(robot.nominal, q, robot.assemblies[0].number, at.X)) use(at.X[0].p);
//
// Frame W (the table), mm and rad. A revolute joint's value is in rad, a prismatic one's in mm.
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
};
/// A clause for messages: "the legs cannot reach this pose".
[[nodiscard]] std::string_view describe(KinematicTrouble trouble);

/// Which of the poses that the same joint values allow a robot is in; the number as in a rig
/// file. Each kind lists its own; a serial arm has one. The two names are the five-bar's (beta
/// of equation (3): E to the left or to the right of O3 -> O4).
enum class Assembly : int { kLeft = +1, kRight = -1 };

enum class JointKind { kRevolute, kPrismatic };

struct JointInfo {
  std::string name;  // "theta1", "q3", or what a URDF calls it
  JointKind kind = JointKind::kRevolute;
  /// The range that this robot usually moves in [rad or mm]; drawn from by tests, no limit.
  double low = -1.0;
  double high = 1.0;
  [[nodiscard]] std::string_view unit() const {
    return kind == JointKind::kRevolute ? "rad" : "mm";
  }
};

/// One of several solutions, by the number or the text that a rig file gives.
struct BranchInfo {
  int number = 0;
  std::string name;  // "left"; "++"
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
};

using Reached = tl::expected<void, KinematicTrouble>;

/// Many samples of one robot, for kernels that take all of them in one call.
struct PositionSamples {
  Eigen::MatrixXd q;               // joints x samples
  Eigen::MatrixXd p_WE;            // measured tool positions, 2 or 3 x samples [mm]
  std::vector<Assembly> assembly;  // by sample
};

/// The arithmetic of a fit for all samples and many parameter vectors in one call, for kinds
/// that have it in vector instructions. It must agree with `forward` (a law tests it).
class RobotKernel {
 public:
  RobotKernel() = default;
  RobotKernel(const RobotKernel&) = delete;
  RobotKernel& operator=(const RobotKernel&) = delete;
  virtual ~RobotKernel() = default;
  /// rmse_mm[k]: root of the mean squared distance between measured and computed positions for
  /// the parameters in column k of `v`; +inf where a pose cannot be reached.
  virtual void rmse(
      const Eigen::Ref<const Eigen::MatrixXd>& v, Eigen::Ref<Eigen::VectorXd> rmse_mm) const = 0;
};

/// The robot at hand: what its kind and its rig file fix and calibration leaves alone, and what
/// its parameters are. Immutable; shared by all that use the rig.
struct RobotModel {
  const RobotKind* kind = nullptr;
  std::vector<JointInfo> joints;
  std::vector<ParameterInfo> parameters;
  Eigen::VectorXd nominal;              // where a rig file gives no other value
  std::vector<std::string> frames;      // names; the first is the tool, "E"
  std::vector<BranchInfo> assemblies;   // poses that the same joint values allow, at least one
  std::vector<BranchInfo> modes;        // joint values that the same pose allows, at least one
  std::shared_ptr<const void> details;  // what else the kind keeps, such as a URDF's chain

  [[nodiscard]] std::optional<int> find_frame(std::string_view name) const;
  [[nodiscard]] std::optional<int> find_parameter(std::string_view name) const;

  /// Poses of all frames. `X` has one element for each of `frames`.
  [[nodiscard]] Reached forward(
      std::span<const double> v, std::span<const double> q, Assembly assembly,
      std::span<Pose<double>> X) const;
  /// The same with derivatives by joints and by parameters. `at` was made for this robot.
  [[nodiscard]] Reached forward_derivative(
      std::span<const double> v, std::span<const double> q, Assembly assembly,
      Frames& at) const;
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
};

/// One row of the registry.
struct RobotKind {
  std::string_view name;      // "five_bar", as in [robot] model
  std::string_view in_words;  // "planar five-bar"
  /// A typical robot of this kind with sensible nominal values. Not null.
  std::shared_ptr<const RobotModel> (*example)() = nullptr;
  /// What the keys of [robot] make of it, beyond parameter values. Null: `example` is the one
  /// robot of this kind. Parameter values are read by each parameter's own rig_key.
  tl::expected<std::shared_ptr<const RobotModel>, RobotFileFault> (*from_file)(
      const RobotFile& file) = nullptr;
  /// Keys of [robot] that from_file reads.
  std::vector<std::string_view> file_keys{};

  Reached (*forward)(
      const RobotModel& robot, std::span<const double> v, std::span<const double> q,
      Assembly assembly, std::span<Pose<double>> X) = nullptr;
  Reached (*forward_derivative)(
      const RobotModel& robot, std::span<const double> v, std::span<const double> q,
      Assembly assembly, Frames& at) = nullptr;
  /// Optional. Joint values that put the tool at X_WE in a mode (a number of robot.modes), each
  /// the one nearest to `near` where it can be told apart by whole turns.
  tl::expected<Eigen::VectorXd, KinematicTrouble> (*inverse)(
      const RobotModel& robot, std::span<const double> v, const Pose<double>& X_WE, int mode,
      std::span<const double> near) = nullptr;
  /// Optional: the fast way for whole sessions.
  std::unique_ptr<RobotKernel> (*kernel)(
      const RobotModel& robot, const PositionSamples& samples) = nullptr;
};

/// Every kind, by name. Rows added at run time come last and stay for the rest of the program.
[[nodiscard]] std::span<const RobotKind* const> robot_kinds();
[[nodiscard]] const RobotKind* find_robot_kind(std::string_view name);
/// Throws std::invalid_argument if the name is taken or a needed member is missing. Not while
/// another thread uses the registry.
void add_robot_kind(RobotKind kind);

}  // namespace sixdial::geometry
