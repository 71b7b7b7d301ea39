// Two calibrated sessions of one robot side by side: as found and as left, last year and today.
#pragma once

#include <string>
#include <vector>

#include "report/document.h"
#include "session/session.h"
#include "studies/error.h"
#include "studies/json.h"

namespace sixdial::report {

/// A session and its "sixdial.calibration" document.
struct Calibrated {
  const Json& document;
  const session::Session& session;
};

/// Errors before and after of both, parameters with the change against its uncertainty, and how
/// far the tool stands elsewhere at the same joint angles. Throws Error bad_data where a
/// document is no calibration.
[[nodiscard]] std::vector<report::Section> against_sections(
    const Calibrated& here, const Calibrated& other);

}  // namespace sixdial::report
