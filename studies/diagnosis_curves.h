// The curves behind a diagnosis, as JSON that a report can draw long after: what each sample
// says of a cause if the model leaves it out, beside the fitted cause; and what is left by
// covariate, before and after.
#pragma once

#include "diagnosis/identify.h"
#include "studies/error.h"
#include "studies/json.h"

namespace sixdial::studies {

/// The fits of a verdict on the readings as they were explained.
struct DiagnosedReadings {
  const diagnosis::Readings& readings;  // exchanged dials set right
  const diagnosis::JointFit& before;    // robot alone
  const diagnosis::JointFit& after;     // with the causes
  Eigen::VectorXd left_mm;              // robot and named causes alone
  bool has_unknown = false;             // after.residual_mm is less something smooth
};

/// {quantity, unit, covariate, covariate_unit, is_function, panels [{title, groups [{name, x,
/// measured, model}]}]} of after.effects[i]; null where nothing can be drawn. A joint's effect
/// as an error of its angle [deg], the robot's as a shift of the tool [mm], a dial's as its
/// residual [mm].
[[nodiscard]] Json signature_of(const DiagnosedReadings& data, std::size_t i);
/// The same for exchanged dials: readings as they came against what the simulation says.
[[nodiscard]] Json signature_of_swap(
    const DiagnosedReadings& data, const diagnosis::Hypothesis& swap);

/// [{covariate, unit, kind: "number" | "class", at [], label [], readings [], before_mm [],
/// after_mm [], smooth_mm []}]: RMS of the good readings; smooth_mm: less the smooth part that
/// nobody named, where there is one.
[[nodiscard]] Json left_by_covariate(const DiagnosedReadings& data);
/// By sample: {sample, x_mm, y_mm, before_mm [dx, dy], after_mm [dx, dy]} in columns.
[[nodiscard]] Json tool_shifts(const DiagnosedReadings& data);

}  // namespace sixdial::studies
