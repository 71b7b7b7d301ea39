// A validation in words: what was commanded how, and the error really reached.
#pragma once

#include <string>

#include "studies/validate.h"

namespace sixdial::report {

/// "after kinematics + ANFIS".
/// `calibration_method`: where it is not the paper's.
[[nodiscard]] std::string compensation_name(
    studies::CompensateBy by, const std::optional<std::string>& calibration_method = {});
/// The table for people: mean, std and max for each way, and what was predicted.
[[nodiscard]] std::string validation_text(const studies::ValidationResult& result);

}  // namespace sixdial::report
