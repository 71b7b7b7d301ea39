// The requests of the studies as parameters of their methods (calibrate.start, compare.start),
// and read again: the command line writes them, the service reads them. A key that is left out
// keeps the request's own default.
#pragma once

#include "service/error.h"
#include "studies/calibrate.h"
#include "studies/compare.h"
#include "studies/diagnose.h"

namespace sixdial::service {

[[nodiscard]] Json params_of(const studies::CalibrationRequest& request);
[[nodiscard]] Json params_of(const studies::CompareRequest& request);
[[nodiscard]] Json params_of(const studies::DiagnosisRequest& request);

/// `params`: checked against the method's row.
[[nodiscard]] studies::CalibrationRequest calibration_request(const Json& params);
[[nodiscard]] studies::CompareRequest comparison_request(const Json& params);
[[nodiscard]] studies::DiagnosisRequest diagnosis_request(const Json& params);

}  // namespace sixdial::service
