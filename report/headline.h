// What a calibration comes to in one line: the state of the robot, for the screen, for the
// document's "state" and, with what the session shows, for the report.
//
// Example:
//   const studies::CalibrationResult result = studies::calibrate(session, {.method = "lm"});
//   const Verdict v = verdict_of(result);
//   state_name(v.state);  // -> "calibrated"
#pragma once

#include <string>
#include <vector>

#include "report/verdict.h"
#include "studies/calibration_result.h"

namespace sixdial::report {

/// What of a report rests on the result alone.
[[nodiscard]] ReportData headline_data(const studies::CalibrationResult& result);
[[nodiscard]] Verdict verdict_of(const studies::CalibrationResult& result);
/// Title and sentence, then what speaks against the session: the first lines on the screen.
[[nodiscard]] std::string headline_text(const studies::CalibrationResult& result);
/// Whether a command that gave this state ends well: false for what must not be used.
[[nodiscard]] bool may_be_used(CalibrationState state);

}  // namespace sixdial::report
