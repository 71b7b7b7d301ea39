// Which model commands the robot best, by the points that are fitted alone (G1): its poses are
// dealt into folds, each fold is predicted by models that were fitted to the others. G2 has no
// part in it.
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <stop_token>
#include <vector>

#include "diagnosis/gain.h"

namespace sixdial::diagnosis {

inline constexpr int kChoiceFolds = 5;

/// One model's position errors [mm] on poses that its fold did not fit; NaN where a pose is out
/// of reach.
struct CandidateErrors {
  GainModel model = GainModel::kCalibrated;
  bool network = false;
  Eigen::VectorXd error_mm;  // sample by sample, the same for all candidates
};

/// "calibrated" and "extended", with and without a network; fewer where there is no cause, or
/// too little to train on. Empty where the folds leave too little to fit, or after a stop.
/// `question.explained.fitted` is dealt into folds; its `judged` is not looked at.
[[nodiscard]] std::vector<CandidateErrors> cross_validated(
    const GainQuestion& question, const GainSettings& settings,
    const std::stop_token& stop = {});

}  // namespace sixdial::diagnosis
