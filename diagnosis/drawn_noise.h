// What noise alone would leave after a fit, drawn many times.
#pragma once

#include <Eigen/Core>

#include "diagnosis/joint_fit.h"

namespace sixdial::diagnosis {

struct DrawnNoise {
  /// Of the size that the fit leaves, weighted and off everything fitted; the same for every
  /// fit of as many readings and random columns.
  DrawnNoise(const Projector& projector, Eigen::Index draws);

  Eigen::MatrixXd rows;        // readings x draws
  Eigen::RowVectorXd squares;  // of each draw, with those of the fit's random columns
};

}  // namespace sixdial::diagnosis
