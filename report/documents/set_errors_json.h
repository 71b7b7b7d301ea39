// Position errors over a set, as calibrations have them and validations quote them.
#pragma once

#include "report/documents/fields.h"
#include "studies/calibration_result.h"

namespace sixdial::report {

template <class Fields>
void describe_keys(Fields& at, Of<Fields, studies::SetErrors>& errors) {
  at("mean_mm", errors.mean_mm);
  at("std_mm", errors.std_mm);
  at("max_mm", errors.max_mm);
  at("rmse_mm", errors.rmse_mm);
  at("mean_low_mm", errors.mean_low_mm);
  at("mean_high_mm", errors.mean_high_mm);
  at("points", errors.points);
  at("unreachable", errors.unreachable);
}

}  // namespace sixdial::report
