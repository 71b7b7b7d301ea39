// A session in, a calibration result out: the same code for the service's job and for
// `sixdial calibrate BUNDLE`. The result is one JSON document that says what it was made from
// (session, hashes, seed, settings, version), so that every figure can be computed again.
#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <stop_token>
#include <string>
#include <vector>

#include "calibration/pipeline.h"
#include "session/session.h"
#include "studies/error.h"
#include "studies/json.h"
#include "studies/progress.h"

namespace sixdial::studies {

inline constexpr int kCalibrationSchemaVersion = 1;

struct CalibrationRequest {
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
  bool keep_gross_errors = false;   // list readings that stand out, but fit them too
};

/// "sixdial.calibration": inputs, parameters [mm, rad], identification, methods (Table 6),
/// convergence, traces, anfis, points with their residuals by method. Throws Error: bad_data
/// (too few samples, poses out of reach), cancelled.
[[nodiscard]] Json calibrate(
    const session::Session& session, const CalibrationRequest& request,
    const ProgressCallback& progress = {}, std::stop_token stop = {});

/// The document without its long lists (points, convergence, traces, networks).
[[nodiscard]] Json result_summary(const Json& document);

/// Table 6 as text: before, EKF-DQPSO, EKF-DQPSO + ANFIS for G1 and G2, mean, std, max [mm].
[[nodiscard]] std::string table_6_text(const Json& document);

/// "EKF-DQPSO + ANFIS" for "ekf_dqpso+anfis".
[[nodiscard]] std::string method_name(const std::string& id);

}  // namespace sixdial::studies
