// Two calibrated sessions of one robot side by side: as found and as left, last year and today.
#pragma once

#include <string>
#include <vector>

#include "report/document.h"
#include "session/session.h"
#include "studies/calibration_result.h"

namespace sixdial::report {

/// A session and what its calibration found.
struct Calibrated {
  const studies::CalibrationResult& result;
  const session::Session& session;
};

/// Errors before and after of both, parameters with the change against its uncertainty, and how
/// far the tool stands elsewhere at the same joint angles.
[[nodiscard]] std::vector<report::Section> against_sections(
    const Calibrated& here, const Calibrated& other);

}  // namespace sixdial::report
