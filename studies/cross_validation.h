// How well each model predicts poses of G1 that it was not fitted to. By this one is
// recommended (recommendation.h); G2 only reports.
#pragma once

#include <optional>
#include <span>
#include <stop_token>
#include <string>
#include <vector>

#include "calibration/comparison.h"
#include "session/session.h"
#include "simulation/trial.h"
#include "studies/compensate_by.h"

namespace sixdial::studies {

/// Position errors [mm] of one model, sample by sample; NaN where a pose is out of its reach.
struct CheckedModel {
  CompensateBy by = CompensateBy::kKinematics;
  std::vector<double> error_mm{};  // of the same samples for all models
};

/// Poses of G1 are dealt into folds, with all their repeats; each fold is predicted by models
/// that were fitted to the others.
struct CrossValidation {
  int folds = 0;
  std::string residual_model{};  // that kFull and kExtendedFull use; empty: none
  std::vector<CheckedModel> models{};

  [[nodiscard]] const CheckedModel* of(CompensateBy by) const;
};

/// Of samples that every model of `checked` reaches, the mean error of one.
struct MeanError {
  double mean_mm = 0.0;
  int samples = 0;
};
[[nodiscard]] std::optional<MeanError> mean_error(
    const CrossValidation& checked, CompensateBy by);

/// Mean error of one model less that of another, sample by sample, and its standard error.
struct ErrorDifference {
  double mean_mm = 0.0, standard_error_mm = 0.0;
};
[[nodiscard]] std::optional<ErrorDifference> difference(
    const CrossValidation& checked, CompensateBy one, CompensateBy other);

/// The identifier of `method` alone, and with its residual model where it has one, on G1's
/// measured positions. At most 2000 poses are used. Empty where a fold leaves too few
/// samples to fit, or after a stop. `file_rig`: where the dials were fitted along, the rig as
/// its file says, so that each fold fits them anew; else null.
[[nodiscard]] std::optional<CrossValidation> cross_validated(
    std::span<const simulation::Trial> g1, const session::Session& session,
    const geometry::Rig* file_rig, const calibration::MethodChoice& method,
    const calibration::ComparisonSettings& settings, const std::stop_token& stop = {});

}  // namespace sixdial::studies
