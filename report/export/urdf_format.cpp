// A URDF: frames of joints in metres, angles as roll, pitch and yaw. What it has of an arm is
// all geometry, base and tool included; it has no place for what bends joint values. Source:
// the XML specification of URDF (wiki.ros.org/urdf/XML), as liburdfdom reads it.
#include <fmt/format.h>

#include "report/export/holding.h"
#include "report/export/joint_chain.h"
#include "report/export/urdf_correction.h"

namespace sixdial::report {
namespace {

using geometry::JointKind;

HeldModel hold(const studies::ExportedModel& full, const ExportOptions& options) {
  if (!is_arm(full)) {
    refuse_robot(full, "a URDF", "it is a tree of joints, and this robot closes a loop");
  }
  Holding holding(full);
  const bool corrects = !options.urdf_text.empty();
  if (corrects) {
    holding.leave_nominal(
        {.what = "where the arm stands",
         .why = "of the URDF that is corrected the joints of the arm are set alone",
         .instead = "Enter it where the URDF or the program places the arm's base."},
        is_of_base);
    holding.leave_nominal(
        {.what = "the tool on the last link",
         .why = "what is behind the last joint of the URDF stays as it is",
         .instead = "Enter it where the tool's link or frame is defined."},
        is_of_tool);
  }
  holding.leave_out_effects(
      "a URDF has the geometry alone", kBetterWithoutCauses,
      [&](const simulation::ActiveEffect& each) { return is_settled_shift(each, full); });
  holding.leave_out_learned();
  if (corrects) return holding.done();
  holding.note(
      "Limits of effort and velocity are 0 where none are known: put in those of the arm, with "
      "its masses and shapes");
  return holding.done();
}

std::string escaped(const std::string& text) {
  std::string result;
  for (const char each : text) {
    switch (each) {
      case '&':
        result += "&amp;";
        break;
      case '<':
        result += "&lt;";
        break;
      case '>':
        result += "&gt;";
        break;
      case '"':
        result += "&quot;";
        break;
      default:
        result += static_cast<unsigned char>(each) < 0x20 ? ' ' : each;
    }
  }
  return result;
}

constexpr double kMetrePerMm = 1e-3;

std::string origin_of(const geometry::Pose<double>& pose) {
  const Eigen::Vector3d at_m = pose.p * kMetrePerMm;
  return fmt::format(
      "    <origin xyz=\"{}\" rpy=\"{}\"/>\n", exactly(at_m, " "),
      exactly(roll_pitch_yaw(pose.R), " "));
}

std::string fixed_joint(
    const std::string& name, const std::string& parent, const std::string& child,
    const geometry::Pose<double>& pose) {
  return fmt::format(
      "  <joint name=\"{}\" type=\"fixed\">\n    <parent link=\"{}\"/>\n    <child "
      "link=\"{}\"/>\n{}  </joint>\n  <link name=\"{}\"/>\n",
      name, parent, child, origin_of(pose), child);
}

/// A joint that moves no link of its own, which others follow.
std::string lone_joint(const geometry::JointInfo& joint) {
  const bool turns = joint.kind == JointKind::kRevolute;
  const double unit = turns ? 1.0 : kMetrePerMm;
  return fmt::format(
      "  <joint name=\"{0}\" type=\"{1}\">\n    <parent link=\"base_link\"/>\n    <child "
      "link=\"{0}_alone\"/>\n    <axis xyz=\"0 0 1\"/>\n    <limit lower=\"{2}\" "
      "upper=\"{3}\" effort=\"0\" velocity=\"0\"/>\n  </joint>\n  <link name=\"{0}_alone\"/>\n",
      escaped(joint.name), turns ? "revolute" : "prismatic", exactly(joint.low * unit),
      exactly(joint.high * unit));
}

std::string joint_text(
    const ChainJoint& joint, const geometry::JointInfo& usual, const std::string& parent,
    const std::string& child) {
  const bool turns = joint.kind == JointKind::kRevolute;
  const bool limited = joint.low && joint.high;
  // Angles may go on for ever; a slide without limits is not read.
  const bool with_limits = limited || !turns;
  const double unit = turns ? 1.0 : kMetrePerMm;
  std::string text = fmt::format(
      "  <joint name=\"{}\" type=\"{}\">\n    <parent link=\"{}\"/>\n    <child "
      "link=\"{}\"/>\n{}    <axis xyz=\"{}\"/>\n",
      escaped(joint.name), turns ? (limited ? "revolute" : "continuous") : "prismatic", parent,
      child, origin_of(joint.origin), exactly(joint.axis, " "));
  if (with_limits) {
    text += fmt::format(
        "    <limit lower=\"{}\" upper=\"{}\" effort=\"0\" velocity=\"0\"/>\n",
        exactly(joint.low.value_or(usual.low) * unit),
        exactly(joint.high.value_or(usual.high) * unit));
  }
  if (!joint.follows.empty()) {
    // Of joints of two kinds the ratio has a unit.
    const bool leader_turns = usual.kind == JointKind::kRevolute;
    const double per = unit / (leader_turns ? 1.0 : kMetrePerMm);
    text += fmt::format(
        "    <mimic joint=\"{}\" multiplier=\"{}\" offset=\"{}\"/>\n", escaped(joint.follows),
        exactly(joint.ratio * per), exactly(joint.offset * unit));
  }
  return text + fmt::format("  </joint>\n  <link name=\"{}\"/>\n", child);
}

std::string write(
    const studies::ExportedModel& full, const HeldModel& held, const ExportOptions& options) {
  if (!options.urdf_text.empty()) {
    return corrected_urdf(
        options.urdf_text, nominal_chain(full), joint_chain(held.model),
        "\n" + commented(heading(full, held, "urdf"), "  ", true));
  }
  const JointChain chain = joint_chain(held.model);
  const auto& joints = full.robot().joints;
  std::string text = "<?xml version=\"1.0\"?>\n<!--\n";
  text += commented(heading(full, held, "urdf"), "  ", true);
  const std::string& name = full.base->rig().name;
  text += fmt::format(
      "-->\n<robot name=\"{}\">\n  <link name=\"world\"/>\n",
      name.empty() ? "robot" : escaped(name));
  text += fixed_joint("world_to_base", "world", "base_link", chain.base);
  for (const geometry::JointInfo& each : joints) {
    bool moves = false;
    for (const ChainJoint& joint : chain.joints) moves = moves || joint.name == each.name;
    if (!moves) text += lone_joint(each);
  }
  std::string parent = "base_link";
  for (std::size_t i = 0; i < chain.joints.size(); ++i) {
    const std::string child = "link" + std::to_string(i + 1);
    text += joint_text(chain.joints[i], joints[chain.joints[i].joint], parent, child);
    parent = child;
  }
  text += fixed_joint("to_tool", parent, "tool", chain.tool);
  return text + "</robot>\n";
}

}  // namespace

extern constinit const ExportFormat urdf_format;
constinit const ExportFormat urdf_format{
    .name = "urdf",
    .in_words = "a URDF",
    .about = "any arm with its base and tool",
    .file_name = "robot.urdf",
    .hold = hold,
    .write = write};

}  // namespace sixdial::report
