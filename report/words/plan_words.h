// What a plan is worth, in a sentence.
#pragma once

#include <string>

#include "studies/next_plan.h"
#include "studies/separation_plan.h"

namespace sixdial::report {

/// "12 samples of G1: ... with these 10 (I-optimal): ...".
[[nodiscard]] std::string next_plan_text(const studies::NextPlanFigures& figures);
/// What comes apart, and how surely.
[[nodiscard]] std::string separation_text(const studies::SeparationFigures& figures);

}  // namespace sixdial::report
