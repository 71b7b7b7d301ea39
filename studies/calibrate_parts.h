// The two ways that a calibration can go: the paper's, with all that its figures show, and any
// other identifier with any residual model. calibrate.cpp prepares the data and judges what
// comes out.
#pragma once

#include <functional>
#include <span>
#include <stop_token>
#include <string>
#include <string_view>
#include <vector>

#include "calibration/comparison.h"
#include "studies/calibrate.h"

namespace sixdial::studies {

/// What is fitted (G1) and judged (G2), made once from the session.
struct CalibrationData {
  const session::Session& session;
  calibration::ObservationSpace g1, g2;  // of positions
};

/// A row of Table 6 as a model: its parameters, and what its residual model adds to the
/// position. `targets`: errors are measured minus target instead of measured minus model.
struct ModelledRow {
  Eigen::VectorXd v{};
  std::function<Eigen::VectorXd(const Eigen::VectorXd& joints)> correction{};  // empty: none
  bool targets = false;
};

[[nodiscard]] std::optional<SetErrors> set_errors(const calibration::ErrorStats& stats);

[[nodiscard]] Identification identification_of(
    double sigma_mm, int degrees_of_freedom, const Eigen::MatrixXd& covariance,
    const calibration::Identifiability& known, std::span<const std::string_view> names);

/// Residuals of all points of G1, then of G2, one column for each row.
[[nodiscard]] std::vector<PointResiduals> point_residuals(
    const CalibrationData& data, const std::vector<ModelledRow>& rows);

[[nodiscard]] calibration::ResidualSettings residual_settings(
    const calibration::PipelineSettings& settings);

/// Throws StudyError bad_data or cancelled.
/// `hint`: what to do first; empty: measure more.
[[noreturn]] void refuse(
    const calibration::Trouble& trouble, const std::string& session,
    const std::optional<std::string>& hint = std::nullopt);

/// `fraction`: of the whole, 0 to 1. `iteration` of `iterations` of a search, 0 of 0: none.
using TellFraction = std::function<void(
    const std::string& stage, double fraction, int iteration, int iterations, double best_mm)>;

/// Everything but inputs, assessment, precision and gross errors.
[[nodiscard]] CalibrationResult calibrate_by_paper(
    const CalibrationData& data, const calibration::PipelineSettings& settings,
    const TellFraction& tell, const std::stop_token& stop);
/// `reference`: the least-squares fit of the same data.
[[nodiscard]] CalibrationResult calibrate_by_method(
    const CalibrationData& data, const calibration::MethodChoice& method,
    const calibration::PipelineSettings& settings,
    const calibration::IdentifySettings& identify, const calibration::Identified& reference,
    const TellFraction& tell, const std::stop_token& stop);

}  // namespace sixdial::studies
