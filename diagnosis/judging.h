// A model that was fitted to a part of a session, judged on the rest of it: shared by the table
// of the gain (gain.h) and the choice among models (model_choice.h).
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <optional>
#include <stop_token>
#include <string_view>
#include <vector>

#include "calibration/residual_model.h"
#include "diagnosis/gain.h"

namespace sixdial::diagnosis {

/// The residual model that learns on top of a fit, by its name in calibration/residual_model.h.
inline constexpr std::string_view kModelOnTop = "anfis";

/// A fitted model's answer to other readings of the same session. Smooth functions were fitted
/// at the other readings and are not carried over.
[[nodiscard]] JointFit applied(const Readings& readings, const JointFit& fitted);

/// Robot and causes of `extended` fitted to a part of the readings. A cause that this part
/// cannot determine gets the size 0: the size from all readings would have been learned from
/// those that are judged.
/// Curves of dials and joints are fitted anew and come last. `plain`: what it is without
/// causes.
[[nodiscard]] JointFit extended_on(
    const Readings& fitted, const JointFit& extended, const std::vector<OwnCurve>& curves,
    const JointFit& plain);

/// 0 for each judged reading that `extended`, the fit to all of the session, calls gross and
/// that is more than five standard deviations off, else 1. Every model is judged on the same
/// readings.
[[nodiscard]] Eigen::VectorXd weights_to_judge(
    const Readings& all, const JointFit& extended, const Readings& judged, double s_mm);

/// Numbers of the samples to judge. Those with a gross reading say nothing about the robot and
/// are only counted, in `excluded`.
[[nodiscard]] std::vector<std::size_t> poses_to_judge(
    const Readings& judged, const Eigen::VectorXd& weight, int& excluded);

/// A network on joint angles for what the model leaves of the readings; empty with too few
/// samples.
[[nodiscard]] std::optional<calibration::TrainedResidual> trained_on(
    const Readings& readings, const JointFit& fit, std::uint64_t seed,
    const std::stop_token& stop);

/// One side of the comparison: where a model is fitted and judged.
struct Side {
  const FittedAndJudged& readings;
  const Eigen::VectorXd& weight;  // on the judged ones
};

/// A model's errors on the judged readings.
struct Judged {
  GainModel model;
  bool network;
  std::optional<Hypothesis> without;
  const Readings* readings;
  Eigen::VectorXd error_mm;  // by pose
  Eigen::VectorXd residual_mm;
};

[[nodiscard]] Judged judged_on(
    const Side& side, const std::vector<std::size_t>& poses, const JointFit& fit,
    const calibration::TrainedResidual* network);

}  // namespace sixdial::diagnosis
