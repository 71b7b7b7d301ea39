// A stored result whose data nobody has judged: versions before plausibility.h did not look.
// What they calibrated stays readable, and is called no more than is known: its session is
// judged now, wherever it is at hand.
#pragma once

#include <string_view>

#include "session/session.h"
#include "studies/calibration_result.h"
#include "studies/diagnosis_result.h"

namespace sixdial::studies {

/// Code of a warning: the result predates the plausibility check, and its session does not pass
/// that.
inline constexpr std::string_view kMadeUnjudged = "made_unjudged";

/// Fills `warnings` where there are none and the session is the one that the result was made
/// from. What would be left out or put right today was not then, so that a result of a session
/// against which anything speaks is in doubt.
void judge_stored(CalibrationResult& stored, const session::Session& session);
void judge_stored(DiagnosisResult& stored, const session::Session& session);

}  // namespace sixdial::studies
