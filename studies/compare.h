// All methods on one session: Table 6 for G1 and G2 with times, what the data can tell, which
// readings stand out. The same code for the service's job and for `sixdial compare BUNDLE`.
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

inline constexpr int kComparisonSchemaVersion = 1;

struct CompareRequest {
  std::vector<std::string> methods{};  // empty: calibration::kComparedMethods
  std::string space = "positions";     // or "dials"
  std::vector<std::string> fix{};      // parameters that keep their nominal value
  std::vector<std::string> free{};     // where not empty: only these are fitted
  std::string loss = "square";         // of lm: "huber", "cauchy"
  std::string profile = "default";     // "paper": filter linear at nominal, raw search
  bool keep_gross_errors = false;      // list them only
  std::uint64_t seed = 1;
  int threads = 0;  // 0: as many as the machine has; the result does not depend on it
  // Instead of 50x100, 50x400, 500 and 40000.
  int particles = 0, qpso1_iterations = 0, qpso2_iterations = 0, anfis_epochs = 0,
      bpnn_epochs = 0;
};

/// "sixdial.comparison". Throws Error: invalid_params (an unknown method or parameter, with the
/// nearest), bad_data, cancelled.
[[nodiscard]] Json compare(
    const session::Session& session, const CompareRequest& request,
    const ProgressCallback& progress = {}, std::stop_token stop = {});

/// Throws Error invalid_params for a method or combination that does not exist.
void check_methods(const std::vector<std::string>& methods);

/// Table 6 of the document as text, times beside it.
[[nodiscard]] std::string comparison_text(const Json& document);

}  // namespace sixdial::studies
