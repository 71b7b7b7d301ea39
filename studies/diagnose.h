// What the simulation gets wrong on one session, and why (doc/diagnosis.md). The same code for
// the service's job and for `sixdial diagnose BUNDLE`.
//
// Example:
//   const DiagnosisRequest request{.seed = 7, .bootstrap = 0, .with_gain = false};  // quick
//   const DiagnosisResult result = diagnose(session, request);
//   for (const FoundCause& cause : result.causes) show(cause.id.name());
#pragma once

#include <cstdint>
#include <stop_token>

#include "session/session.h"
#include "studies/diagnosis_result.h"
#include "studies/error.h"
#include "studies/progress.h"

namespace sixdial::studies {

struct DiagnosisRequest {
  std::uint64_t seed = 1;
  /// Draws of the simulated null; ten times as many of the poses behind the gain's intervals.
  int bootstrap = 200;
  bool with_gain = true;  // trains networks
  /// Of a longer session so many samples are drawn, and the result says so; 0: all are used,
  /// which takes the more time and memory.
  int most_samples = 1500;
  int threads = 0;  // 0: as many as the machine has; the result does not depend on it
};

/// Throws StudyError: bad_data (too few readings), cancelled.
[[nodiscard]] DiagnosisResult diagnose(
    const session::Session& session, const DiagnosisRequest& request,
    const ProgressCallback& progress = {}, std::stop_token stop = {});

}  // namespace sixdial::studies
