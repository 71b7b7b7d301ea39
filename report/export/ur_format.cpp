// Universal Robots' default_kinematics.yaml, as ur_description reads it: of each of six joints
// where it stands in the link before, in metres, roll, pitch and yaw; the axis is z. Any six
// turning joints can be said so, second angles between parallel axes (beta) included.
// Source: config/ur10/default_kinematics.yaml and urdf/ur_macro.xacro of ur_description.
#include <fmt/format.h>

#include <array>
#include <string_view>

#include "report/export/holding.h"
#include "report/export/joint_chain.h"

namespace sixdial::report {
namespace {

constexpr std::array<const char*, 6> kNames{"shoulder", "upper_arm", "forearm",
                                            "wrist_1",  "wrist_2",   "wrist_3"};
constexpr std::size_t kHashLetters = 16;

HeldModel hold(const studies::ExportedModel& full, const ExportOptions&) {
  constexpr std::string_view kFormat = "default_kinematics.yaml";
  if (!is_arm(full)) refuse_robot(full, kFormat, "it has six turning joints in a row");
  const std::string trouble = not_six_turning_joints(joint_chain(full));
  if (!trouble.empty()) refuse_robot(full, kFormat, trouble);
  Holding holding(full);
  holding.leave_nominal(
      {.what = "where the arm stands",
       .why = "default_kinematics.yaml begins at the arm's own base",
       .instead = "Enter it where the program or the URDF places base_link."},
      is_of_base);
  holding.leave_nominal(
      {.what = "the tool on the last link",
       .why = "default_kinematics.yaml ends at wrist_3",
       .instead = "Enter it as the tool centre point (TCP)."},
      is_of_tool);
  holding.leave_out_effects(
      "default_kinematics.yaml has the geometry alone", kBetterWithoutCauses,
      [&](const simulation::ActiveEffect& each) { return is_settled_shift(each, full); });
  holding.leave_out_learned();
  return holding.done();
}

constexpr std::string_view kOfHash =
    "The driver compares `hash` with the controller's and tells that they differ: the "
    "controller computes with its own calibration still.";

std::string write(
    const studies::ExportedModel& full, const HeldModel& held, const ExportOptions&) {
  constexpr double kMetrePerMm = 1e-3;
  const JointChain chain = along_z(joint_chain(held.model));
  const JointChain whole = along_z(joint_chain(full));
  std::string text = commented(heading(full, held, "ur"), "# ");
  text += commented(
      {"The arm's base (base_link_inertia of ur_description) in the instrument's frame:",
       pose_in_words(whole.base),
       "The tool in the frame of wrist_3:", pose_in_words(whole.tool), std::string(kOfHash)},
      "# ");
  text += "kinematics:\n";
  for (std::size_t i = 0; i < kNames.size(); ++i) {
    const geometry::Pose<double>& origin = chain.joints[i].origin;
    const Eigen::Vector3d at_m = origin.p * kMetrePerMm;
    const Eigen::Vector3d rpy = roll_pitch_yaw(origin.R);
    text += fmt::format(
        "  {}:\n    x: {}\n    y: {}\n    z: {}\n    roll: {}\n    pitch: {}\n    yaw: {}\n",
        kNames[i], exactly(at_m[0]), exactly(at_m[1]), exactly(at_m[2]), exactly(rpy[0]),
        exactly(rpy[1]), exactly(rpy[2]));
  }
  const std::string& hash = full.inputs.data_hash;
  const std::size_t begins = hash.find(':') == std::string::npos ? 0 : hash.find(':') + 1;
  return text + fmt::format("  hash: sixdial_{}\n", hash.substr(begins, kHashLetters));
}

}  // namespace

extern constinit const ExportFormat ur_format;
constinit const ExportFormat ur_format{
    .name = "ur",
    .in_words = "Universal Robots' default_kinematics.yaml",
    .about = "Universal Robots' default_kinematics.yaml",
    .file_name = "default_kinematics.yaml",
    .hold = hold,
    .write = write};

}  // namespace sixdial::report
