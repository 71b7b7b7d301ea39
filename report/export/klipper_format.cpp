// Klipper's printer.cfg of a linear delta: delta_radius, and of each tower angle [deg],
// arm_length and position_endstop [mm]: the height of the nozzle in the middle of the bed when
// that tower's end stop triggers. A carriage is at height position_endstop + sqrt(arm_length^2
// - delta_radius^2) then; the bed is level and the towers' middle is its origin.
// Source: klippy/kinematics/delta.py and docs/Config_Reference.md of Klipper.
#include <fmt/format.h>
#include <fmt/ranges.h>

#include <Eigen/Geometry>
#include <array>
#include <cmath>

#include "geometry/robots/linear_delta.h"
#include "geometry/rotation.h"
#include "geometry/units.h"
#include "report/export/holding.h"

namespace sixdial::report {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;

constexpr std::array<const char*, 3> kTowers{"a", "b", "c"};

/// Parameters of a delta by name.
struct DeltaNumbers {
  const geometry::RobotModel& robot;
  Eigen::VectorXd v;

  [[nodiscard]] Eigen::Index at(const std::string& name) const {
    return robot.find_parameter(name).value();
  }
  [[nodiscard]] double operator[](const std::string& name) const { return v[at(name)]; }
  [[nodiscard]] Vector3d base() const {
    return {(*this)["base_x"], (*this)["base_y"], (*this)["base_z"]};
  }
  [[nodiscard]] Matrix3d base_turn() const {
    return geometry::turned_by<double>(
        Vector3d((*this)["base_rx"], (*this)["base_ry"], (*this)["base_rz"]));
  }
  /// Of a carriage above the nozzle that is in the middle.
  [[nodiscard]] double up(const std::string& tower) const {
    const double rod = (*this)["rod_" + tower];
    const double radius = (*this)["radius"];
    return std::sqrt(rod * rod - radius * radius);
  }
};

/// How the calibrated base stands against the nominal one: what a turn about the bed's normal
/// and a height do, the towers' angles and end stops do as well.
struct BaseChange {
  double turn_rad = 0.0, height_mm = 0.0;
};
BaseChange change_of(const DeltaNumbers& nominal, const DeltaNumbers& now) {
  const Matrix3d R = nominal.base_turn();
  const Matrix3d turn = R.transpose() * now.base_turn();
  return {
      std::atan2(turn(1, 0) - turn(0, 1), turn(0, 0) + turn(1, 1)),
      R.col(2).dot(now.base() - nominal.base())};
}

/// The base of `model` with nothing of the change but what Klipper holds.
void level_base(studies::ExportedModel& model) {
  const DeltaNumbers nominal{model.robot(), model.nominal};
  const DeltaNumbers now{model.robot(), model.parameters()};
  const BaseChange change = change_of(nominal, now);
  const Matrix3d R = nominal.base_turn();
  const Vector3d at = nominal.base() + R.col(2) * change.height_mm;
  Matrix3d turned = R;
  geometry::turn_about<double>(turned, 2, change.turn_rad);
  const Vector3d turn = geometry::rotation_vector(turned);
  const std::array names{"base_x", "base_y", "base_z", "base_rx", "base_ry", "base_rz"};
  for (std::size_t k = 0; k < names.size(); ++k) {
    const auto axis = static_cast<Eigen::Index>(k % 3);
    model.model[now.at(names[k])] = k < 3 ? at[axis] : turn[axis];
  }
}

HeldModel hold(const studies::ExportedModel& full, const ExportOptions& options) {
  constexpr std::string_view kFormat = "Klipper's delta";
  if (full.robot().kind != &geometry::linear_delta) {
    refuse_robot(full, kFormat, "it has three carriages on upright towers");
  }
  if (static_cast<int>(full.base->rig().robot.assembly) < 0) {
    refuse_robot(full, kFormat, "its platform hangs below the carriages, and not above them");
  }
  if (!options.endstops_mm.empty() && options.endstops_mm.size() != kTowers.size()) {
    throw studies::StudyError(
        studies::StudyErrorCode::kInvalidParams,
        fmt::format("{} end stops are given, and there are 3", options.endstops_mm.size()),
        {{"param", "endstops"}}, "Give position_endstop of stepper_a, stepper_b, stepper_c.");
  }
  Holding holding(full);
  const DeltaNumbers nominal{full.robot(), full.nominal};
  const DeltaNumbers now{full.robot(), full.parameters()};
  const Vector3d shift = nominal.base_turn().transpose() * (now.base() - nominal.base());
  const BaseChange change = change_of(nominal, now);
  const Vector3d tilt = geometry::rotation_vector(
      nominal.base_turn().transpose() * now.base_turn() *
      Eigen::AngleAxisd(-change.turn_rad, Vector3d::UnitZ()).toRotationMatrix());
  if (shift.head<2>().norm() > 0.0 || tilt.norm() > 0.0) {
    holding.leave_out(
        {.what = "shift and tilt of the towers against the bed",
         .why = "Klipper's delta stands upright with its middle at the origin",
         .instead = "A bed mesh, or [bed_tilt], makes up for a tilt.",
         .values =
             {fmt::format("x = {:.6f} mm", shift.x()), fmt::format("y = {:.6f} mm", shift.y()),
              fmt::format("about x = {:.6f} deg", tilt.x() * geometry::kDegPerRad),
              fmt::format("about y = {:.6f} deg", tilt.y() * geometry::kDegPerRad)}},
        level_base);
  }
  holding.leave_out_effects(
      "Klipper's delta has the geometry alone", kBetterWithoutCauses,
      [](const simulation::ActiveEffect&) { return false; });
  holding.leave_out_learned();
  if (options.endstops_mm.empty()) {
    holding.note(
        "position_endstop is not written, because only printer.cfg knows it: add what each "
        "comment says to it, or give its three values as endstops");
  }
  return holding.done();
}

std::string write(
    const studies::ExportedModel& full, const HeldModel& held, const ExportOptions& options) {
  const DeltaNumbers nominal{full.robot(), full.nominal};
  const DeltaNumbers now{full.robot(), held.model.parameters()};
  const BaseChange change = change_of(nominal, now);
  std::string text = commented(heading(full, held, "klipper"), "# ");
  text +=
      fmt::format("[printer]\nkinematics: delta\ndelta_radius: {}\n", exactly(now["radius"]));
  for (std::size_t i = 0; i < kTowers.size(); ++i) {
    const std::string tower = kTowers[i];
    const double angle_deg = (now["angle_" + tower] + change.turn_rad) * geometry::kDegPerRad;
    text += fmt::format(
        "\n[stepper_{}]\narm_length: {}\nangle: {}\n", tower, exactly(now["rod_" + tower]),
        exactly(angle_deg));
    // The end stop stays where it is on its tower; what its height means has changed.
    const double carriage_mm = now["stop_" + tower] - nominal["stop_" + tower];
    const double more_mm = carriage_mm + change.height_mm - (now.up(tower) - nominal.up(tower));
    text +=
        options.endstops_mm.empty()
            ? fmt::format("# position_endstop: yours plus {}\n", exactly(more_mm))
            : fmt::format("position_endstop: {}\n", exactly(options.endstops_mm[i] + more_mm));
  }
  return text;
}

}  // namespace

extern constinit const ExportFormat klipper_format;
constinit const ExportFormat klipper_format{
    .name = "klipper",
    .in_words = "Klipper's delta",
    .about = "the block of a linear delta in printer.cfg",
    .file_name = "delta.cfg",
    .hold = hold,
    .write = write};

}  // namespace sixdial::report
