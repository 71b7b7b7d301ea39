// What a robot has besides its named causes. Gears run out a little, links grow, a base creeps:
// each too little to be named, but much of it is taken over by the fitted lengths, which are
// then off by far more than noise moves them. How large such things are on this robot is
// learned from all its lasting causes at once, the named ones among them (empirical Bayes):
// where none shows, all are taken to be small; where some show, those that do not may be as
// large. Each size is then updated by what the readings say of it. Causes of dials, of the
// rig's geometry and single knocks are not counted here: these are in the fit by themselves.
//
//   const Eigen::MatrixXd C = unnamed_columns(readings, fit);  // C C' joins the covariance
#pragma once

#include <Eigen/Core>

#include "diagnosis/joint_fit.h"

namespace sixdial::diagnosis {

/// One column for each parameter of each cause of the robot that `fit` does not name: the
/// change of each reading [mm] where that parameter has the size that is expected of it, root
/// mean square. Readings x parameters; no columns where the robot is likelier without any.
[[nodiscard]] Eigen::MatrixXd unnamed_columns(const Readings& readings, const JointFit& fit);

/// How large causes are on one robot: a few common scales and how probable each is. One scale
/// stands for sizes of about a Cauchy law of that width; none (0) is as probable before the
/// data as all others together.
struct SizesOnARobot {
  Eigen::VectorXd scale;   // in plausible sizes (EffectParameter::sigma); the first is 0
  Eigen::VectorXd weight;  // probability of each scale; they add up to 1
};
/// From the fitted size of each cause and its standard deviation, in plausible sizes.
[[nodiscard]] SizesOnARobot sizes_on_a_robot(
    const Eigen::VectorXd& size, const Eigen::VectorXd& sd);

}  // namespace sixdial::diagnosis
