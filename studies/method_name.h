// A method by its id: "ekf_dqpso+anfis" is an identifier's row and a residual model's row. What
// tables call it is made from the titles of both.
#pragma once

#include <string>
#include <string_view>

#include "calibration/comparison.h"

namespace sixdial::studies {

/// "EKF-DQPSO + ANFIS" for "ekf_dqpso+anfis", "before calibration" for "before"; a part that
/// has no row stands as it is.
[[nodiscard]] std::string method_name(std::string_view id);

/// "ekf_dqpso" of "ekf_dqpso+anfis": the method that leaves the residual model out.
[[nodiscard]] std::string without_residual_model(std::string_view id);

/// Throws StudyError invalid_params, with the nearest, for a method or combination that does
/// not exist. `param`: what the error calls the parameter.
[[nodiscard]] calibration::MethodChoice chosen_method(
    const std::string& id, const std::string& param);

}  // namespace sixdial::studies
