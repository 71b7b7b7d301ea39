// Models as a calibration or a diagnosis leaves them, of every kind of robot.
#pragma once

#include <Eigen/Core>
#include <memory>
#include <string>
#include <vector>

#include "geometry/robots/serial.h"
#include "studies/exported_model.h"
#include "tests/report/run_program.h"

namespace sixdial::studies {

/// A rig with this robot: the five-bar on six dials, any other under an instrument that
/// measures positions.
[[nodiscard]] geometry::Rig rig_with(std::shared_ptr<const geometry::RobotModel> robot);
[[nodiscard]] std::shared_ptr<const geometry::RobotModel> example_of(const char* kind);
/// Universal Robots' UR10; a Panda by Craig's rows; an arm of URDF rows with slanted axes, a
/// slide and a joint that follows another one.
[[nodiscard]] std::shared_ptr<const geometry::RobotModel> ur10(bool tool_is_frame = false);
[[nodiscard]] std::shared_ptr<const geometry::RobotModel> panda();
[[nodiscard]] std::shared_ptr<const geometry::RobotModel> slanted_arm();

/// Parameters moved by their plausible changes, drawn; `poses` poses that it reaches.
[[nodiscard]] ExportedModel made_model(
    std::shared_ptr<const geometry::RobotModel> robot, int poses = 120);
/// The same with these effects.
[[nodiscard]] ExportedModel with_effects(
    ExportedModel model, std::vector<simulation::ActiveEffect> effects);
/// Numbers that bend by three plausible sizes; of a curve two waves over the joint's range.
[[nodiscard]] std::vector<double> three_sizes_of(
    const simulation::Effect& effect, const simulation::Place& place);

/// Poses as they would be commanded at several times, temperatures and sides.
[[nodiscard]] std::vector<ModelPose> moments_of(const ExportedModel& model);

/// The numbers of a text, as a program printed them.
[[nodiscard]] std::vector<std::vector<double>> numbers_in(const std::string& text);

}  // namespace sixdial::studies

namespace sixdial::report {

inline void put(
    const TemporaryFolder& folder, const std::string& name, const std::string& text) {
  static_cast<void>(folder.write(name, text));
}

}  // namespace sixdial::report
