// What the simulation gets wrong on one session, and why (spec 4), as the document
// "sixdial.diagnosis". The same code for the service's job and for `sixdial diagnose BUNDLE`.
#pragma once

#include <cstdint>
#include <functional>
#include <stop_token>
#include <string>
#include <vector>

#include "session/session.h"
#include "studies/error.h"
#include "studies/json.h"
#include "studies/progress.h"

namespace sixdial::studies {

inline constexpr int kDiagnosisSchemaVersion = 1;

struct DiagnosisRequest {
  std::uint64_t seed = 1;
  /// Draws of the simulated null; ten times as many of the poses behind the gain's intervals.
  int bootstrap = 200;
  bool with_gain = true;  // trains networks
};

/// "sixdial.diagnosis": causes, unexplained, not_testable, detection_limits, baseline,
/// extended, gain as spec 4 has them, and verdict, noise, dependence, gross_readings, residuals
/// (measured minus simulated of every reading, before and after), by_covariate, tool_shift,
/// extended_model. Numbers that are not finite are null. Throws Error: bad_data (too few
/// readings), cancelled.
[[nodiscard]] Json diagnose(
    const session::Session& session, const DiagnosisRequest& request,
    const ProgressCallback& progress = {}, std::stop_token stop = {});

/// Throws Error bad_data for a document that is no diagnosis of this version.
void check_diagnosis(const Json& document);

}  // namespace sixdial::studies
