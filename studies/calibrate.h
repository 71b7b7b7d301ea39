// A session in, a calibration result out: the same code for the service's job and for
// `sixdial calibrate BUNDLE`. The result says what it was made from (session, hashes, seed,
// settings, version), so that every figure can be computed again.
//
// Example:
//   const CalibrationResult result = calibrate(session, {.method = "lm+gp"});
//   const MethodRow* row = result.method(result.result_method);  // its errors on G1 and G2
//   show(row->g2->mean_mm);
//   result.method("before")->g2->mean_mm > row->g2->mean_mm;  // -> true
#pragma once

#include <cstdint>
#include <optional>
#include <stop_token>
#include <string>
#include <vector>

#include "session/session.h"
#include "studies/calibration_result.h"
#include "studies/progress.h"

namespace sixdial::studies {

struct CalibrationRequest {
  /// Any identifier, alone or with any residual model after a '+'.
  std::string method{kPaperMethod};
  calibration::Profile profile = calibration::Profile::kDefault;
  std::uint64_t seed = 1;
  int threads = 0;  // 0: as many as the machine has; the result does not depend on it
  // Instead of the paper's 50x100, 50x400 and 500.
  std::optional<int> particles{};
  std::optional<int> qpso1_iterations{};
  std::optional<int> qpso2_iterations{};
  std::optional<int> anfis_epochs{};
  std::vector<std::string> fix{};   // parameters that keep their nominal value
  std::vector<std::string> free{};  // where not empty: only these are fitted
  /// Largest position error that is accepted; empty: the rig file's, if it states one.
  std::optional<double> tolerance_mm{};
  bool keep_gross_errors = false;  // list readings that stand out, but fit them too
};

/// Throws StudyError: invalid_params (a method or parameter that there is not, with the
/// nearest), bad_data (too few samples, poses out of reach), cancelled.
[[nodiscard]] CalibrationResult calibrate(
    const session::Session& session, const CalibrationRequest& request,
    const ProgressCallback& progress = {}, std::stop_token stop = {});

}  // namespace sixdial::studies
