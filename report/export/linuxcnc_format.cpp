// LinuxCNC's genserkins: HAL lines with Craig's parameters of six turning joints. Lengths in
// the machine's unit (mm here), ALPHA in rad; the zero of each joint is not among them. Source:
// src/emc/kinematics/genserfuncs.c of LinuxCNC (six links, all of them angular).
#include <fmt/format.h>
#include <fmt/ranges.h>

#include <cmath>
#include <string>
#include <vector>

#include "geometry/units.h"
#include "report/export/craig_rows.h"
#include "report/export/holding.h"
#include "report/export/joint_chain.h"

namespace sixdial::report {
namespace {

constexpr double kFarAway_mm = 1e5;  // then two axes are nearly parallel

/// What gives an arm whose rows are near the nominal ones.
std::string without_far_normals(const geometry::RobotModel& robot) {
  std::vector<std::string> second_angles;
  for (const geometry::ParameterInfo& each : robot.parameters) {
    if (each.name.starts_with("beta")) second_angles.push_back(each.name);
  }
  if (second_angles.empty()) return "";
  return fmt::format(
      ". `sixdial calibrate SESSION --fix {}` finds the arm that has no such D",
      fmt::join(second_angles, ","));
}

HeldModel hold(const studies::ExportedModel& full, const ExportOptions&) {
  constexpr std::string_view kFormat = "genserkins";
  if (!is_arm(full)) refuse_robot(full, kFormat, "it has six turning joints in a row");
  const JointChain chain = joint_chain(full);
  const std::string trouble = not_six_turning_joints(chain);
  if (!trouble.empty()) refuse_robot(full, kFormat, trouble);
  Holding holding(full);
  holding.leave_nominal(
      {.what = "where the arm stands",
       .why = "genserkins begins at the first axis",
       .instead = "Enter it as the offset of a coordinate system (G10 L2)."},
      is_of_base);
  holding.leave_nominal(
      {.what = "the tool on the last link",
       .why = "genserkins ends at the last axis",
       .instead = "Enter it in the tool table."},
      is_of_tool);
  holding.leave_out_effects(
      "genserkins has the geometry alone", kBetterWithoutCauses,
      [&](const simulation::ActiveEffect& each) { return is_settled_shift(each, full); });
  holding.leave_out_learned();
  for (const CraigRow& row : craig_arm(chain).rows) {
    if (std::abs(row.d_mm) < kFarAway_mm) continue;
    holding.note(
        "Two axes are nearly parallel, so that their common normal is far away: the large D of "
        "their rows cancel out, and theta of these joints is another one" +
        without_far_normals(full.robot()));
    break;
  }
  return holding.done();
}

constexpr const char* kAboutZeros =
    "A joint's position in LinuxCNC is the encoder's angle plus theta. A machine that runs "
    "with "
    "the nominal arm has the nominal theta in HOME_OFFSET: add the difference to HOME_OFFSET "
    "of "
    "that joint in the INI file.";

std::string write(
    const studies::ExportedModel& full, const HeldModel& held, const ExportOptions&) {
  const CraigArm arm = craig_arm(joint_chain(held.model));
  const CraigArm whole = craig_arm(joint_chain(full));
  const CraigArm before = craig_arm(nominal_chain(full));
  std::string text = commented(heading(full, held, "linuxcnc"), "# ");
  text += commented(
      {"The frame on the first axis in the instrument's frame:", pose_in_words(whole.base),
       "The tool in the frame of the last axis:", pose_in_words(whole.tool), kAboutZeros},
      "# ");
  for (std::size_t i = 0; i < arm.rows.size(); ++i) {
    const double theta_deg = arm.rows[i].theta_rad * geometry::kDegPerRad;
    const double nominal_deg = before.rows[i].theta_rad * geometry::kDegPerRad;
    text += fmt::format(
        "# [JOINT_{}] theta = {} deg, nominal {} deg, difference {} deg\n", i,
        exactly(theta_deg), exactly(nominal_deg),
        exactly(std::remainder(theta_deg - nominal_deg, 360.0)));
  }
  for (std::size_t i = 0; i < arm.rows.size(); ++i) {
    const CraigRow& row = arm.rows[i];
    text += fmt::format(
        "setp genserkins.A-{0} {1}\nsetp genserkins.ALPHA-{0} {2}\nsetp genserkins.D-{0} {3}\n",
        i, exactly(row.a_mm), exactly(row.alpha_rad), exactly(row.d_mm));
  }
  return text;
}

}  // namespace

extern constinit const ExportFormat linuxcnc_format;
constinit const ExportFormat linuxcnc_format{
    .name = "linuxcnc",
    .in_words = "LinuxCNC's genserkins",
    .about = "HAL lines of genserkins, for six turning joints",
    .file_name = "genserkins.hal",
    .hold = hold,
    .write = write};

}  // namespace sixdial::report
