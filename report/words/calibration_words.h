// What people read of a calibration on the screen.
#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "studies/calibration_result.h"

namespace sixdial::report {

/// Table 6 as text: before, the parameters alone, with the residual model, for G1 and G2; mean,
/// std, max [mm].
[[nodiscard]] std::string table_6_text(const studies::CalibrationResult& result);

/// How far the tool's turn is off before and after, a sentence a set; none where it was not
/// measured.
[[nodiscard]] std::vector<std::string> turn_lines(const studies::CalibrationResult& result);

/// "DQPSO is 1.2e-09 mm above the least-squares minimum; seed 1, 2.1 s".
[[nodiscard]] std::string effort_line(const studies::CalibrationResult& result);

/// "the robot's parameters leave 0.4 mm where the rig file says that 0.003 mm is the noise (133
/// times as much): ..."; empty where nothing contradicts the rig file.
[[nodiscard]] std::optional<std::string> far_from_noise_line(
    const calibration::NoiseEstimate& noise);

/// When the paper's networks reached their target error, and whether they stopped there. Empty
/// without trained networks.
[[nodiscard]] std::optional<std::string> training_line(
    const studies::CalibrationResult& result);

/// What the data can tell, a sentence a line.
[[nodiscard]] std::vector<std::string> assessment_lines(const studies::Assessment& assessment);
[[nodiscard]] std::vector<std::string> gross_error_lines(const studies::GrossErrors& errors);
/// `space`: what was fitted, "positions" or "dials".
[[nodiscard]] std::string precision_line(
    const studies::Precision& precision, std::string_view space = "positions");

/// "condition number by working mode: ++ 379 (50 samples), -+ 402 (50); pooled 151"; empty for
/// one mode.
[[nodiscard]] std::string working_modes_line(
    const std::vector<studies::WorkingModeRow>& modes, double pooled_condition);

}  // namespace sixdial::report
