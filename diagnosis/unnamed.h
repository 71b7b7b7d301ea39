// What a robot has besides its named causes. Gears run out a little, links grow, a base creeps:
// each too little to be named, and much of it taken over by the fitted lengths, which are then
// off by far more than noise moves them. How large such things are on this robot is asked of
// all causes at once, the named ones among them (empirical Bayes): where nothing shows, they
// are small, and where several show, the others are taken to be as large. What the readings say
// of each is kept.
//
//   const Eigen::MatrixXd C = unnamed_columns(readings, fit);  // C C' joins the covariance
#pragma once

#include <Eigen/Core>

#include "diagnosis/joint_fit.h"

namespace sixdial::diagnosis {

/// Change of each reading [mm] for one standard deviation of each parameter of each cause of
/// the robot that `fit` does not name: readings x parameters. No column where all are nil.
[[nodiscard]] Eigen::MatrixXd unnamed_columns(const Readings& readings, const JointFit& fit);

/// How large causes are on one robot, in their plausible sizes: `size` and `sd` of each.
struct SizesOnARobot {
  Eigen::VectorXd scale;   // grid, 0 first
  Eigen::VectorXd weight;  // of each: 1 together
};
[[nodiscard]] SizesOnARobot sizes_on_a_robot(
    const Eigen::VectorXd& size, const Eigen::VectorXd& sd);

}  // namespace sixdial::diagnosis
