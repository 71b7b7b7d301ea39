// How a small error of unknown cause would show in every reading, depending on the stage
// between joint values and readings at which it enters.
#pragma once

#include <Eigen/Core>

#include "diagnosis/joint_fit.h"

namespace sixdial::diagnosis {

enum class Stage { kJointAngle, kTool, kCuboidAngle, kCuboidSide };

/// d(readings)/d(error at the stage), readings x 1; readings x axes for the tool.
/// `simulated_mm`: the model's answer at `at`. `joint` says which, at Stage::kJointAngle only.
[[nodiscard]] Eigen::MatrixXd stage_columns(
    const Readings& readings, const simulation::ModelVector& at,
    const simulation::ExtendedModel& extended, const Eigen::VectorXd& simulated_mm, Stage stage,
    int joint = -1);

}  // namespace sixdial::diagnosis
