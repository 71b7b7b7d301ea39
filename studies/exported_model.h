// A calibrated robot, or one extended by the named causes of a diagnosis, as it is given to
// other programs: everything that says where its tool is, and the session's poses to try a copy
// at. What each format makes of it: report/export/.
//
// Example:
//   const CalibrationResult result = calibrate(session, {.method = "lm"});
//   const ExportedModel model = exported_model(result, session);
//   const ModelPose& pose = model.poses.front();
//   const auto at = tool_pose(model, pose);
//   if (at) show(at->p);  // p_WE [mm]
//   miss_between(model, model).max_mm;  // -> 0.0
#pragma once

#include <Eigen/Core>
#include <memory>
#include <optional>
#include <string>
#include <tl/expected.hpp>
#include <vector>

#include "calibration/compensation.h"
#include "geometry/registration.h"
#include "session/session.h"
#include "simulation/effect.h"
#include "simulation/forward_model.h"
#include "studies/calibration_result.h"
#include "studies/compensate_by.h"
#include "studies/diagnosis_result.h"

namespace sixdial::studies {

/// Joint values of the session, and what was known of them.
struct ModelPose {
  Eigen::VectorXd q;  // [rad, mm]
  geometry::Assembly assembly{};
  simulation::Circumstance sample{};
};

struct ExportedModel {
  CompensateBy by = CompensateBy::kKinematics;  // or kExtended
  Inputs inputs{};                              // of the result that it was made from
  std::string created_utc{};                    // of that result
  /// Of the session's rig; not null.
  std::shared_ptr<const simulation::ForwardModel> base{};
  simulation::ModelVector model{};                  // the robot's parameters, the instrument's
  Eigen::VectorXd nominal{};                        // of the robot
  std::vector<simulation::ActiveEffect> effects{};  // in the order in which they act
  /// What a residual model learned beside this: no part of the model, and told as such. Empty:
  /// nothing.
  calibration::Correction learned{};
  std::optional<StoredResidualModel> residual_model{};  // that it comes from,
  std::optional<Networks> networks{};                   // or these of the paper's method
  std::string learned_by{};                             // "gp", "anfis"
  // As the last sample knew it; what depends on them is commanded so unless something else is
  // said.
  int order = 0;
  double time_h = 0.0;
  double temperature_degC = 20.0;
  /// From the frame of the rig file, where targets are meant, to that of the model; empty: the
  /// same.
  std::optional<geometry::Similarity> frame{};
  std::vector<ModelPose> poses{};  // of the session, in time order

  [[nodiscard]] const geometry::RobotModel& robot() const { return base->robot(); }
  [[nodiscard]] Eigen::VectorXd parameters() const {
    return model.head(base->robot_parameter_count());
  }
};

/// The robot as calibrated: kKinematics. Throws StudyError bad_data where the result does not
/// belong to this rig.
[[nodiscard]] ExportedModel exported_model(
    const CalibrationResult& result, const session::Session& session);
/// Robot and named causes: kExtended. Throws the same.
[[nodiscard]] ExportedModel exported_model(
    const DiagnosisResult& result, const session::Session& session);

/// A pose that is commanded at the end of the session, no dial touching. `approach`: sign of
/// each joint's last move, empty: unknown.
[[nodiscard]] ModelPose commanded_pose(
    const ExportedModel& model, const Eigen::VectorXd& q, geometry::Assembly assembly,
    const std::vector<double>& approach = {});

/// Where the model has the tool, and how it is turned.
[[nodiscard]] tl::expected<geometry::Pose<double>, geometry::KinematicTrouble> tool_pose(
    const ExportedModel& model, const ModelPose& pose);

/// How far two models have the tool apart, over the session's poses that both reach.
struct MissBetween {
  double mean_mm = 0.0, max_mm = 0.0;
  int poses = 0;
};
/// At the poses of `full`.
[[nodiscard]] MissBetween miss_between(const ExportedModel& full, const ExportedModel& held);
/// What `learned` adds, over the same poses; nothing where there is none.
[[nodiscard]] MissBetween learned_part(const ExportedModel& model);

}  // namespace sixdial::studies
